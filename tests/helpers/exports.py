"""One motion of a trough as the files that telephones, loggers, simulations and spreadsheets write of it.

The motion is 1.000 mm at 25 Hz along a line of 25 deg, with noise of 0.05 m/s^2, 500 times a second for two
seconds where the kind demands nothing else. Layouts are those of the programs; all numbers are made here.
"""

from __future__ import annotations

import importlib
import io
import math
import os
import tempfile
import warnings
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime, timedelta
from itertools import zip_longest
from pathlib import Path
from types import ModuleType
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from scipy.io import savemat, wavfile

Floats = NDArray[np.float64]

AMPLITUDE_MM: Final = 1.0
FREQUENCY: Final = 25.0
ANGLE_DEG: Final = 25.0
G: Final = 9.80665


class Export(NamedTuple):
    """A file and what one types to measure its motion.

    Attributes
    ----------
    name : str
        What wrote it, and what is peculiar.
    file : str
        Its name.
    content : bytes
        What it holds.
    typed : tuple of str
        Arguments behind the file.
    hint : str
        What the hint must say where this is refused; empty where it is measured.
    """

    name: str
    file: str
    content: bytes
    typed: tuple[str, ...]
    hint: str = ""


class Sampled(NamedTuple):
    """The motion at equal steps: times [s], accelerations along and normal to the trough [m/s^2]."""

    time: Floats
    along: Floats
    normal: Floats

    @classmethod
    def at(cls, rate: float, *, derivative: int = 2, seconds: float = 2.0, noise: float = 0.05) -> Sampled:
        """Sample acceleration, velocity or displacement; gravity is part of the first."""
        time = np.arange(round(rate * seconds)) / rate
        turn = math.tau * FREQUENCY
        wave = 1e-3 * AMPLITUDE_MM * (turn * 1j) ** derivative * np.exp(1j * (turn * time + 0.7))
        random = np.random.default_rng(1)
        along, normal = (
            wave.imag * part + random.normal(0.0, noise, time.size)
            for part in (math.cos(math.radians(ANGLE_DEG)), math.sin(math.radians(ANGLE_DEG)))
        )
        return cls(time, along, normal + G * (derivative == 2))


def library(name: str) -> ModuleType:
    """Import an optional library, or skip the test; continuous integration has them all."""
    return importlib.import_module(name) if os.environ.get("CI") else pytest.importorskip(name)


