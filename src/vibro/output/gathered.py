"""Columns that are gathered from row groups: numbers, flags and texts, for arrays and for data frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import FileError, shown

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from vibro.results.sweep import Column

__all__ = ["Flags", "Gathered", "Numbers", "Texts", "gathering"]


class Numbers:
    """A column of numbers; missing ones are NaN."""

    bytes_per_cell: Final = 8

    def __init__(self, size: int) -> None:
        self.values: NDArray[np.float64] = np.empty(size)

    def put(self, place: int, found: Any) -> None:
        """Take over an Arrow array."""
        self.values[place : place + len(found)] = found.to_numpy()

    def of_frame(self, column: Column) -> Any:
        """Return what a data frame holds."""
        return self.values


class Flags:
    """A column of flags: 1, 0, or -1 if unknown."""

    bytes_per_cell: Final = 2

    def __init__(self, size: int) -> None:
        self.values: NDArray[np.int8] = np.empty(size, np.int8)

    def put(self, place: int, found: Any) -> None:
        """Take over an Arrow array."""
        self.values[place : place + len(found)] = found.fill_null(-1).to_numpy()

    def of_frame(self, column: Column) -> Any:
        """Return what a data frame holds."""
        import pandas as pd

        return pd.arrays.IntegerArray(self.values, self.values < 0)


class Texts:
    """A column of texts.

    Attributes
    ----------
    codes : int array
        Of every cell, an index into ``texts``.
    texts : dict of str to int
        Those that occur and their codes, ascending.
    """

    bytes_per_cell: Final = 10  # while codes of one kind become those of another

    def __init__(self, size: int) -> None:
        self.codes: NDArray[np.int32] = np.empty(size, np.int32)
        self.texts: dict[str, int] = {}

    def put(self, place: int, found: Any) -> None:
        """Take over an Arrow array, whose dictionary may be another in every row group."""
        for chunk in found.chunks:
            local = chunk.indices.to_numpy()
            used, which = np.unique(local, return_inverse=True)
            texts = chunk.dictionary.to_pylist()
            codes = [self.texts.setdefault(texts[i], len(self.texts)) for i in used.tolist()]
            self.codes[place : place + len(chunk)] = np.array(codes, np.int32)[which]
            place += len(chunk)

    def coded(self, column: Column) -> NDArray[np.int8]:
        """Return the codes of a column that lists its texts.

        Raises
        ------
        FileError
            If it does not list one of them.
        """
        unknown = [text for text in self.texts if text not in column.codes]
        if unknown:
            raise FileError(
                f"{column.name} = {shown(unknown[0])}: this version of vibro knows no such {column.name}",
                hint="read it with the version of vibro that wrote it",
            )
        return np.array([column.codes[text] for text in self.texts], np.int8)[self.codes]

    def of_frame(self, column: Column) -> Any:
        """Return what a data frame holds."""
        return _categorical(column, self.texts, self.codes)


Gathered = Numbers | Flags | Texts


def gathering(column: Column) -> type[Gathered]:
    """Return the object that gathers a column."""
    return Numbers if column.is_number else Flags if column.is_flag else Texts


def _categorical(column: Column, texts: Iterable[str], which: NDArray[np.integer[Any]]) -> Any:
    """Return texts as data frames have them.

    Parameters
    ----------
    column : Column
        If it lists its texts, all of them are categories, in the order of their codes, and behind them those
        that only another version of vibro knows; else those that occur, in the order of the alphabet.
    texts : iterable of str
        Those that occur, each once, or more.
    which : int array
        Which of ``texts`` each cell has.

    Returns
    -------
    pandas.Categorical
    """
    import pandas as pd

    texts = list(texts)
    categories = sorted(texts) if column.texts is None else list(dict.fromkeys([*column.texts, *texts]))
    codes = {text: code for code, text in enumerate(categories)}
    places = np.array([codes[text] for text in texts], np.intp)
    return pd.Categorical.from_codes(places[which], dtype=pd.CategoricalDtype(categories))
