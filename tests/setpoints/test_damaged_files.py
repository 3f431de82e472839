"""Setpoint files that are cut off, damaged, encoded otherwise or of a package that is missing: refused, never a trace."""

from __future__ import annotations

import io
import random
import struct
import sys
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.diagnostics import RemarkWarning, UsageError
from cncgen.setpoints.readers import open_setpoints
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers import FORMATS

from .test_files import read, stream, write

ROWS = 12
#: Formats in which a file says how long it is; the others can be cut off between two rows unseen.
COUNTED = ("npy", "npz", "arrow", "parquet", "mat", "hdf5", "mf4", "mcap")


def options(kind: str) -> dict[str, Any]:
    """What has to be told of files that do not name their axes."""
    return {"axes": "XYA"} if kind in ("npy", "f64") else {}


#: Formats in increments of a drive.
DRIVE_UNITS = ("csp", "csp-raw")
#: Formats read in a process of their own, half a second each: fewer trials.
ISOLATED = ("hdf5", "mat")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A file of each format."""
    folder = tmp_path_factory.mktemp("whole")
    for kind in FORMATS:
        write(folder / f"a.{kind}", kind, [stream(rows=ROWS)])
    return {kind: (folder / f"a.{kind}").read_bytes() for kind in FORMATS}


def test_what_a_library_says_of_a_damaged_file_is_told(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """Cut before its last columns: the process that reads says so, and its end is no longer all that is known."""
    path = tmp_path / "a.mat"
    path.write_bytes(whole["mat"][: len(whole["mat"]) // 2])
    with pytest.raises(UsageError, match=r"a\.mat cannot be read as mat: .*cut off before"):
        read(path)
    path = tmp_path / "a.hdf5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(40))
    with pytest.raises(UsageError, match=r"a\.hdf5 cannot be read as hdf5: \w.{10}"):
        read(path)


@pytest.mark.parametrize("kind", FORMATS)
def test_a_file_that_is_cut_off_is_refused_or_ends_after_a_row(
    tmp_path: Path, whole: dict[str, bytes], kind: str
) -> None:
    """Cut anywhere: rows that are given are those that were written, but for the last digits of the last number."""
    path, expected = tmp_path / f"a.{kind}", stream(rows=ROWS).position
    if kind in DRIVE_UNITS:  # rounded to half an increment
        path.write_bytes(whole[kind])
        expected = read(path)[2]
    size = len(whole[kind])
    step = size // 5 if kind in ISOLATED else 16
    for length in sorted({*range(0, size, step), *range(size - (2 if kind in ISOLATED else 20), size)}):
        path.write_bytes(whole[kind][:length])
        try:
            _, _, rows, _ = read(path, **options(kind))
        except UsageError:
            continue
        assert kind not in COUNTED, length
        assert np.abs(rows[:-1] - expected[: len(rows) - 1]).max(initial=0.0) < 1e-9
        assert len(rows) < ROWS or kind in ("csv", "hal", "jsonl", "csp")


@pytest.mark.parametrize("kind", FORMATS)
def test_damaged_bytes_are_a_fault_of_the_file(tmp_path: Path, whole: dict[str, bytes], kind: str) -> None:
    """Bytes changed, taken out and put in at random: setpoints that are finite, or a `UsageError`."""
    chance = random.Random(7)
    path = tmp_path / f"a.{kind}"
    for _ in range(5 if kind in ISOLATED else 100):
        content = bytearray(whole[kind])
        for _ in range(chance.choice((1, 1, 2, 5))):
            at = chance.randrange(len(content))
            piece = bytes(
                chance.choice(b'0123456789.e+-, {}[]\n\x00\xff"') for _ in range(chance.randrange(4))
            )
            content[at : at + chance.randrange(6)] = piece
        path.write_bytes(content)
        try:
            _, period, rows, _ = read(path, **options(kind))
        except UsageError:
            continue
        assert period > 0.0
        assert np.isfinite(rows).all()


@pytest.mark.parametrize(
    ("rows", "told"), [(ROWS - 1, "has 11 rows, and its header says 12"), (ROWS + 2, "has 14 rows")]
)
def test_npy_has_the_rows_that_its_header_says(
    tmp_path: Path, whole: dict[str, bytes], rows: int, told: str
) -> None:
    path = tmp_path / "a.npy"
    head = whole["npy"][:128]
    body = np.column_stack([np.arange(rows) * 0.001, np.zeros((rows, 3))])
    path.write_bytes(head + body.astype("<f8").tobytes())
    with pytest.raises(UsageError, match=told):
        read(path, axes="XYA")


@pytest.mark.parametrize(
    ("array", "told"),
    [
        (np.zeros(5), "shape"),
        (np.zeros((5, 4), np.float32), "float32"),
        (np.asfortranarray(np.zeros((5, 4))), "C order"),
        (np.zeros((5, 3)), "has 3 columns"),
        (np.array([["a"] * 4] * 3), "<U1"),
        (np.full((5, 4), np.nan), "row 1 holds"),
    ],
)
def test_npy_is_a_table_of_doubles(tmp_path: Path, array: np.ndarray, told: str) -> None:
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(UsageError, match=told):
        read(tmp_path / "a.npy", axes="XYA")


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"x_mm": np.zeros(3)}, "needs t_s and a position"),
        ({"t_s": np.arange(3.0)}, "needs t_s and a position"),
        ({"t_s": np.arange(3.0), "x_mm": np.zeros(2)}, "columns differ in shape"),
        ({"t_s": np.zeros((2, 2)), "x_mm": np.zeros((2, 2))}, "columns differ in shape"),
        ({"t_s": np.arange(3.0), "x_mm": np.array(["a", "b", "c"])}, "holds no plain numbers"),
        ({"t_s": np.arange(3.0), "x_mm": np.array([None, 1, 2], object)}, "is not an npz file"),
        ({"t_s": np.array([0, 1, 5.0]), "x_mm": np.zeros(3)}, "row 2"),
        ({"t_s": np.arange(3.0), "x_mm": np.array([0, np.inf, 0])}, "row 2 holds"),
    ],
)
def test_npz_has_a_time_and_positions_of_one_length(
    tmp_path: Path, columns: dict[str, Any], told: str
) -> None:
    np.savez(tmp_path / "a.npz", **columns)
    with pytest.raises(UsageError, match=told):
        read(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"t_s": [0.0, 0.001]}, "needs t_s and a position"),
        ({"t_s": ["0", "a"], "x_mm": [0.0, 1.0]}, "is not an Arrow file"),
        ({"t_s": [0.0, None], "x_mm": [0.0, 1.0]}, "row 2 holds"),
        ({"t_s": [0.0, 0.001], "x_mm": [[0.0], [1.0]]}, "is not an Arrow file"),
    ],
)
def test_arrow_has_numbers(tmp_path: Path, columns: dict[str, Any], told: str) -> None:
    pa = pytest.importorskip("pyarrow")
    table = pa.table(columns)
    with pa.ipc.new_file(tmp_path / "a.arrow", table.schema) as file:
        file.write_table(table)
    with pytest.raises(UsageError, match=told):
        read(tmp_path / "a.arrow")


def test_arrow_integers_and_single_precision_are_numbers_too(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    table = pa.table({"t_s": [0.0, 0.5, 1.0], "x_mm": pa.array([1, 2, 3], pa.int32())})
    with pa.ipc.new_file(tmp_path / "a.arrow", table.schema) as file:
        file.write_table(table)
    assert read(tmp_path / "a.arrow")[2].tolist() == [[1.0], [2.0], [3.0]]


@pytest.mark.parametrize(
    "first",
    [
        b"# x_mm y_mm every 0.0.1 s\n",
        b"# x_mm y_mm every 0 s\n",
        b"# x_mm y_mm every 1e999 s\n",
        b"# x_mm y_furlong every 0.001 s\n",
        b"# two pins\n",
        b"",
    ],
)
def test_a_hal_stream_that_does_not_say_its_axes_has_to_be_told(tmp_path: Path, first: bytes) -> None:
    path = tmp_path / "a.hal"
    path.write_bytes(first + b"1 2\n3 4\n")
    with pytest.raises(UsageError, match="does not name its axes"):
        read(path)
    with pytest.raises(UsageError, match="the period cannot be told"):
        read(path, axes="XY")
    axes, period, rows, _ = read(path, axes="YX", period_s=0.002)
    assert (axes, period, rows.tolist()) == ("YX", 0.002, [[1.0, 2.0], [3.0, 4.0]])


TEXT = "t_s,x_mm,a_deg\n0,1,90\n0.001,2,180\n"


@pytest.mark.parametrize(
    "content",
    [
        TEXT.encode("utf-8-sig"),
        TEXT.replace("\n", "\r\n").encode(),
        b"# logged by a drive\n#\n" + TEXT.encode(),
        TEXT.replace("t_s,x_mm,a_deg", '"T_S", "X_mm" ,A_DEG').encode(),
        TEXT.rstrip("\n").encode(),
        b"t_s,state,x_mm,a_deg,note\n0,idle,1,90,\n0.001,run,2,180,nan\n",
    ],
    ids=[
        "byte order mark",
        "carriage returns",
        "comments",
        "quotes and capitals",
        "no last line feed",
        "further columns of text",
    ],
)
def test_csv_of_spreadsheets_and_drives(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    axes, period, rows, _ = read(tmp_path / "a.csv")
    assert (axes, period) == ("XA", 0.001)
    np.testing.assert_allclose(rows, [[1.0, np.pi / 2], [2.0, np.pi]], rtol=1e-15)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (TEXT.encode("utf-16-le"), "names no time t_s"),
        (TEXT.replace(",", ";").encode(), "has semicolons between the columns"),
        (b"t_s,x_mm,X_MM\n0,1,2\n", "names x_mm twice"),
        (b"t_s,t_s,x_mm\n0,1,2\n", "names t_s twice"),
        (b"t_s,speed\n0,1\n", "names no axis position"),
        (b"\x00" * 5000, "names no time t_s"),
    ],
    ids=["UTF-16 without its mark", "semicolons", "an axis twice", "the time twice", "no axis", "zeros"],
)
def test_csv_headers_that_are_none(tmp_path: Path, content: bytes, told: str) -> None:
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(UsageError, match=told) as caught:
        read(tmp_path / "a.csv")
    assert caught.value.diagnostics[0].code == "setpoints-header"


def test_wanted_axes_are_picked_of_those_that_a_file_names(tmp_path: Path) -> None:
    for kind in ("csv", "jsonl", "npz", "arrow"):
        path = tmp_path / f"a.{kind}"
        write(path, kind, [stream(rows=ROWS)])
        axes, _, rows, _ = read(path, axes="ay")
        assert axes == "YA"
        np.testing.assert_allclose(rows, stream(rows=ROWS).position[:, 1:], atol=5.01e-10)
        with pytest.raises(UsageError):
            read(path, axes="Z")


def test_formats_are_known_by_their_first_bytes_whatever_the_name(
    tmp_path: Path, whole: dict[str, bytes]
) -> None:
    for kind in ("npy", "npz", "arrow", "jsonl", "csv"):
        path = tmp_path / f"{kind}.log"
        path.write_bytes(whole[kind])
        assert len(read(path, **options(kind))[2]) == ROWS
    with (
        pytest.raises(UsageError, match="format 'xlsx' is not one of csv, jsonl"),
        open_setpoints(path, format="xlsx"),
    ):
        pass


@pytest.mark.parametrize("act", ["write", "read"])
def test_without_pyarrow_the_package_to_install_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: dict[str, bytes], act: str
) -> None:
    (tmp_path / "a.arrow").write_bytes(whole["arrow"])
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    acts = {
        "read": lambda: read(tmp_path / "a.arrow"),
        "write": lambda: write(tmp_path / "b.arrow", "arrow", [stream()]),
    }
    with pytest.raises(UsageError, match="needs pyarrow") as caught:
        acts[act]()
    assert caught.value.diagnostics[0].hint == "pip install 'cncgen[arrow]'"
    assert not (tmp_path / "b.arrow").exists()


def test_npz_that_cannot_go_back_waits_in_a_file(
    whole: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pipe is no file that an archive can be read from."""

    class Pipe(io.BytesIO):
        def seekable(self) -> bool:
            return False

    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BufferedReader(Pipe(whole["npz"]))))  # type: ignore[arg-type]
    with open_setpoints("-") as source:
        assert len(source.collect()) == ROWS