def text_exports() -> list[Export]:
    """Return all kinds that are text."""
    t, ax, az = Sampled.at(500.0)
    none, typed = np.zeros(t.size), tuple[str, ...]()
    found: list[Export] = []

    def add(
        name: str, text: str, typed: str | Sequence[str], *, file: str = "record.csv", code: str = "utf-8"
    ) -> None:
        found.append(Export(name, file, text.encode(code), _typed(typed)))

    # --- telephones
    phyphox = "Acceleration x (m/s^2)", "Acceleration y (m/s^2)", "Acceleration z (m/s^2)"
    names = [f'"{name}"' for name in ("Time (s)", *phyphox, "Absolute acceleration (m/s^2)")]
    cells = [_cells(x, ".9E") for x in (t, ax, none, az, np.hypot(ax, az))]
    both = "--trough-along", "Acceleration x", "--trough-normal", "Acceleration z"
    rows = [*zip(*cells, strict=True)]
    add("phyphox CSV, commas", _lines(",", names, rows), both)
    add("phyphox CSV, tabs, decimal commas", _lines("\t", names, rows).replace(".", ","), both)
    add("phyphox, first row twice", _lines(",", names, [rows[0], *rows]), both)
    excel = ["Time (s)", *phyphox, "Absolute acceleration (m/s^2)"]
    text = _lines("\t", excel, rows).replace("\n", "\r\n")
    add("phyphox Excel saved as Unicode text", text, both, file="record.txt", code="utf-16")
    by_names = "time [s] | gFx [g] | gFz [g]"
    g_force = [_cells(x / G, ".4f") for x in (ax, none, az, np.hypot(ax, az))]
    names = ["time", "gFx", "gFy", "gFz", "TgF"]
    add(
        "Physics Toolbox, seconds", _lines(",", names, zip(_cells(t, ".3f"), *g_force, strict=True)), by_names
    )
    clocks = [_clock(59.0 + s, "%H:%M:%S:%f") for s in t]
    add("Physics Toolbox, clock times", _lines(",", names, zip(clocks, *g_force, strict=True)), by_names)

    # --- simulations and scripts
    klipper = zip(_cells(831.2 + t, ".6f"), *(_cells(1e3 * x, ".6f") for x in (ax, none, az)), strict=True)
    text = _lines(",", ["#time", "accel_x", "accel_y", "accel_z"], klipper)
    by_names = "time [s] | accel_x [mm/s^2] | accel_z [mm/s^2]"
    add("Klipper", text, by_names)
    add("Klipper, a row of settings above", "##{'samples': 1000, 'errors': 0}\n" + text, by_names)
    rows = [*zip(*(_cells(x, ".12g") for x in (ax, az, t)), strict=True)]
    yade = "# ax\t\taz\t\tt\n" + _lines("\t", None, rows)
    add("YADE saveDataTxt", yade, "t [s] | ax [m/s^2] | az [m/s^2]", file="record.txt")
    rows = [*zip(*(_cells(x, ".8g") for x in (t, ax, az)), strict=True)]
    by_number = "1 [s] | 2 [m/s^2] | 3 [m/s^2]"
    text = "# Fix print output for fix trough\n" + _lines(" ", None, rows)
    add("LIGGGHTS fix print", text, by_number, file="record.dat")
    steps = [[f"{1000 * i}", *row] for i, row in enumerate(rows)]
    text = "# Time-averaged data for fix trough\n# TimeStep v_t v_ax v_az\n" + _lines(" ", None, steps)
    add("LAMMPS fix ave/time", text, "v_t [s] | v_ax [m/s^2] | v_az [m/s^2]", file="record.dat")
    wide = "".join(f"{a:>12}{b:>14}{c:>14}\n" + "\n" * (i % 100 == 99) for i, (a, b, c) in enumerate(rows))
    text = "# measured at the outlet\n#       t [s]      ax [m/s^2]    az [m/s^2]\n" + wide
    add("gnuplot, aligned, blank lines", text, "t [s] | ax [m/s^2] | az [m/s^2]", file="record.dat")
    exact = [*zip(*(_cells(x, ".18e") for x in (t, ax, az)), strict=True)]
    add("numpy.savetxt", _lines(" ", None, exact), by_number, file="record.txt")
    text = "# t,ax,az\n" + _lines(",", None, exact)
    add("numpy.savetxt with names", text, "t [s] | ax [m/s^2] | az [m/s^2]")
    matlab = [*zip(*(_cells(x, ".15g") for x in (t, ax, az)), strict=True)]
    add("MATLAB writematrix", _lines(",", None, matlab), by_number)
    add("MATLAB writetable", _lines(",", ["t_s", "ax_m_s2", "az_m_s2"], matlab), "t_s | ax_m_s2 | az_m_s2")

    # --- loggers
    for kind in ("One", "No", "Multi"):
        add(f"LabVIEW .lvm, X_Columns {kind}", _lvm(kind, t, ax / G, az / G), _LVM, file="record.lvm")
    rows = [*zip(*(_cells(x, ".5f") for x in (t, ax, az)), strict=True)]
    seconds = ["Time [s]", "ax [m/s^2]", "az [m/s^2]"]
    two = "--trough-along", "ax", "--trough-normal", "az"
    add("TwinCAT Scope, EOF", _lines(",", seconds, rows) + "EOF\n", two)
    by_number = "1 [ms] | ax [m/s^2] | az [m/s^2]"
    text = _twincat([["Name", "ax", "az"]], zip(*(_cells(x, ".7g") for x in (1e3 * t, ax, az)), strict=True))
    add("TwinCAT Scope, rows of settings", text, by_number, file="record.txt")
    fast, slow = Sampled.at(1000.0), Sampled.at(250.0, derivative=0, noise=2e-6)
    columns = [_cells(x, ".7g") for x in (1e3 * fast.time, fast.along, 1e3 * slow.time, 1e3 * slow.along)]
    text = _twincat([["Name", "ax"], ["Name", "laser"]], zip_longest(*columns, fillvalue=""))
    typed = "--time", "3 [ms]", "--trough-along", "laser [mm]", "--drive-angle", "25"
    add("TwinCAT Scope, two rates, times of each", text, typed, file="record.txt")
    for fill in ("none", "previous value"):
        typed = "--trough-along", "laser [mm]", "--drive-angle", "25"
        add(f"TwinCAT Scope, two rates, fill {fill}", _two_rates(held=fill != "none"), typed)
    text = "Data File: trough\nSample rate: 500 Hz\nStart time: 1/2/2031 10:00:00.000\n\nData1\n"
    text += _lines("\t", ["Time (s)", "ax (m/s2)", "az (m/s2)"], rows)
    add("Dewesoft", text, two, file="record.txt")
    german = _lines(";", ["Zeit", "längs", "normal"], [("s", "m/s²", "m/s²"), *rows]).replace(".", ",")
    typed = "--trough-along", "längs", "--trough-normal", "normal"
    add("imc FAMOS, Windows-1252", german, typed, code="cp1252")
    text = "HBM catman\nAnzahl der Kanäle: 3\nAbtastrate: 500 Hz\n"
    text += _lines("\t", ["Zeit  1 - Standardmessrate [s]", "längs [m/s²]", "normal [m/s²]"], rows)
    add("Catman", text.replace(".", ","), typed, file="record.asc", code="cp1252")
    in_g = [*zip(_cells(t, ".3f"), _cells(ax / G, ".5f"), _cells(az / G, ".5f"), strict=True)]
    quoted = [[f'"{x}"' for x in row] for row in [("Relative Time", "ax", "az"), ("sec", "g", "g"), *in_g]]
    add("DataQ, all cells quoted", _lines(",", None, quoted), two)
    rows = [*zip(*(_cells(x, ".6f") for x in (1e3 * t, 100.0 * ax / G, 100.0 * az / G)), strict=True)]
    text = "Time,Channel A,Channel B\n(ms),(mV),(mV)\n\n" + _lines(",", None, rows)
    volts = "--trough-along", "Channel A", "--trough-normal", "Channel B", "--sensitivity", "100mV/g"
    add("PicoScope", text, volts)
    rows = [*zip(*(_cells(x, ".9f") for x in (t, 0.1 * ax / G, 0.1 * az / G)), strict=True)]
    volts = "--trough-along", "Channel 0 [V]", "--trough-normal", "Channel 1 [V]", "--sensitivity", "100mV/g"
    add("Saleae", _lines(",", ["Time [s]", "Channel 0", "Channel 1"], rows), volts)
    rows = [*zip(_cells(t, ".6f"), *g_force[:3], strict=True)]
    text = _lines(",", ["Time", '"X (40g)"', '"Y (40g)"', '"Z (40g)"'], rows)
    add("enDAQ", text, "Time [s] | X (40g) [g] | Z (40g) [g]")
    clocks = [_clock(s, "%H:%M:%S.%f") for s in t]
    rows = [("0x50", clock, *row) for clock, *row in zip(clocks, *g_force[:3], strict=True)]
    text = "StartTime: 2031-01-02 10:00:00.000\n"
    text += _lines("\t", ["address", "Time(s)", "ax(g)", "ay(g)", "az(g)"], rows)
    add("Witmotion", text, two, file="record.txt")
    meas = [("block", "ms since epoch", "of the second", "trough along", "trough normal")]
    meas += [("-", "ms", "ms", "g", "g")]
    for i, (_, a, b) in enumerate(in_g):
        meas.append((f"{i}", f"{_EPOCH_MS + 2 * i}", f"{2 * i % 1000}", a, b))
    names = ["Sequence number", "Time Code", "Milliseconds", "A0", "A1"]
    typed = "--time", "Time Code", "--trough-along", "A0", "--trough-normal", "A1"
    add("MEAS, three header rows, epoch ms", _lines(";", names, meas).replace(".", ","), typed)

    # --- clocks
    fast = Sampled.at(1600.0)
    rows = [*zip(_cells(np.floor(1e3 * fast.time), ".0f"), *_both(fast), strict=True)]
    add("clock of whole ms at 1600 Hz", _lines(",", ["t [ms]", *seconds[1:]], rows), two)
    for unit, digits in (("s", 3), ("ms", 0), ("us", -3), ("ns", -6)):
        whole = [_EPOCH_MS + 2 * i for i in range(t.size)]
        stamps = [f"{ms // 1000}.{ms % 1000:03d}" if digits == 3 else f"{ms}{'0' * -digits}" for ms in whole]
        text = _lines(",", ["timestamp", *seconds[1:]], zip(stamps, *_both(Sampled(t, ax, az)), strict=True))
        add(f"epoch in {unit}", text, ("--time", f"timestamp [{unit}]", *two))
    for name, pattern, separator in (
        ("times of day over midnight", "%H:%M:%S.%f", ","),
        ("ISO dates with a zone", "%Y-%m-%dT%H:%M:%S.%fZ", ","),
        ("dates without a zone, decimal commas", "%d.%m.%Y %H:%M:%S.%f", ";"),
    ):
        stamps = [_clock(50399.0 + s if "midnight" in name else s, pattern) for s in t]
        text = _lines(separator, ["Time", *seconds[1:]], zip(stamps, *_both(Sampled(t, ax, az)), strict=True))
        add(name, text.replace(".", ",") if separator == ";" else text, ("--time", "Time", *two))

    # --- cells and rows
    rows = [*zip(*(_cells(x, ".5f") for x in (t, ax, az)), strict=True)]
    sums = [("Mean", "0.01", "9.81"), ("Max", "22.5", "20.3"), ("Min", "-22.4", "-0.6")]
    add("rows of mean, max and min", _lines(",", seconds, [*rows, *sums]), two)
    rows = [*zip(_cells(t, ".5f"), *(_cells(1e3 * x, ",.2f", '"') for x in (ax, az)), strict=True)]
    add("thousands separators", _lines(",", ["Time [s]", "ax [mm/s^2]", "az [mm/s^2]"], rows), two)
    rows = [
        *zip(_cells(t, ".5f"), *(_cells(1e3 * x / G, ".1f") for x in (ax, az)), [""] * t.size, strict=True)
    ]
    text = "sep=;\n" + _lines(";", ["Time [s]", "ax [mg]", "az [mg]", ""], rows).replace(".", ",")
    add("Excel sep=;, byte order mark, mg, trailing separators", text, two, code="utf-8-sig")
    speed, way = Sampled.at(500.0, derivative=1, noise=1e-4), Sampled.at(500.0, derivative=0, noise=2e-6)
    rows = [*zip(_cells(t, ".5f"), *(_cells(x / 0.0254, ".5f") for x in speed[1:]), strict=True)]
    typed = "--trough-along", "Vel along", "--trough-normal", "Vel normal"
    add("inches a second", _lines(",", ["Time (s)", "Vel along (ips)", "Vel normal (in/s)"], rows), typed)
    rows = [*zip(_cells(t, ".5f"), *(_cells(x / 25.4e-6, ".2f") for x in way[1:]), strict=True)]
    typed = "--trough-along", "x", "--trough-normal", "z"
    add("mils", _lines(",", ["Time (s)", "x (mils)", "z (mils)"], rows), typed)
    mm = ["Time [s]", "ax [mm/s^2]", "az [mm/s^2]"]
    in_mm = [*zip(_cells(t, ".5f"), *(_cells(1e3 * x, ",.0f", '"') for x in (ax, az)), strict=True)]
    add("whole numbers in thousands, times with points", _lines(",", mm, in_mm), two)
    german = _lines(";", mm, [[x.strip('"') for x in row] for row in in_mm]).translate({44: ".", 46: ","})
    add("whole numbers with points between thousands, times with commas", german, two)
    rows = [*zip(*(_cells(x, ".6E") for x in (t, ax, az)), strict=True)]
    fortran = "  t  ax  az\n" + _lines("  ", None, rows).replace("E", "D")
    add("Fortran, D exponents", fortran, "t [s] | ax [m/s^2] | az [m/s^2]", file="record.dat")
    text = "Time (s) Acc X (m/s^2) Acc Z (m/s^2)\n" + _lines(" ", None, rows)
    add(
        "names of words, units and cells apart by spaces",
        text,
        ("--trough-along", "Acc X", *two[2:3], "Acc Z"),
    )
    text = _lines(",", ["[s] t", "[m/s^2] ax", "(m/s\u00c2\u00b2) az"], rows)
    add("units before names, one of UTF-8 read as Latin", text, two)
    text = _lines(",", ['"# time"', '"ax"', '"az"'], rows).replace("-", "\u2212")
    add("a quoted comment as header, signs of minus", text, "#time [s] | ax [m/s^2] | az [m/s^2]")
    text = _lvm("One", t, ax / G, az / G).replace(",", ".").replace("\t", ",").replace("Tab", "Comma")
    add("LabVIEW .lvm, commas", text.replace("\n", "\r\n"), _LVM, file="record.lvm")
    fast, gyro = Sampled.at(413.0), [(k / 207.3 + 0.0011, "", "", "0.01") for k in range(410)]
    rows = [(*row, "") for row in zip(fast.time.tolist(), *_both(fast), strict=True)]
    merged = [(f"{row[0]:.5f}", *row[1:]) for row in sorted([*rows, *gyro])]
    add("two sensors, rows of each", _lines(",", [*seconds, "gyro (rad/s)"], merged), two)
    stamps = [f'"Jan 2, 2031 {x}+01"' for x in clocks]
    text = _lines(",", ["Time", *seconds[1:]], zip(stamps, *_both(Sampled(t, ax, az)), strict=True))
    add("dates with names of months, zones of hours", text, ("--time", "Time", *two))
    rows = [*zip(_cells(ax, ".5f"), _cells(az, ".5f"), strict=True)]
    add("no time", _lines(",", seconds[1:], rows), (*two, "--rate", "500"))
    typed = "--trough-along", "1 [V]", "--sensitivity", "100mV/g", "--drive-angle", "25", "--rate", "500"
    add("ARTS, no header, no time", "".join(f"{x:.6f}\n" for x in 0.1 * ax / G), typed, file="record.txt")
    return found


