"""Setpoint files: each format read back, the CSV to the letter, and what is wrong with a file."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.diagnostics import RemarkWarning, UsageError
from cncgen.files import open_output
from cncgen.machine import Drive
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.readers import open_setpoints
from cncgen.setpoints.readers.blocks import FileBlock, stream_of
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers import FORMATS, format_of, open_writer

#: A drive an axis; 2**20 increments a mm: a ball screw of 10 mm with an encoder of 23 bits.
DRIVES = {axis: Drive(2.0**20, offset=-7, reversed=axis == "Y", velocity_scale=1.0) for axis in "XYZABC"}


def stream(axes: str = "XYA", rows: int = 10, first: int = 0, seed: int = 1) -> Setpoints:
    """Some setpoints; rotary axes in rad."""
    rng = np.random.default_rng(seed)
    position = rng.uniform(-100, 100, (rows, len(axes)))
    if "A" in axes:
        position[:, axes.index("A")] = np.linspace(-np.pi, np.pi, rows)
    return Setpoints(axes, 0.001, first, position)


def write(path: Path, kind: str, chunks: list[Setpoints], signals: tuple[str, ...] = ()) -> None:
    with open_output(path) as sink:
        writer = open_writer(
            kind, sink, Layout(chunks[0].axes, chunks[0].period_s, signals, {"program": "part.nc"}, DRIVES)
        )
        for chunk in chunks:
            writer.write(chunk)
        writer.close()


def read(path: Path, **options: object) -> tuple[str, float, np.ndarray, list[int]]:
    with open_setpoints(path, **options) as source:  # type: ignore[arg-type]
        chunks = list(source.chunks)
        rows = np.concatenate([c.position for c in chunks])
        return source.axes, source.period_s, rows, [c.first for c in chunks]


def test_csv_to_the_letter(tmp_path: Path) -> None:
    chunk = Setpoints(
        "XA",
        0.001,
        0,
        np.array([[0.0, 0.0], [1 / 3, np.pi / 2]]),
        {"vel": np.array([[0.0, 0.0], [1.5, np.pi]]), "feed": np.array([0.0, 2.5]), "line": np.array([3, 4])},
    )
    write(tmp_path / "a.csv", "csv", [chunk], ("vel", "feed", "line"))
    assert (tmp_path / "a.csv").read_text() == (
        "t_s,x_mm,a_deg,x_vel_mm_s,a_vel_deg_s,feed_mm_s,line\n"
        "0.000000000,0.000000000,0.000000000,0.000000000,0.000000000,0.000000000,3\n"
        "0.001000000,0.333333333,90.000000000,1.500000000,180.000000000,2.500000000,4\n"
    )


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_reads_back(tmp_path: Path, kind: str) -> None:
    chunks = [stream(rows=7), stream(rows=5, first=7, seed=2)]
    path = tmp_path / f"out.{kind}"
    write(path, kind, chunks)
    axes, period, rows, first = read(path, axes="XYA" if kind in ("npy", "f64") else None)
    assert (axes, period, first[0]) == ("XYA", 0.001, 0)
    expected = np.concatenate([c.position for c in chunks])
    exact = kind in ("npy", "npz", "f64", "arrow", "parquet", "mat", "hdf5", "mf4")
    # Text has nine decimals, a drive 2**-20 mm; metres and back are two roundings.
    slack = {"csp": 2**-21 + 1e-12, "csp-raw": 2**-21 + 1e-12, "mcap": 3e-14}.get(kind, 5.01e-10)
    np.testing.assert_allclose(rows, expected, rtol=1e-15 if exact else 0, atol=0 if exact else slack)


def test_npy_and_npz_as_numpy_sees_them(tmp_path: Path) -> None:
    chunk = stream("XY")
    write(tmp_path / "a.npy", "npy", [chunk])
    write(tmp_path / "a.npz", "npz", [chunk])
    table = np.load(tmp_path / "a.npy")
    np.testing.assert_array_equal(table, np.column_stack([chunk.time_s, chunk.position]))
    with np.load(tmp_path / "a.npz") as archive:
        assert archive.files == ["t_s", "x_mm", "y_mm", "period_s"]
        assert archive["period_s"] == 0.001
        np.testing.assert_array_equal(archive["y_mm"], chunk.position[:, 1])


def test_jsonl_and_hal_lines(tmp_path: Path) -> None:
    chunk = Setpoints("XY", 0.001, 0, np.array([[0.5, -1.0], [1.0, 2.0]]))
    write(tmp_path / "a.jsonl", "jsonl", [chunk])
    lines = (tmp_path / "a.jsonl").read_text().splitlines()
    assert json.loads(lines[1]) == {"t_s": 0.001, "x_mm": 1.0, "y_mm": 2.0}
    write(tmp_path / "a.hal", "hal", [chunk])
    assert (tmp_path / "a.hal").read_text() == (
        "# x_mm y_mm every 0.001 s\n0.500000000 -1.000000000\n1.000000000 2.000000000\n"
    )


@pytest.mark.parametrize("kind", sorted({*FORMATS} - {"hdf5", "mat", "parquet", "arrow"}))
def test_a_pipe_takes_the_same_file(
    tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes], kind: str
) -> None:
    """The formats that are left out have no bytes of their own: libraries write them, with times and seeds."""
    chunk = stream()
    layout = Layout(chunk.axes, chunk.period_s, (), {"program": "part.nc"}, DRIVES)
    write(tmp_path / "a", kind, [chunk])
    with open_output(None) as sink:
        writer = open_writer(kind, sink, layout)
        writer.write(chunk)
        writer.close()
    assert capfdbinary.readouterr().out == (tmp_path / "a").read_bytes()


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("way", ["pipe", "file"])
def test_standard_input_is_read_as_the_file_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, way: str
) -> None:
    """A pipe cannot be gone back in; a file behind standard input is not one in a process that has its own."""
    path = tmp_path / f"out.{kind}"
    write(path, kind, [stream("XY")])
    axes = "XY" if kind in ("npy", "f64", "hal") else None
    with subprocess.Popen(["cat", path], stdout=subprocess.PIPE) as cat, open(path, "rb") as file:
        standard = os.dup(0)
        os.dup2(cat.stdout.fileno() if way == "pipe" else file.fileno(), 0)
        try:
            monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(os.fdopen(0, "rb", closefd=False)))
            found, _, rows, _ = read("-", format=kind, axes=axes, period_s=0.001 if axes else None)
        finally:
            os.dup2(standard, 0)
            os.close(standard)
    assert found == "XY"
    np.testing.assert_allclose(rows, read(path, axes=axes, period_s=0.001 if axes else None)[2])


def test_format_by_suffix() -> None:
    names = ("a.csv", "b.NPZ", "c", None, "d.h5", "/dev/fd/3", "/dev/shm.d/x")
    assert [format_of(p) for p in names] == ["csv", "npz", "csv", "csv", "hdf5", "csv", "csv"]
    assert format_of("a.csv", "hal") == "hal"


@pytest.mark.parametrize("name", ["d.txt", "out.xlsx", "part.nc"])
def test_an_unknown_suffix_is_an_error_that_lists_the_formats(name: str) -> None:
    with pytest.raises(UsageError) as caught:
        format_of(name)
    (fault,) = caught.value.diagnostics
    assert fault.code == "setpoint-format"
    assert Path(name).suffix in fault.message
    assert all(f".{kind}" in fault.hint for kind in FORMATS)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("kind", FORMATS)
def test_no_machine_is_sent_nan(tmp_path: Path, kind: str, value: float) -> None:
    chunk = stream()
    chunk.position[3, 1] = value
    with pytest.raises(FloatingPointError, match="setpoint 3: y_mm"):
        write(tmp_path / "a", kind, [chunk])
    assert list(tmp_path.iterdir()) == []


@given(
    period=st.sampled_from([0.001, 0.0005, 1 / 3000, 0.0000625, 0.01]),
    rows=st.integers(2, 40),
    first=st.integers(0, 5),
    carriage=st.booleans(),
)
def test_csv_of_others(
    tmp_path_factory: pytest.TempPathFactory, period: float, rows: int, first: int, carriage: bool
) -> None:
    """Columns in any order, capitals, spaces, more columns, exponents, comments, another first time."""
    path = tmp_path_factory.mktemp("csv") / "other.csv"
    end = "\r\n" if carriage else "\n"
    lines = [f"{k * 0.5!r}, {(first + k) * period:.12g} ,{1e-7 * k:e},7,{-k}" for k in range(rows)]
    path.write_text(end.join(["# a log", "Y_mm, T_S,x_mm,other,c_deg", *lines, ""]), newline="")
    with open_setpoints(path) as source:
        assert source.axes == "YXC"
        assert source.period_s == pytest.approx(period, abs=1e-9)
        chunks = list(source.chunks)
    assert chunks[0].first == first
    position = np.concatenate([c.position for c in chunks])
    k = np.arange(rows)
    np.testing.assert_allclose(position, np.column_stack([k * 0.5, k * 1e-7, -np.deg2rad(k)]), rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        ("", "setpoints-empty", None),
        ("x,y\n1,2\n", "setpoints-header", 1),
        ("t_s,x_mm\n", "setpoints-empty", None),
        ("t_s,x_mm\n0,1\n", "setpoints-period", None),
        ("t_s,x_mm\n0,1\n0,1\n", "setpoints-period", None),
        ("t_s,x_mm\n0,1\n.001,1\n.002,1\n.004,1\n", "setpoints-period", None),
        ("t_s,x_mm\n0,1\n.001,x\n.002,nan\n.003,1e999\n", "setpoints-number", 3),
        ("t_s,x_mm\n0,1\n.001,1,2\n", "setpoints-columns", 3),
        ("\x00\x01\x02", "setpoints-header", 1),
    ],
)
def test_faults_of_csv(tmp_path: Path, text: str, code: str, place: int | None) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(UsageError) as caught:
        read(path)
    first = caught.value.diagnostics[0]
    assert first.code == code
    assert (first.span.line if first.span else None) == place
    assert str(path) in first.render()


@pytest.mark.parametrize(
    ("kind", "head", "row"),
    [
        ("csv", "t_s,x_mm\n", "0,x"),
        ("csv", "t_s,x_mm\n", "0,1,2"),
        ("jsonl", "", "{}"),
        ("hal", "# x_mm every 1 s\n", "x"),
    ],
)
def test_faults_of_many_rows_are_counted(tmp_path: Path, kind: str, head: str, row: str) -> None:
    """Of 5000 rows with the same fault ten are shown, and one more diagnostic counts the others."""
    path = tmp_path / f"a.{kind}"
    path.write_text(head + f"{row}\n" * 5000)
    with pytest.raises(UsageError) as caught:
        read(path)
    *shown, rest = caught.value.diagnostics
    first = 1 + head.count("\n")
    assert [fault.span.line for fault in shown if fault.span] == list(range(first, first + 10))
    assert rest.message.endswith(f"4990 more rows like these, the last on line {first + 4999}")
    assert (rest.code, rest.values["rows"]) == (shown[0].code, 5000)


@pytest.mark.parametrize("kind", ["csv", "jsonl", "npz", "arrow"])
@pytest.mark.parametrize(
    ("column", "hint"),
    [
        ("y", "it is called y_mm"),
        ("x_deg", "it is called x_mm"),
        ("a_rad", "it is called a_deg"),
        ("Y_inch", "it is called y_mm"),
    ],
)
def test_a_position_in_another_unit_is_not_passed_over(
    tmp_path: Path, kind: str, column: str, hint: str
) -> None:
    path = tmp_path / f"a.{kind}"
    rows = [{"t_s": 0.001 * k, "z_mm": 1.0, column: 2.0} for k in range(3)]
    columns = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    if kind == "npz":
        np.savez(path, **columns)
    elif kind == "arrow":
        arrow = pytest.importorskip("pyarrow")
        batch = arrow.record_batch([*columns.values()], [*columns])
        with arrow.OSFile(str(path), "wb") as sink, arrow.ipc.new_file(sink, batch.schema) as writer:
            writer.write_batch(batch)
    else:
        lines = [",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]
        path.write_text("\n".join(lines if kind == "csv" else map(json.dumps, rows)))
    with pytest.raises(
        UsageError, match=f"the column {column.lower()} is not the position of axis"
    ) as caught:
        read(path)
    assert caught.value.diagnostics[0].hint == hint


def test_a_letter_that_is_no_axis_is_a_warning(tmp_path: Path) -> None:
    """Signals, other columns, and an axis in a second unit are passed over without a word."""
    path = tmp_path / "a.csv"
    path.write_text(
        "t_s,x_mm,q_mm,x_inch,k,x_vel_mm_s,u,v\n" + "".join(f"{k},1,2,3,4,5,6,7\n" for k in range(3))
    )
    with pytest.warns(RemarkWarning, match="the column q_mm names no axis and is passed over") as caught:
        axes, _, rows, _ = read(path)
    assert (axes, rows[0].tolist(), len(caught)) == ("X", [1.0], 1)


def test_comments_and_blank_lines_stand_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t_s,x_mm\n0,1\n\n# tool change\n0.001,2\n  \n0.002,4\n")
    _, period, rows, _ = read(path)
    assert (period, rows[:, 0].tolist()) == (0.001, [1.0, 2.0, 4.0])


def test_a_fault_far_to_the_right_is_pointed_at(tmp_path: Path) -> None:
    """A row of 400 columns: its excerpt is cut on the left, the caret stands under the cell."""
    path = tmp_path / "a.csv"
    names = ",".join(["t_s", *(f"c{k}" for k in range(1, 300)), "x_mm", *(f"c{k}" for k in range(301, 400))])
    cells = [f"{k:.3f}" for k in range(400)]
    cells[300] = "oops"
    path.write_text(names + "\n0" + ",1" * 399 + "\n" + ",".join(cells) + "\n")
    with pytest.raises(UsageError) as caught:
        read(path)
    (fault,) = caught.value.diagnostics
    excerpt, caret = fault.render().splitlines()[1:3]
    assert fault.span is not None
    assert fault.span.column == sum(len(cell) + 1 for cell in cells[:300]) + 1
    assert excerpt[caret.index("^") :].startswith("oops,")


@pytest.mark.parametrize("kind", ["csv", "jsonl", "hal"])
def test_numbers_that_decimals_cannot_hold_are_refused(tmp_path: Path, kind: str) -> None:
    """Doubles of 2⁵³ and more are no longer told apart by one."""
    whole = Setpoints("X", 0.001, 0, np.array([[2.0**53 - 1]]))
    write(tmp_path / f"a.{kind}", kind, [whole])
    assert "9007199254740991.000000000" in (tmp_path / f"a.{kind}").read_text()
    with pytest.raises(UsageError, match="setpoint-range"):
        write(tmp_path / f"b.{kind}", kind, [Setpoints("X", 0.001, 0, np.array([[-(2.0**53)]]))])
    assert not (tmp_path / f"b.{kind}").exists()


@pytest.mark.parametrize(
    "comment",
    [
        "# x_mm tool every 0.001 s",
        "# x_mm y_mm every 0 s",
        "# x_mm y_mm every 1e999 s",
        "# x_mm y_mm at 1 s",
        "# XY",
    ],
)
def test_other_comments_of_hal_say_nothing(tmp_path: Path, comment: str) -> None:
    path = tmp_path / "a.hal"
    path.write_text(f"{comment}\n1 2\n3 4\n")
    with pytest.raises(UsageError, match="hal does not name its axes"):
        read(path)
    axes, period, rows, _ = read(path, axes="YZ", period_s=0.002)
    assert (axes, period, rows.tolist()) == ("YZ", 0.002, [[1.0, 2.0], [3.0, 4.0]])


def test_every_faulty_line_of_hal_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.hal"
    path.write_text("# x_mm y_mm every 0.001 s\n1 2\n\n3\n4 5\nnan 1\n")
    with pytest.raises(UsageError) as caught:
        read(path)
    assert [d.span.line for d in caught.value.diagnostics if d.span] == [4, 6]


def test_every_faulty_row_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{k * 0.001:.3f},{k}" for k in range(100)]
    rows[20], rows[50], rows[51] = "0.020,?", "0.050", "1_0,1"
    path.write_text("t_s,x_mm\n" + "\n".join(rows))
    with pytest.raises(UsageError) as caught:
        read(path)
    places = [(d.span.line, d.span.column) for d in caught.value.diagnostics if d.span]
    assert places == [(22, 7), (52, 1), (53, 1)]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.npy", b"\x93NUMPY\x01\x00\x10\x00nonsense"),
        ("a.npz", b"PK\x03\x04nonsense"),
        ("a.f64", b"12345"),
        ("a.arrow", b"ARROW1nonsense"),
        ("a.jsonl", b'{"t_s": 0, "x_mm": 1}\n[1]\n{"t_s": 0.001}\n'),
        ("a.hal", b"1 2\n3\n"),
        ("a.csv", b"t_s,x_mm\n" + b"1" * 3_000_000),
    ],
)
def test_faults_of_the_others(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UsageError):
        read(tmp_path / name, axes="XY")


def test_long_files_come_in_chunks(tmp_path: Path) -> None:
    chunk = stream("XYZ", 100_000)
    write(tmp_path / "a.csv", "csv", [chunk])
    _, _, rows, first = read(tmp_path / "a.csv")
    assert len(first) > 2
    np.testing.assert_allclose(rows, chunk.position, atol=5.01e-10)


def test_reader_takes_what_a_pipe_has(monkeypatch: pytest.MonkeyPatch) -> None:
    text = io.TextIOWrapper(io.BufferedReader(io.BytesIO(b"t_s,x_mm\n0,0\n0.001,1\n")))  # type: ignore[arg-type]
    monkeypatch.setattr("sys.stdin", text)
    with open_setpoints("-") as source:
        assert [len(c) for c in source.chunks] == [2]


def test_rows_that_come_one_by_one_tell_the_period(tmp_path: Path) -> None:
    """A pipe may hand on a row at a time; a last row without a line feed is a block of its own."""
    rows = [FileBlock("X", np.array([k / 3000]).round(9), np.array([[0.1 * k]])) for k in range(3000)]
    for count in (2, 3, 999, 1001, 3000):
        stream = stream_of(iter(rows[:count]), "rows", None)
        assert stream.period_s == pytest.approx(1 / 3000, abs=2e-9 / min(count - 1, 999))
        assert len(stream.collect()) == count
    (tmp_path / "two.csv").write_text("t_s,x_mm\n0,0\n0.002,1")
    with open_setpoints(tmp_path / "two.csv") as stream:
        assert (stream.period_s, len(stream.collect())) == (0.002, 2)


def test_a_gap_is_named_where_it_is(tmp_path: Path) -> None:
    """The period is that of most rows: the mean step would put the blame on the second one."""
    path = tmp_path / "a.csv"
    rows = [f"{k / 1000:.3f},0" for k in range(100) if not 40 <= k < 50]
    path.write_text("t_s,x_mm\n" + "\n".join(rows) + "\n")
    with pytest.raises(UsageError, match=r"row 41 \(t = 0.05 s\) comes 0.011 s .* the period is 0.001 s"):
        read(path)
