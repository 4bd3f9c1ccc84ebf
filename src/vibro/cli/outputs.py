"""What a run writes: ``-o`` names files, and their endings say what goes into them."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Self

from vibro.cli.forms import SERIES
from vibro.errors import FileError, InputError
from vibro.results.drawing import PICTURES

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.figure import Figure

    from vibro.answers.answer import Answer
    from vibro.cli.options import Options
    from vibro.files.csv_tables import CsvFormat, TableColumns

_OF_A_STEM: Final = ("csv", "json", "png")  # as far as a command can write them
_TEXTS: Final = ("html", "toml")
_GIVE_A_NAME: Final = "give a name for the files, such as -o out/nut"
_NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})


class Outputs:
    """Where tables, pictures and the record of a run go: files, all or none, and the table to stdout.

    To be entered before anything is computed: that refuses files that exist.

    Parameters
    ----------
    options : Options
        What ``-o`` says, and whether files are replaced; their files never are.
    name : str
        The files' name where the options name a folder.
    forms : sequence of str
        Endings of what the command can write.
    tables, pictures : sequence of str
        What is appended to a stem for each table, and for each picture; the first table bears the stem alone.
    reads : sequence of Path
        Further files that the run reads, which are never replaced.
    default : str, optional
        What is written without ``-o``.

    Attributes
    ----------
    takes_stdout : bool
        Whether stdout is for the table alone.
    folder : Path or None
        A folder of Parquet files.
    tables, pictures : dict of Path to tuple of str
        Name and form of each file.
    texts : dict of Path to str
        Form of each file that is one text: a page, a scene file.
    records : dict of Path to None
        Files that describe the run.
    record : dict
        What they say, once the run is finished.

    Raises
    ------
    InputError, FileError
        If a path is no name of a file, or its ending none that the command can write.
    """

    def __init__(
        self,
        options: Options,
        name: str,
        *,
        forms: Sequence[str] = SERIES,
        tables: Sequence[str] = ("",),
        pictures: Sequence[str] = ("",),
        reads: Sequence[Path] = (),
        default: str | None = None,
    ) -> None:
        self.options, self.takes_stdout = options, False
        self.folder: Path | None = None
        self.tables: dict[Path, tuple[str, str]] = {}
        self.pictures: dict[Path, tuple[str, str]] = {}
        self.texts: dict[Path, str] = {}
        self.records: dict[Path, None] = {}
        self.record: dict[str, Any] = {}
        self._written: list[Path] = []
        self._reads = (*options.files, *reads)
        has_record = len(forms) > 1  # a JSON that is alone is the answer itself
        for text in options.output or ([] if default is None else [default]):
            if text == "-":
                if "csv" not in forms and has_record:
                    raise InputError("-o -: this answer has no table", hint="--json prints it")
                if options.json:
                    raise InputError("--json and -o - both want stdout", hint="leave one of them out")
                self.takes_stdout = True
                continue
            # the name by default is no folder, though one may be called so
            path, form = _place(text, name, forms) if options.output else (Path(text), "")
            if form in PICTURES and not pictures:
                raise InputError(f"-o {text}: there is nothing to draw", hint="leave it out")
            if form in _TEXTS or not has_record:
                self.texts[path if form else _named(path, forms[0])] = form or forms[0]
            elif form == "parquet":
                self._set_folder(path)
            elif form:
                self._add(path.with_suffix(""), form, tables, pictures, path)
            else:
                for kind in (form for form in _OF_A_STEM if form in forms):
                    self._add(path, kind, tables, pictures)

        is_csv = self.takes_stdout or any(form == "csv" for _, form in self.tables.values())
        if options.decimal_comma and not is_csv:
            raise InputError("--decimal-comma: no CSV is written", hint="add -o NAME.csv, or leave it out")

    def _set_folder(self, path: Path) -> None:
        if self.folder not in (None, path):
            raise InputError(
                f"-o {self.folder} and -o {path}: a run makes one folder", hint="leave one of them out"
            )
        self.folder = path

    def _add(
        self, stem: Path, form: str, tables: Sequence[str], pictures: Sequence[str], alone: Path | None = None
    ) -> None:
        """Add the files of a form; the first table, the only picture or the record may have a name alone."""
        if form in PICTURES:
            for name in pictures:
                own = alone if len(pictures) == 1 else None
                self.pictures[own or _named(stem, form, name)] = name, form
        elif form == "json":
            self.records[alone or _named(stem, form)] = None
        else:
            for name in tables:
                own = None if name else alone
                self.tables[own or _named(stem, form, name)] = name, form
            self.records[_named(stem, "json")] = None

    @property
    def csv_format(self) -> CsvFormat:
        """How CSVs are written."""
        from vibro.files.csv_tables import CsvFormat

        return CsvFormat(decimal_comma=self.options.decimal_comma)

    def __enter__(self) -> Self:
        from vibro.tables.files import whole_files
        from vibro.tables.plan import MANIFEST

        targets = [*self.tables, *self.texts, *self.pictures, *self.records]
        for target in targets:
            if (target.parent / MANIFEST).exists():
                raise InputError(
                    f"-o {target}: {target.parent} is the folder of a sweep; with other files in it, no"
                    " program can read it",
                    hint="choose another place, such as -o out/nut",
                )
        self._whole = whole_files(targets, force=self.options.force, reads=self._reads)
        self.waiting = self._whole.__enter__()
        return self

    def __exit__(self, *raised: Any) -> None:
        self._whole.__exit__(*raised)
        if raised[0] is None:
            self.options.console.echo_all(f"wrote {path}" for path in self._written)

    def write(
        self,
        tables: Callable[[], Mapping[str, TableColumns]],
        draw: Callable[[], Mapping[str, Figure]],
        content: Mapping[str, Any],
        texts: Mapping[str, Callable[[Mapping[str, Figure]], str]] = _NOTHING,
    ) -> None:
        """Write columns, texts, pictures and the record, as far as they are wanted.

        Parameters
        ----------
        tables : callable
            Makes the columns by their header, by the name of the table.
        draw : callable
            Makes the pictures, by their names: all of them, or none.
        content : mapping
            What the record says beside version, arguments and files.
        texts : mapping of str to callable
            By form, such as ``html``: makes the text, of the pictures that a page has.
        """
        figures = draw() if self.pictures or "html" in self.texts.values() else _NOTHING
        self.write_texts(texts, figures)
        if self.tables or self.takes_stdout:
            form, made = self.csv_format, tables()
            for path, (name, _) in self.tables.items():
                self.waiting[path].write_bytes(form.table(made[name]))
            if self.takes_stdout:
                sys.stdout.buffer.write(form.table(next(iter(made.values()))))
        self.finish(content, figures)

    def write_answer(
        self,
        answer: Answer,
        tables: Callable[[], Mapping[str, TableColumns]] = dict,
        draw: Callable[[], Mapping[str, Figure]] = dict,
        shows: Mapping[str, str] = _NOTHING,
        *,
        more: Mapping[str, Any] = _NOTHING,
        texts: Mapping[str, Callable[[Mapping[str, Figure]], str]] = _NOTHING,
    ) -> None:
        """Write an answer: its tables, pictures and record, and its page.

        Parameters
        ----------
        answer : Answer
            It.
        tables, draw, texts : callable, callable, mapping
            As of ``write``.
        shows : mapping of str to str
            What each picture of the page shows, by its name.
        more : mapping
            What the record says beside the answer.
        """

        def page(figures: Mapping[str, Figure]) -> str:
            shown = {text: figures[name] for name, text in shows.items() if name in figures}
            return self.page(answer, shown)

        self.write(tables, draw, {**answer.content(), **more}, {"html": page, **texts})

    def print_answer(self, answer: Answer, *, every: bool = False) -> None:
        """Print an answer, unless stdout has its table."""
        if not self.takes_stdout:
            print(answer.json() if self.options.json else answer.text(every=every))

    def page(self, answer: Answer, pictures: Mapping[str, Figure] = _NOTHING) -> str:
        """Return the page of an answer, with the warnings about it and the command that was typed."""
        notes = [*self.options.console.warnings, *answer.notes]
        return replace(answer, notes=notes).html(pictures, shlex.join(["vibro", *self.options.argv]))

    def write_texts(
        self,
        texts: Mapping[str, Callable[[Mapping[str, Figure]], str]],
        figures: Mapping[str, Figure] = _NOTHING,
    ) -> None:
        """Write files of one text each, such as pages; ``texts`` makes them, by form."""
        for path, form in self.texts.items():
            self.waiting[path].write_text(texts[form](figures), encoding="utf-8")

    def finish(self, content: Mapping[str, Any] = _NOTHING, figures: Mapping[str, Figure] = _NOTHING) -> None:
        """Write pictures and the record; on leaving all files get their names, the record last.

        Parameters
        ----------
        content : mapping
            What the record says beside version, arguments and files.
        figures : mapping
            The pictures by their names; those that are missing are not made.
        """
        from vibro.tables.record import json_text, picture_metadata, run_record

        pictures = {path: which for path, which in self.pictures.items() if which[0] in figures}
        self._written = [*self.tables, *self.texts, *pictures, *self.records]
        self.record = {
            **run_record(self.options.argv, content),
            "files": [path.name for path in self._written],
        }
        if self.pictures and not pictures:
            self.options.console.echo("no pictures: there is nothing to draw")
        if pictures:
            from vibro.plots import save

            for path, (name, form) in pictures.items():
                save(figures[name], self.waiting[path], form, picture_metadata(self.record))
        for path in self.records:
            self.waiting[path].write_text(json_text(self.record) + "\n", encoding="utf-8")

    def print_record(self, **more: Any) -> None:
        """Print the record as JSON, if that is wanted, and before it what the files do not say."""
        from vibro.tables.record import json_text

        if self.options.json:
            print(json_text({**more, **self.record}))


def _place(given: str, name: str, forms: Sequence[str]) -> tuple[Path, str]:
    """Return the path that ``-o`` gives and its form; a stem, to which endings are appended, has none."""
    option = f"-o {given or repr(given)}"
    if not given or "\0" in given:
        raise InputError(f"{option}: no file has such a name", hint=_GIVE_A_NAME)
    path = Path(given)
    ending = path.suffix[1:].casefold()
    if ending == "parquet" and ending in forms:
        return path, ending
    try:
        if given.endswith((os.sep, os.altsep or os.sep, f"{os.sep}.")) or path.is_dir():
            return path / name, ""
        is_other = path.exists() and not path.is_file()
    except OSError as exc:
        raise FileError(f"cannot use {option}: {exc.strerror or exc}", hint="choose another name") from exc
    if path.name in ("", "..") or path.name.casefold() in (f".{form}" for form in forms):
        raise InputError(f"{option}: the name is missing", hint=_GIVE_A_NAME)
    if is_other:
        raise FileError(
            f"{option}: it is neither a file nor a folder", hint="-o - writes the table to stdout"
        )
    if ending in forms:
        return path, ending
    if ending.isalpha() and ending.isascii():
        known = ", ".join(f".{form}" for form in forms)
        raise InputError(
            f"{option}: this answer is not written as .{ending}",
            hint=f"it is written as {known}; a name without an ending is that of all usual files",
        )
    return path, ""


def _named(stem: Path, form: str, name: str = "") -> Path:
    """Append an ending to a stem, and before it a name: ``run1.5`` becomes ``run1.5-speed.png``."""
    return stem.with_name(f"{stem.name}-{name}.{form}" if name else f"{stem.name}.{form}")