def test_a_stream_joins_its_chunks_and_says_what_it_is() -> None:
    parts = [stream(rows=7), stream(rows=5, first=7)]
    joined = Setpoints("XYA", 0.001, 0, np.concatenate([p.position for p in parts]))
    from cncgen.setpoints.stream import SetpointStream

    collected = SetpointStream("s", "XYA", 0.001, iter(parts)).collect()
    np.testing.assert_array_equal(collected.position, joined.position)
    np.testing.assert_array_equal(collected.time_s, np.arange(12) * 0.001)


def test_an_archive_that_states_more_than_it_holds_allocates_nothing(tmp_path: Path) -> None:
    """A header of 10²⁰ rows, of which 8 are there."""
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**20},), }}".ljust(117) + "\n"
    head = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for name in ("t_s", "x_mm"):
            archive.writestr(f"{name}.npy", head + bytes(64))
    with pytest.raises(UsageError, match="shorter than its header says"):
        read(tmp_path / "a.npz")


def test_a_header_with_a_call_is_told_in_words(tmp_path: Path) -> None:
    """numpy's message showed the node of Python's syntax, with its address in memory."""
    header = b"{'descr': open('x'), 'fortran_order': False, 'shape': (1, 2)}\n"
    path = tmp_path / "call.npy"
    path.write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(16))
    with pytest.raises(UsageError, match="is not an npy file") as caught, open_setpoints(path, axes="X"):
        pass
    assert "object at" not in str(caught.value)


