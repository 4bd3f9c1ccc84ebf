"""Stems: what ``-o`` names, before the suffixes of the files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from vibro.errors import FileError, InputError
from vibro.output.names import PICTURE_FORMATS
from vibro.output.sinks import FORMS

__all__ = ["output_stem"]

_GIVE_A_NAME: Final = "give a name for the files, such as -o out/nut"
_SUFFIXES: Final = (*(f".{form}" for form in (*FORMS, *PICTURE_FORMATS)), ".json", ".html")


def output_stem(output: str | None, name: str, form: str = "csv") -> Path:
    """Find the stem of the output files.

    Parameters
    ----------
    output : str or None
        What the user gave: a stem, or a folder (it exists or ends in a separator), which takes ``name``.
    name : str
        The scene's name.
    form : str, optional
        Suffix of the table that is made.

    Returns
    -------
    Path
        Suffixes are appended to it.

    Raises
    ------
    InputError
        If it ends in the suffix of an output file, or is no name at all.
    FileError
        If it is something that a set of files cannot stand beside.
    """
    if output is None:
        return Path(name)
    path = Path(output)
    given = f"-o {output}"
    if not output:
        raise InputError("-o: the name is empty", hint=_GIVE_A_NAME)
    if "\0" in output:
        raise InputError(f"{given}: no name has the character NUL", hint=_GIVE_A_NAME)
    try:
        if output.endswith((os.sep, os.altsep or os.sep, f"{os.sep}.")) or path.is_dir():
            return path / name
        exists = path.exists()
    except OSError as exc:
        raise FileError(
            f"cannot use {given}: {exc.strerror or exc}", hint="choose another name with -o"
        ) from exc
    if path.name in ("", ".."):
        raise InputError(f"{given}: there is no such folder", hint=_GIVE_A_NAME)
    suffix = next((s for s in _SUFFIXES if path.name.casefold().endswith(s)), "")
    if path.suffix.casefold() == ".parquet":
        raise InputError(
            f"{given}: Parquet goes into a folder", hint=f"add --table parquet, and -o {path.with_suffix('')}"
        )
    if suffix:
        stem = output[: -len(suffix)]
        example = (
            f"write -o {stem}, which makes {stem}{suffix if suffix in ('.html', '.json') else f'.{form}'}"
            if path.name[: -len(suffix)] not in ("", ".")
            else ""
        )
        raise InputError(
            f"{given}: {suffix} is added to the name, as to those of all files", hint=example or _GIVE_A_NAME
        )
    if exists and not path.is_file():
        raise FileError(f"{given}: it is neither a file nor a folder", hint="-o - writes the table to stdout")
    return path