def binary_exports() -> list[Export]:
    """Return all kinds that are no text; without their libraries the tests are skipped."""
    t, ax, az = Sampled.at(500.0)
    channels = {"Acc along": ax, "Acc normal": az}
    names = "t [s] | ax [m/s^2] | az [m/s^2]"
    found = [
        Export("TDMS, waveforms", "record.tdms", _tdms(t, channels, waveform=True), _LVM),
        Export("TDMS, a channel of times", "record.tdms", _tdms(t, channels, waveform=False), _LVM),
        Export("UFF58", "record.uff", _uff(t, channels, binary=False), _LVM),
        Export("UFF58, binary", "record.unv", _uff(t, channels, binary=True), _LVM),
    ]
    variables = {"t": t, "ax": ax[:, None], "sensor": {"az": az}, "comment": "steady"}
    content = _saved(lambda path: savemat(str(path), variables, do_compression=True))
    found += [Export("MAT", "record.mat", content, _typed(names.replace("az", "sensor.az")))]
    newer = b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + bytes(90)
    found += [Export("MAT 7.3", "record.mat", newer, _typed(names), hint="-v7")]
    buffer = io.BytesIO()
    volts = np.stack([0.1 * ax / G, 0.1 * az / G], axis=1)
    wavfile.write(buffer, 500, np.round(2**15 * volts).astype(np.int16))
    typed = (*_typed("Time | Channel 1 | Channel 2"), "--sensitivity", "100mV/g")
    found += [Export("WAV", "record.wav", buffer.getvalue(), typed)]
    buffer = io.BytesIO()
    columns = {"Time (s)": t, "Acceleration x (m/s^2)": ax, "Acceleration z (m/s^2)": az}
    pd.DataFrame(columns).to_excel(buffer, index=False, engine="xlsxwriter")
    typed = _typed("Time (s) | Acceleration x | Acceleration z")
    found += [Export("phyphox Excel", "record.xlsx", buffer.getvalue(), typed, hint="CSV")]
    return found


