"""Records that are no plain tables: TDMS, UFF58, MAT and WAV through their libraries, and LabVIEW's text."""

from __future__ import annotations

import logging
import re
import warnings
from collections import Counter
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.errors import FileError, InputError, cut, how_to_install, shown
from vibro.records.channels import Table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from vibro.reals import Floats


class _Channel(NamedTuple):
    """Name of a channel, unit (empty without one), values, and their times [s] if there are any."""

    name: str
    unit: str
    values: Floats
    times: Floats | None = None


_EXPORT: Final = "export it again, or as CSV"
_UFF: Final = re.compile(rb" {4}-1 *\r?\n *(?:15|18|55|58|82|151|164|1858|24[0-9][0-9])b?\s")


def read_channels(path: Path) -> Table | None:
    """Read a file of TDMS, UFF58, MAT or WAV; None if its content is none of these.

    Raises
    ------
    InputError
        If it is damaged or holds no numbers.
    FileError
        If its library is not installed; the extra is named.
    """
    if (known := _known(path)) is None:
        return None
    kind, read = known
    note = f"{path.name}: {kind}{', its full scale counts as 1 V' if read is _wav else ''}"
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of blocks that a library skips
            return _side_by_side(path, [*read(path)], note)
    except ModuleNotFoundError as exc:
        raise FileError(
            f"{path}: {kind} needs the library {exc.name}", hint=how_to_install("formats")
        ) from exc
    except InputError:
        raise
    except (Exception, MemoryError) as exc:  # whatever a library raises at damaged bytes
        why = cut(" ".join(f"{exc}".split())) if isinstance(exc, ValueError) else "it is damaged"
        raise InputError(f"{path}: cannot be read as {kind}: {why}", hint=_EXPORT) from exc


def _known(path: Path) -> tuple[str, Callable[[Path], Iterator[_Channel]]] | None:
    """Return the format of a file and its reader, by its first bytes; MAT of MATLAB 4 has none."""
    try:
        if not path.is_file():  # what a pipe gives can be read once
            return None
        with path.open("rb") as file:
            head = file.read(400)
    except (OSError, ValueError):
        return None
    if head.startswith(b"TDSm"):
        return "TDMS", _tdms
    if head[:4] in (b"RIFF", b"RIFX", b"RF64"):
        return "WAV", _wav
    if head.startswith(b"MATLAB") or (path.suffix.casefold() == ".mat" and b"\0" in head[:20]):
        return "MAT", _mat
    return ("UFF58", _uff) if _UFF.match(head) else None


def _side_by_side(path: Path, channels: list[_Channel], note: str) -> Table:
    """Put channels side by side; of slower ones cells are empty, those of another length are left out."""
    if not channels:
        raise InputError(f"{path}: no channel of numbers", hint=_EXPORT)
    times = [channel.times for channel in channels if channel.times is not None and channel.times.size > 1]
    if times and not all(np.array_equal(one, times[0]) for one in times):
        tick = 1e-3 * min(float(np.ptp(one)) / (one.size - 1) for one in times)
        union = np.unique(np.concatenate([np.round(one / tick) for one in times]))
        if not union.size <= 1.01 * max(one.size for one in times):
            several = f"{path}: its channels are sampled at different times"
            raise InputError(several, hint="export those that you need, with one sampling rate")

        def spread(channel: _Channel) -> _Channel:
            values = np.full(union.size, np.nan)
            if channel.times is not None:
                values[np.searchsorted(union, np.round(channel.times / tick))] = channel.values
            return channel._replace(values=values)

        channels, times = [spread(c) for c in channels if c.times is not None], [union * tick]
    if times:
        channels = [_Channel("Time", "s", times[0]), *channels]
    counts = Counter(channel.values.size for channel in channels)
    size = max(counts, key=lambda n: (counts[n], n))
    left = [f"{shown(c.name)} ({c.values.size})" for c in channels if c.values.size != size]
    if left:
        note += f"; left out, as their length is not {size}: {', '.join(left)}"
    names, units, columns, _ = zip(*(c for c in channels if c.values.size == size), strict=True)
    return Table(path, names, columns, units, notes=(note,))


def _tdms(path: Path) -> Iterator[_Channel]:
    from nptdms import TdmsFile
    from nptdms.log import log_manager

    log_manager.set_level(logging.ERROR)  # a file that was cut short is read as far as it goes
    groups = TdmsFile.read(path).groups()
    found = [(group.name, channel) for group in groups for channel in group.channels()]
    names = [channel.name for _, channel in found]
    starts = [c.properties["wf_start_time"] for _, c in found if "wf_start_time" in c.properties]
    first, second = min(starts, default=np.datetime64(0, "s")), np.timedelta64(1, "s")
    for group, channel in found:
        values, of, times = channel[:], channel.properties, None
        if values.dtype.kind == "M":
            values = (values - values[:1]) / second
        if values.dtype.kind in "biuf" and values.size:
            if of.get("wf_increment"):
                times = channel.time_track() + (of.get("wf_start_time", first) - first) / second
            name = channel.name if names.count(channel.name) == 1 else f"{group}/{channel.name}"
            yield _Channel(name, str(of.get("unit_string", "")), values.astype(np.float64), times)


