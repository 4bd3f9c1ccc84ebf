"""Arrow arrays in the memory of NumPy's; ``pyarrow.array`` would import pandas, which takes 0.2 s."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pyarrow as pa
    from numpy.typing import NDArray


def number_array(
    values: NDArray[Any], shape: tuple[int, ...], known: NDArray[np.bool_] | None = None
) -> pa.Array:
    """Return numbers that broadcast to a shape as an Arrow array, with nulls where they are not known."""
    import pyarrow as pa

    cells = np.ascontiguousarray(np.broadcast_to(values, shape))
    mask = None
    if known is not None and not known.all():  # packed here, in a fraction of pyarrow's time
        mask = pa.py_buffer(np.packbits(np.broadcast_to(known, shape), bitorder="little"))
    return pa.Array.from_buffers(pa.from_numpy_dtype(cells.dtype), cells.size, [mask, pa.py_buffer(cells)])


def text_array(texts: Iterable[str]) -> pa.StringArray:
    """Return texts as an Arrow array."""
    import pyarrow as pa

    encoded = [text.encode() for text in texts]
    ends = np.cumsum([0, *map(len, encoded)], dtype=np.int32)
    return pa.StringArray.from_buffers(len(encoded), pa.py_buffer(ends), pa.py_buffer(b"".join(encoded)))
