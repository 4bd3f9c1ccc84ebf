"""Do tests notice faults? Mutants: each is one fault that people make (``faults.toml``).

Usage: python benchmarks/mutants.py [--only TEXT ...]

Works on a copy of this checkout, which stays as it is. Each fault in turn is put in; then the test runs that
``killers.toml`` says to notice it, and where that passes the tests of the room until one fails. In the end
those that failed run without any fault. The list of killers is written anew. A fault that survives shows
what is not tested, unless it changes nothing that can be seen. The solver is compiled anew for each fault in
it, so that a C compiler is needed; those in the page need Chromium. Exits with 1 if fewer than ``ENOUGH`` are
killed, one survives that a listed test killed, or a test that has killed one fails without a fault too.

``--only`` takes parts of a fault's file or consequence: "core/", "exit code".
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, NoReturn

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

ROOT: Final = Path(__file__).parents[1]
ENOUGH: Final = 230  # killed
SHOWN: Final = 80  # characters of a fault
_FAULTS: Final = ROOT / "benchmarks/faults.toml"
_KILLERS: Final = ROOT / "benchmarks/killers.toml"
# What tests import beside vibro, each of whose runs is a fork of a process that has imported it already.
_LIBRARIES: Final = (
    "numpy", "scipy.optimize", "scipy.special", "matplotlib.figure", "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_pdf", "matplotlib.backends.backend_svg", "pandas", "pyarrow.compute",
    "pyarrow.dataset", "pyarrow.parquet", "typer.testing", "rich.progress", "xarray", "jinja2", "xlsxwriter",
    "openpyxl", "mpmath",
)  # fmt: skip
_HEAD: Final = "# The test that notices each fault of faults.toml; benchmarks/mutants.py writes it.\n"


class Mutant(NamedTuple):
    """A fault: a text that is in a file once, what stands in its place, and what a user would suffer from."""

    file: str
    consequence: str
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.file}: {self.consequence}"

    def put_into(self, text: str) -> str:
        """Return a file's text with the fault in it."""
        if text.count(self.old) != 1:
            raise ValueError(f"{self.file} has {self.old!r} {text.count(self.old)} times, not once")
        return text.replace(self.old, self.new)

    def tests(self) -> list[str]:
        """Return the tests of the fault's room, below ``tests``, mirrors of its file first, and sessions."""
        path = Path(self.file)
        tops = sorted(test.name for test in ROOT.glob("tests/test_*.py"))
        room = [path.parts[0]] if len(path.parts) > 1 else tops
        mirrors = [f"{path.parent.as_posix()}/test_{path.stem}.py", f"test_{path.stem}.py"]
        return [*(name for name in mirrors if (ROOT / "tests" / name).exists()), *room, "messages"]


def mutants() -> list[Mutant]:
    """Return all faults."""
    tables = tomllib.loads(_FAULTS.read_text("utf-8"))
    return [Mutant(file, *of, *texts) for file, faults in tables.items() for *of, texts in faults.items()]


def killers() -> dict[str, str]:
    """Return the test that kills each fault, by the fault's text."""
    tables = tomllib.loads(_KILLERS.read_text("utf-8"))
    return {f"{file}: {of}": test for file, tests in tables.items() for of, test in tests.items()}


def write_killers(known: Mapping[str, str]) -> None:
    """Write the list of killers, in the order of the faults."""
    lines, file = [_HEAD], ""
    for mutant in mutants():
        if test := known.get(str(mutant)):
            lines += [f'\n["{mutant.file}"]\n'] if mutant.file != file else []
            lines.append(f"{json.dumps(mutant.consequence)} = {json.dumps(test)}\n")
            file = mutant.file
    _KILLERS.write_text("".join(lines), "utf-8")


class Outcome(NamedTuple):
    """How tests ended: pytest's exit code, those that failed, what was said last, and its time [s of CPU]."""

    code: int
    failed: list[str]
    said: str
    seconds: float