#: 2031-01-02 10:00:00 UTC.
_EPOCH_MS: Final = 1925114400000
_LVM: Final = "--trough-along", "Acc along", "--trough-normal", "Acc normal"


def _typed(text: str | Sequence[str]) -> tuple[str, ...]:
    """Return the arguments; a text names the columns of time, along and normal."""
    if not isinstance(text, str):
        return tuple(text)
    options = "--time", "--trough-along", "--trough-normal"
    return tuple(x for pair in zip(options, text.split(" | "), strict=True) for x in pair)


def _cells(values: Floats, form: str, quote: str = "") -> list[str]:
    return [f"{quote}{value:{form}}{quote}" for value in values.tolist()]


def _both(sampled: Sampled) -> tuple[list[str], list[str]]:
    return _cells(sampled.along, ".4f"), _cells(sampled.normal, ".4f")


def _lines(separator: str, names: Iterable[str] | None, rows: Iterable[Iterable[str]]) -> str:
    return "".join(separator.join(row) + "\n" for row in ([names] if names else []) + [*rows])


def _clock(since: float, pattern: str) -> str:
    """Write a time of day with milliseconds, so many seconds after ten o'clock."""
    moment = datetime(2031, 1, 2, 10, tzinfo=UTC) + timedelta(milliseconds=round(1e3 * since))
    return moment.strftime(pattern)[: -4 if pattern.endswith("Z") else -3] + "Z" * pattern.endswith("Z")


