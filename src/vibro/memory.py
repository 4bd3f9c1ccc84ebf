"""Setting of the C library's malloc: memory that vibro's own processes free is kept for reuse."""

from __future__ import annotations

import contextlib
import ctypes

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

__all__ = ["retain_freed_memory"]

# Of malloc.h: size from which a buffer is mapped by the system, and freed memory that is kept [B].
_M_TRIM_THRESHOLD: Final = -1
_M_MMAP_THRESHOLD: Final = -3
_MOST_RETAINED: Final = 32 << 20  # the largest that malloc takes, and would adapt to


def retain_freed_memory() -> None:
    """Have glibc's malloc keep freed temporaries for reuse in this whole process; elsewhere do nothing.

    Otherwise it returns them to the system after every step, and page faults take up to a fifth of the time
    of a sweep. The setting is one of the whole process: the command ``vibro`` and the workers that it starts
    call this, and no function that other programs may call.
    """
    with contextlib.suppress(AttributeError, OSError, TypeError):  # there is no such function
        set_option = ctypes.CDLL(None).mallopt
        set_option(_M_MMAP_THRESHOLD, _MOST_RETAINED)
        set_option(_M_TRIM_THRESHOLD, 2 * _MOST_RETAINED)
