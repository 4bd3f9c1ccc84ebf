"""Where glibc's malloc places large buffers: it tells whether its settings were changed."""

from __future__ import annotations

import ctypes
import sys

_LARGE = 31 << 20  # [B] more than glibc places on its heap by itself, less than it may be told to
_MAPPED = 3  # place of ``hblks``, the number of buffers that are mappings of their own, in ``mallinfo``


class _Mallinfo(ctypes.Structure):
    _fields_ = [(f"number_{i}", ctypes.c_int) for i in range(10)]


def is_glibc() -> bool:
    """Whether this process has glibc's malloc."""
    return sys.platform == "linux" and hasattr(ctypes.CDLL(None), "gnu_get_libc_version")


def keeps_large_buffers() -> bool:
    """Whether malloc has large buffers on its heap; by default each is a mapping that ``free`` gives back."""
    library = ctypes.CDLL(None)
    library.mallinfo.restype = _Mallinfo
    library.malloc.restype = ctypes.c_void_p
    library.free.argtypes = [ctypes.c_void_p]

    def mapped() -> int:
        return int(getattr(library.mallinfo(), f"number_{_MAPPED}"))

    before = mapped()
    buffer = library.malloc(_LARGE)
    assert buffer
    kept = mapped() == before
    library.free(buffer)
    return kept