@pytest.mark.parametrize("claimed", [0, 2**60])
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_that_few_bytes_make_huge_is_refused_before_it_is_unpacked(
    compression: str, claimed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """20 MiB of zeros in some KiB, as MCAP's specification lays a chunk out; the bound is lowered for the test."""
    from cncgen.setpoints.readers import mcap

    pytest.importorskip("mcap")
    packing = pytest.importorskip("zstandard" if compression == "zstd" else "lz4.frame")
    zeros = bytes(20 * 2**20)
    packed = packing.ZstdCompressor().compress(zeros) if compression == "zstd" else packing.compress(zeros)
    monkeypatch.setattr(mcap, "MOST_UNPACKED", 2**20)

    def record(opcode: int, content: bytes) -> bytes:
        return struct.pack("<BQ", opcode, len(content)) + content

    def text(value: str) -> bytes:
        return struct.pack("<I", len(value)) + value.encode()

    chunk = (
        struct.pack("<QQQI", 0, 1, claimed, 0) + text(compression) + struct.pack("<Q", len(packed)) + packed
    )
    magic = b"\x89MCAP0\r\n"
    ends = record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + magic
    (tmp_path / "a.mcap").write_bytes(magic + record(1, text("ros2") + text("")) + record(6, chunk) + ends)
    with pytest.raises(UsageError, match="a chunk of it unpacks to more than 1 MiB"):
        read(tmp_path / "a.mcap")


@pytest.mark.parametrize(("sign", "name"), [("\t", "tabs"), (" ", "blanks")])
def test_other_signs_between_columns_are_named(tmp_path: Path, sign: str, name: str) -> None:
    (tmp_path / "a.csv").write_text(f"t_s{sign}x_mm\n0{sign}0\n")
    with pytest.raises(UsageError, match=f"has {name} between the columns, and a CSV file has commas"):
        open_setpoints(str(tmp_path / "a.csv")).__enter__()


@pytest.mark.parametrize(("kind", "digits"), [("csv", 1), ("hal", 1), ("csp", 0)])
def test_a_text_that_ends_amid_a_number_is_warned_of(
    tmp_path: Path, whole: dict[str, bytes], kind: str, digits: int
) -> None:
    """Cut by its line end and a digit, each row still has all its numbers; the last one of csp has one digit."""
    path = tmp_path / f"a.{kind}"
    text = whole[kind].rstrip()
    path.write_bytes(text[: len(text) - digits])
    with pytest.warns(RemarkWarning, match="setpoints-end"):
        read(path)


@pytest.mark.parametrize(("kind", "keep"), [("csv", 0), ("hal", 0), ("csp", 0), ("jsonl", 1)])
def test_a_text_that_is_whole_is_not_warned_of(
    tmp_path: Path, whole: dict[str, bytes], kind: str, keep: int
) -> None:
    """An object of JSON is whole by its bracket."""
    path = tmp_path / f"a.{kind}"
    path.write_bytes(whole[kind].rstrip() if keep else whole[kind])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(path)
