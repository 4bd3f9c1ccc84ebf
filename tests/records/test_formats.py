"""Records of formats with libraries of their own, and LabVIEW's text: names, times, what is left out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.exports import Sampled, library
from scipy.io import savemat, wavfile

from vibro.errors import InputError
from vibro.records.formats import lvm_table, read_channels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.records.channels import Table

SLOW, FAST = Sampled.at(250.0), Sampled.at(1000.0)


def read(path: Path) -> Table:
    table = read_channels(path)
    assert table is not None
    return table


def tdms(path: Path, *channels: tuple[str, str, NDArray[Any], dict[str, Any]]) -> Table:
    nptdms = library("nptdms")
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject(*channel) for channel in channels])
    return read(path)


def waveform(step: float, **others: Any) -> dict[str, Any]:
    return {"wf_increment": step, "wf_start_offset": 0.0, "wf_samples": 1, "unit_string": "g", **others}


def test_channels_that_begin_later_are_later(tmp_path: Path) -> None:
    began = np.datetime64("2031-01-02T10:00:00", "us")
    table = tdms(
        tmp_path / "a.tdms",
        ("A", "x", SLOW.along, waveform(4e-3, wf_start_time=began)),
        ("A", "y", SLOW.normal, waveform(4e-3, wf_start_time=began + np.timedelta64(8000, "us"))),
    )
    np.testing.assert_allclose(table.columns[0][[0, -1]], [0.0, 0.008 + SLOW.time[-1]])
    np.testing.assert_array_equal(table.columns[2][2:], SLOW.normal)
    with pytest.raises(InputError, match="sampled at different times"):
        tdms(
            tmp_path / "b.tdms",
            ("A", "x", SLOW.along, waveform(4e-3, wf_start_time=began)),
            ("A", "y", SLOW.normal, waveform(4e-3, wf_start_time=began + np.timedelta64(1000, "us"))),
        )


def test_variables_of_mat(tmp_path: Path) -> None:
    """Vectors, columns of matrices, fields of structures; those of another length are left out and named."""
    content = {
        "ax": SLOW.along,
        "m": np.stack([SLOW.time, SLOW.normal], axis=1),
        "s": {"deep": {"y": SLOW.normal}, "fs": 250.0},
        "taps": np.ones(7),
        "text": "steady",
        "cell": np.array([1, "a"], object),
    }
    savemat(str(tmp_path / "a.mat"), content)
    table = read(tmp_path / "a.mat")
    assert [*table.names] == ["ax", "m(1)", "m(2)", "s.deep.y"]
    np.testing.assert_array_equal(table.columns[2], SLOW.normal)
    assert "left out, as their length is not 500: 'taps' (7)" in table.notes[0]
    savemat(str(tmp_path / "old.mat"), {"ax": SLOW.along}, format="4")
    np.testing.assert_array_equal(read(tmp_path / "old.mat").columns[0], SLOW.along)
    savemat(str(tmp_path / "none.mat"), {"text": "steady", "f": 25.0})
    with pytest.raises(InputError, match="no channel of numbers"):
        read(tmp_path / "none.mat")


@each("dtype", ["uint8", "int16", "int32", "float32"])
def test_full_scale_of_wav_is_a_volt(tmp_path: Path, dtype: str) -> None:
    wave = np.sin(np.arange(1000.0)) / 2.0
    scaled = {"uint8": 128 + 128 * wave, "int16": 2**15 * wave, "int32": 2**31 * wave, "float32": wave}[dtype]
    wavfile.write(tmp_path / "a.wav", 8000, scaled.astype(dtype))
    table = read(tmp_path / "a.wav")
    assert ([*table.names], [*table.units]) == (["Time", "Channel 1"], ["s", "V"])
    assert np.abs(table.columns[1] - wave).max() <= {"uint8": 2.0**-7}.get(dtype, 2.0**-15)
    np.testing.assert_allclose(table.columns[0], np.arange(1000.0) / 8000.0)


HEADER = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nSamples\t2\t2\n"
CHANNELS = (
    "Y_Unit_Label\tg\tmm\nX0\t0.5\t{0}\nDelta_X\t0.25\t0.25\n***End_of_Header***\nX_Value\ta\tb\tComment\n"
)


def labview(text: str) -> tuple[list[str], list[str]]:
    """Return the lines of a table that are not empty, after as many as the header has, and the notes."""
    table, notes = lvm_table(Path("a.lvm"), text)
    lines = table.split("\n")
    assert not any(lines[:8])
    return [line for line in lines[8:] if line], notes


def test_rows_of_labview_keep_their_numbers() -> None:
    """Of two blocks the first one is read; channels without samples may state other times."""
    without, own = "\t1\t2\n\t3\t4\tstart\n", "7\t1\t2\r\n8\t3\t4\tstart\r\n"
    same, later = CHANNELS.format("0.5"), CHANNELS.format("0.6")
    names = "X_Value [s]\ta [g]\tb [mm]"
    assert labview(HEADER + same + without) == ([names, "0.5\t1\t2", "0.75\t3\t4"], [])
    assert labview(HEADER + later + own) == ([names, "7\t1\t2", "8\t3\t4"], [])
    empty = HEADER.replace("2\t2", "2\t0") + later + without
    assert labview(empty)[0] == ["X_Value [s]\ta [g]\tb", "0.5\t1\t2", "0.75\t3\t4"]
    lines, notes = labview(HEADER + same + without + "Channels\t2\n" + same + without)
    assert (lines, len(notes)) == ([names, "0.5\t1\t2", "0.75\t3\t4"], 1)
    with pytest.raises(InputError, match="step differently"):
        labview(HEADER + later + without)
    for end in (20, len(HEADER), (HEADER + same).index("\nX_Value")):
        with pytest.raises(InputError, match="without the end of its headers"):
            labview((HEADER + same)[:end])