def _lvm(kind: str, t: Floats, along: Floats, normal: Floats) -> str:
    """Write a file of LabVIEW, with decimal commas, and with one, no or a time for each channel."""
    of_file = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab"]
    of_file += ["Decimal_Separator\t,", "Multi_Headings\tNo", f"X_Columns\t{kind}", "Time_Pref\tAbsolute"]
    of_file += ["Operator\tTrough", "Date\t2031/01/02", "Time\t10:00:00,19", "***End_of_Header***\t", "\t"]
    gap = "\t\t" if kind == "Multi" else "\t"
    of_data = [f"Channels\t2{gap}\t"]
    for key, value in (
        ("Samples", f"{t.size}"),
        ("Date", "2031/01/02"),
        ("Time", "10:00:00,19"),
        ("Y_Unit_Label", "g"),
        ("X_Dimension", "Time"),
        ("X0", "0,0000000000000000E+0"),
        ("Delta_X", f"{t[1] - t[0]:.6f}"),
    ):
        of_data.append(f"{key}\t{value}{gap}{value}\t")
    of_data += ["***End_of_Header***\t\t\t"]
    again = "X_Value\t" if kind == "Multi" else ""
    of_data += [f"X_Value\tAcc along\t{again}Acc normal\tComment"]
    rows = []
    for s, p, q in zip(_cells(t, ".6f"), _cells(along, ".6f"), _cells(normal, ".6f"), strict=True):
        rows.append(
            {"One": f"{s}\t{p}\t{q}\t", "No": f"\t{p}\t{q}\t", "Multi": f"{s}\t{p}\t{s}\t{q}\t"}[kind]
        )
    return "\n".join([*of_file, *(line.replace(".", ",") for line in [*of_data, *rows])]) + "\n"