def _uff(path: Path) -> Iterator[_Channel]:
    import pyuff

    file = pyuff.UFF(str(path))
    numbers = np.flatnonzero(file.get_set_types() == 58).tolist()
    sets = [found for found in (file.read_sets(i) for i in numbers) if found["func_type"] in (0, 1)]
    titles = [found["id1"].strip() for found in sets]
    for found, title in zip(sets, titles, strict=True):
        node, way = found["rsp_node"], found["rsp_dir"]
        place = f"{node}:{'-' if way < 0 else '+'}{'XYZ'[abs(way) - 1]}" if 1 <= abs(way) <= 3 else f"{node}"
        name = title if title not in ("", "NONE") and titles.count(title) == 1 else place
        unit = found["ordinate_axis_units_lab"].strip()
        values, times = (np.asarray(found[key], np.float64) for key in ("data", "x"))
        yield _Channel(name, "" if unit == "NONE" else unit, values, times)


def _mat(path: Path) -> Iterator[_Channel]:
    from scipy.io import loadmat

    with path.open("rb") as file:
        newer = file.read(10) == b"MATLAB 7.3"
    if newer:
        hint = "in MATLAB: save('record.mat', '-v7'), or writetable of a table to record.csv"
        raise InputError(f"{path}: MAT of version 7.3, which is HDF5, is not read", hint=hint)
    content = loadmat(path, squeeze_me=True, appendmat=False)
    yield from _arrays({name: value for name, value in content.items() if not name.startswith("__")})


def _arrays(content: dict[str, Any], before: str = "") -> Iterator[_Channel]:
    """Return the vectors of variables, those in structures, and the columns of matrices."""
    for name, value in content.items():
        array = np.asarray(value)
        if array.dtype.names and array.ndim == 0:
            fields = {field: array[field].item() for field in array.dtype.names}
            yield from _arrays(fields, f"{before}{name}.")
        elif array.dtype.kind in "biuf" and array.ndim == 1 and array.size > 1:
            yield _Channel(before + name, "", array.astype(np.float64))
        elif array.dtype.kind in "biuf" and array.ndim == 2:
            columns = array if array.shape[0] < array.shape[1] else array.T
            for i, column in enumerate(columns, 1):
                yield _Channel(f"{before}{name}({i})", "", column.astype(np.float64))


def _wav(path: Path) -> Iterator[_Channel]:
    """Read the channels of a WAV as volts: its full scale counts as 1 V."""
    from scipy.io import wavfile

    rate, samples = wavfile.read(path)
    values = samples.astype(np.float64).reshape(len(samples), -1).T
    if samples.dtype.kind in "iu":
        half = 2.0 ** (8 * samples.dtype.itemsize - 1)
        values = values / half - (samples.dtype.kind == "u")
    for i, channel in enumerate(values, 1):
        yield _Channel(f"Channel {i}", "V", channel, np.arange(channel.size) / rate)


#: Ends a header of LabVIEW: that of the file, and that of the channels under it.
_END: Final = "***End_of_Header***"
_NUMBER: Final = re.compile(r"[+-]?[0-9]+(?:[.,][0-9]*)?(?:[eE][+-]?[0-9]{1,3})?")


def lvm_table(path: Path, text: str) -> tuple[str, list[str]]:
    """Make a table of a LabVIEW measurement file: a row of names with units, a first column of times.

    Every row keeps its number. Times are made of ``X0`` and ``Delta_X`` where the file has none.

    Returns
    -------
    text : str
        The table.
    notes : list of str
        What was left out.

    Raises
    ------
    InputError
        If its headers have no end, or its channels are sampled at different times.
    """
    lines = text.split("\n")
    ends = [i for i, line in enumerate(lines) if line.startswith(_END)]
    if len(ends) < 2 or ends[1] + 1 == len(lines):
        raise InputError(f"{path}: a LabVIEW file without the end of its headers, {_END}", hint=_EXPORT)
    separator = "," if any(re.match(r"Separator[\t,]Comma", line) for line in lines[: ends[0]]) else "\t"
    of = {cells[0]: cells for line in lines[ends[0] : ends[1]] if (cells := line.rstrip().split(separator))}
    names, first = lines[ends[1] + 1].split(separator), ends[1] + 2
    last = next((i for i in range(first, len(lines)) if lines[i].startswith(("Channels", _END))), len(lines))

    def stated(key: str, place: int) -> str:
        return of[key][place].strip() if place < len(of.get(key, ())) else ""

    while names[1:] and names[-1].strip() in ("Comment", ""):  # fewer rows have these cells
        del names[-1]
    places = [i for i, name in enumerate(names) if name.strip() != "X_Value" and stated("Samples", i) != "0"]
    rows = [separator.join(row.split(separator)[: len(names)]).rstrip("\r") for row in lines[first:last]]
    has_times = bool(rows and rows[0].split(separator)[0].strip())
    steps = {(stated("X0", i), stated("Delta_X", i)) for i in places}
    if len(steps) > 1 and not (has_times and [name.strip() for name in names].count("X_Value") == 1):
        several = f"{path}: its channels begin at different times, or step differently"
        raise InputError(several, hint="export those that you need, with one column of times")
    for i in places:
        names[i] += f" [{unit}]" if (unit := stated("Y_Unit_Label", i)) else ""
    names[0] += " [s]" if "Time" in of.get("X_Dimension", "Time") else ""
    start, step = (
        float(x.replace(",", ".")) if _NUMBER.fullmatch(x) else 0.0 for x in (steps or {("", "")}).pop()
    )
    if step and not has_times:
        point = "," if any(line.startswith("Decimal_Separator\t,") for line in lines[: ends[0]]) else "."
        times = [f"{start + i * step!r}".replace(".", point) for i in range(len(rows))]
        rows = [t + row.lstrip(" ") if row.strip() else "" for t, row in zip(times, rows, strict=True)]
    left = len(lines) - last
    notes = [f"{path.name}: {left} rows under the next header are left out"] if left > 1 else []
    return "\n".join([*[""] * (first - 1), separator.join(names), *rows]), notes
