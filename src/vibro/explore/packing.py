"""Binary messages to the page: a header in JSON, then arrays as they lie in memory."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

__all__ = ["pack"]

_ALIGNED: Final = 8  # bytes: arrays in JavaScript begin at multiples of the size of their numbers
_TYPES: Final = {"float32": "f4", "int8": "i1", "uint8": "u1", "uint16": "u2"}


def pack(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Pack a header and arrays.

    Parameters
    ----------
    header : mapping
        JSON values; no number in it may be NaN or infinite.
    arrays : mapping of str to array
        By name: float32, int8, uint8 or uint16.

    Returns
    -------
    bytes
        The length of the header as 4 bytes, little-endian; the header, a list ``arrays`` added to it that
        says of each name, type, shape and offset from the first array; the arrays. Header and arrays are
        filled up to multiples of 8 bytes.
    """
    described, parts, offset = [], [], 0
    for name, values in arrays.items():
        data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
        described.append(
            {"name": name, "type": _TYPES[values.dtype.name], "shape": values.shape, "offset": offset}
        )
        data += bytes(-len(data) % _ALIGNED)
        parts.append(data)
        offset += len(data)
    text = json.dumps({**header, "arrays": described}, allow_nan=False).encode()
    text += b" " * (-(len(text) + 4) % _ALIGNED)
    return b"".join([len(text).to_bytes(4, "little"), text, *parts])