def _twincat(groups: Sequence[Sequence[str]], rows: Iterable[Sequence[str]]) -> str:
    """Write an export of TwinCAT Scope with its rows of settings; columns of time are called Name."""
    above = [
        ("Name", "trough"),
        ("File", "trough.csv"),
        ("Starttime of export", "1", "2. 1. 2031", "10:00"),
        (),
    ]
    settings = {"SymbolComment": "", "Data-Type": "REAL64", "SampleTime[ms]": "2", "VariableSize": "8"}
    settings |= {"SymbolBased": "True", "IndexGroup": "16448", "IndexOffset": "385312", "Offset": "0"}
    settings |= {"SymbolName": "MAIN.x", "NetID": "192.168.0.1.1.1", "Port": "851", "ScaleFactor": "1"}
    settings |= {"BitMask": "0xff", "Unit": "(None)", "Unit ScaleFactor": "1", "Unit Offset": "0"}
    lines = [[cell for group in groups for cell in group]]
    for key, value in settings.items():
        lines.append([key if cell == "Name" else value for cell in lines[0]])
    return _lines("\t", None, [*above, *lines, (), *(filter(None, row) for row in rows), ("EOF",)])


def _two_rates(*, held: bool) -> str:
    """Write a laser of 250 Hz beside an accelerometer of 1000 Hz, with empty cells or its last value."""
    fast, slow = Sampled.at(1000.0), Sampled.at(250.0, derivative=0, noise=2e-6)
    laser = _cells(1e3 * slow.along, ".4f")
    cells = [laser[i // 4] if held or i % 4 == 0 else "" for i in range(fast.time.size)]
    rows = zip(_cells(fast.time, ".5f"), _cells(fast.along, ".4f"), cells, strict=True)
    return _lines(",", ["Time [s]", "ax [m/s^2]", "laser [mm]"], rows)


def _tdms(t: Floats, channels: dict[str, Floats], *, waveform: bool) -> bytes:
    nptdms, buffer = library("nptdms"), io.BytesIO()
    of: dict[str, object] = {"unit_string": "m/s^2"}
    if waveform:
        of |= {"wf_increment": t[1] - t[0], "wf_start_offset": 0.0, "wf_samples": t.size}
    written = [nptdms.ChannelObject("Trough", name, x, of) for name, x in channels.items()]
    if not waveform:
        written = [nptdms.ChannelObject("Trough", "Time", t, {"unit_string": "s"}), *written]
    with nptdms.TdmsWriter(buffer) as writer:
        writer.write_segment(written)
    return buffer.getvalue()


def _uff(t: Floats, channels: dict[str, Floats], *, binary: bool) -> bytes:
    of = {
        "type": 58, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0, "x": t,
        "num_pts": t.size, "binary": int(binary), "byte_ordering": 1, "fp_format": 2, "version_num": 0,
        "ord_data_type": 4, "ordinate_spec_data_type": 12, "ordinate_axis_units_lab": "m/s^2",
        "orddenom_spec_data_type": 0, "z_axis_value": 0.0, "abscissa_spacing": 1, "abscissa_min": 0.0,
        "abscissa_inc": t[1] - t[0], "abscissa_spec_data_type": 17,
    }  # fmt: skip
    sets = [of | {"id1": name, "data": x} for name, x in channels.items()]
    return _saved(lambda path: library("pyuff").UFF(str(path)).write_sets(sets, "add"))


def _saved(write: Callable[[Path], object]) -> bytes:
    """Return what is written by a library that wants a path, and may leave it open."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        path = Path(folder) / "record.mat"
        write(path)
        return path.read_bytes()