class Copy:
    """A copy of the files of this checkout, in which faults can be put."""

    def __init__(self, place: Path) -> None:
        self._place = place
        self._is_compiled = False
        listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        names = subprocess.run(listed, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        for name in filter(None, names.split("\0")):
            if (ROOT / name).is_file():  # and not removed
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                (place / name).write_bytes((ROOT / name).read_bytes())

    def run(self, *tests: str, options: tuple[str, ...] = ()) -> Outcome:
        """Run tests, by files or names below ``tests``."""
        if not self._is_compiled:
            compiling = [sys.executable, str(self._place / "tools/compiling.py")]
            subprocess.run(compiling, check=True, stdout=subprocess.DEVNULL)
            self._is_compiled = True
        # A loop of the solver that never ends hears no signal: a thread of pytest-timeout ends the process.
        arguments = ["--numprocesses=0", "--timeout-method=thread", "-v", "-rfE", "--tb=no", *options]
        arguments += [f"tests/{test}" for test in tests]
        with tempfile.TemporaryFile("w+") as out:
            child = os.fork()
            if not child:
                self._run_here(arguments, out.fileno())
            try:
                _, status, used = os.wait4(child, 0)
            finally:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(child, signal.SIGKILL)  # with all that its tests have started
            out.seek(0)
            text = out.read()
        code = os.waitstatus_to_exitcode(status)
        failed = re.findall(r"^(?:FAILED|ERROR) tests/(.*?)(?: - .*)?$", text, flags=re.MULTILINE)
        if code not in (0, *range(2, 6)) and not failed:  # it ended in the test that began last
            begun = re.findall(r"^tests/(\S+::.*?)(?: [A-Z]+ .*)? *$", text, flags=re.MULTILINE)
            code, failed = 1, begun[-1:]
        said = text.strip().rpartition("\n")[2]
        return Outcome(code, failed, said, used.ru_utime + used.ru_stime)

    def _run_here(self, arguments: list[str], out: int) -> NoReturn:
        """Run pytest in this process, and end it."""
        code = 1
        try:
            os.setsid()
            for stream in (1, 2):
                os.dup2(out, stream)
            os.chdir(self._place)
            source = str(self._place / "src")
            sys.path.insert(0, source)
            os.environ |= {"PYTHONPATH": source, "VIBRO_BROWSER": "required"}
            code = int(pytest.main(arguments))
            sys.stdout.flush()
        finally:
            os._exit(code)

    @contextlib.contextmanager
    def with_fault(self, mutant: Mutant) -> Iterator[None]:
        """Have a fault in the copy."""
        file = self._place / "src/vibro" / mutant.file
        text = file.read_text("utf-8")
        self._write(file, mutant.put_into(text))
        try:
            yield
        finally:
            self._write(file, text)

    def _write(self, file: Path, text: str) -> None:
        """Write a file of the source, and have what was made from the one before made anew."""
        file.write_text(text, "utf-8")
        # Python takes byte code for that of a file of the same length that was written in the same second.
        Path(importlib.util.cache_from_source(str(file))).unlink(missing_ok=True)
        self._is_compiled &= "core" not in file.parts

    def kill(self, mutant: Mutant, killer: str) -> Outcome:
        """Run the test that killed a fault; if it passes or is gone, those of the room until one fails."""
        with self.with_fault(mutant):
            if killer and (outcome := self.run(killer, options=("-x",))).code == 1:
                return outcome
            return self.run(*mutant.tests(), options=("-x",))


def told(mutant: Mutant, outcome: Outcome) -> str:
    text = str(mutant)
    text = text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."
    end = {0: "SURVIVES", 1: "killed by"}.get(outcome.code, "BROKEN:")
    which = (outcome.failed or [outcome.said])[0] if outcome.code else ""
    return f"{text:{SHOWN}}  {outcome.seconds:5.1f} s  {end} {which}".rstrip()


def main() -> int:
    parser = argparse.ArgumentParser(description="Do tests notice faults?")
    parser.add_argument("--only", nargs="+", default=[""], metavar="TEXT", help="parts of faults")
    wanted = parser.parse_args().only
    chosen = [mutant for mutant in mutants() if any(text in str(mutant) for text in wanted)]
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # no threads, which a fork does not have
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # without byte code each run takes seconds more
    sys.dont_write_bytecode = False
    for library in _LIBRARIES:
        importlib.import_module(library)
    before, killed, survive = killers(), dict[str, str](), list[str]()
    with tempfile.TemporaryDirectory() as place:
        copy = Copy(Path(place))
        for mutant in chosen:
            outcome = copy.kill(mutant, before.get(str(mutant), ""))
            print(told(mutant, outcome), flush=True)
            if outcome.code == 1:
                killed[str(mutant)] = outcome.failed[0]
                write_killers(before | killed)
            elif outcome.code == 0:
                survive.append(str(mutant))
        sound = copy.run(*sorted({*killed.values()})) if killed else Outcome(0, [], "", 0.0)
    print(f"{len(killed)} of {len(chosen)} killed, {len(survive)} survive")
    if lost := [text for text in survive if text in before]:
        print("these were killed before:", *lost, sep="\n  ")
    if sound.code:
        print("without a fault too there fails:", *sound.failed or [sound.said], sep="\n  ")
    return int(len(killed) < min(ENOUGH, len(chosen)) or bool(lost) or sound.code != 0)


if __name__ == "__main__":
    sys.exit(main())
