"""Formats of setpoints opened by their own tools: columns to the last bit, and the metadata that goes along."""

from __future__ import annotations

import html
import json
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cncgen.diagnostics import UsageError
from cncgen.files import open_output
from cncgen.machine import Drive
from cncgen.setpoints.columns import Layout
from cncgen.setpoints.joint_trajectory import JointPoints, decode, encode
from cncgen.setpoints.readers import open_setpoints
from cncgen.setpoints.record import Setpoints
from cncgen.setpoints.writers import open_writer

ABOUT = {"program": "part.nc", "machine": "mill"}


def chunks(rows: int = 5000, axes: str = "XYA", pieces: int = 3) -> list[Setpoints]:
    """Return consecutive chunks of smooth setpoints with signals; rotary axes in rad."""
    time = np.arange(rows)[:, None] * 0.001
    place = 40.0 * np.sin(time * np.arange(1, len(axes) + 1) + 0.1)
    place[:, [k for k, axis in enumerate(axes) if axis in "ABC"]] /= 40.0
    signals = {
        "vel": np.gradient(place, 0.001, axis=0),
        "acc": place[::-1].copy(),
        "line": np.arange(rows) // 7,
    }
    found = []
    for part in np.array_split(np.arange(rows), pieces):
        where = slice(part[0], part[-1] + 1)
        found.append(
            Setpoints(axes, 0.001, int(part[0]), place[where], {n: s[where] for n, s in signals.items()})
        )
    return found


def written(path: Path, kind: str, parts: list[Setpoints], drives: dict[str, Drive] | None = None) -> Layout:
    layout = Layout(parts[0].axes, 0.001, ("vel", "line"), ABOUT, drives or {})
    with open_output(path) as sink:
        writer = open_writer(kind, sink, layout)
        for part in parts:
            writer.write(part)
        writer.close()
    return layout


def table(layout: Layout, parts: list[Setpoints]) -> dict[str, np.ndarray]:
    """Return the columns that a file should have."""
    return dict(zip(layout.names, np.concatenate([layout.matrix(part) for part in parts]).T, strict=True))


def test_parquet_by_pyarrow(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    parts = chunks()
    layout = written(tmp_path / "a.parquet", "parquet", parts)
    read = parquet.read_table(tmp_path / "a.parquet")
    for name, column in table(layout, parts).items():
        np.testing.assert_array_equal(read.column(name).to_numpy(), column)
    assert read.schema.metadata[b"machine"] == b"mill"
    assert read.schema.metadata[b"period_s"] == b"0.001"


@pytest.mark.parametrize("module", ["pandas", "polars"])
def test_parquet_by_tables(tmp_path: Path, module: str) -> None:
    tables = pytest.importorskip(module)
    parts = chunks()
    layout = written(tmp_path / "a.parquet", "parquet", parts)
    frame = tables.read_parquet(tmp_path / "a.parquet")
    for name, column in table(layout, parts).items():
        np.testing.assert_array_equal(frame[name].to_numpy(), column)


def test_parquet_by_duckdb(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    parts = chunks()
    written(tmp_path / "a.parquet", "parquet", parts)
    query = f"select count(*), max(x_mm), min(line) from '{tmp_path / 'a.parquet'}'"
    rows, most, first = duckdb.sql(query).fetchall()[0]
    assert (rows, first) == (5000, 0)
    assert most == max(part.position[:, 0].max() for part in parts)


def test_mat_by_scipy(tmp_path: Path) -> None:
    from scipy.io import loadmat

    parts = chunks()
    layout = written(tmp_path / "a.mat", "mat", parts)
    read = loadmat(tmp_path / "a.mat")
    for name, column in table(layout, parts).items():
        assert read[name].shape == (5000, 1)
        np.testing.assert_array_equal(read[name].ravel(), column)
    assert read["metadata"]["machine"][0, 0].item() == "mill"
    assert read["period_s"].item() == 0.001


def test_mat_by_octave(tmp_path: Path) -> None:
    """octave reads every column and the metadata, and writes the columns as hexadecimal doubles, which are exact."""
    octave = shutil.which("octave-cli")
    if octave is None:
        pytest.skip("octave is not installed")
    parts = chunks()
    layout = written(tmp_path / "a.mat", "mat", parts)
    script = 'a = load("a.mat"); printf("%s %.17g\\n", a.metadata.machine, a.period_s);'
    script += "".join(
        f'printf("%s\\n", reshape(num2hex(double(a.{name}))\', 1, []));' for name in layout.names
    )
    words = [octave, "--no-gui", "--norc", "--no-history", "--eval", script]
    run = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stderr
    about, *lines = run.stdout.splitlines()
    assert about == "mill 0.001"
    assert len(lines) == len(layout.names)
    for column, line in zip(table(layout, parts).values(), lines, strict=True):
        np.testing.assert_array_equal(np.frombuffer(bytes.fromhex(line), ">f8"), column)


def test_mat_is_the_same_file_each_time(tmp_path: Path) -> None:
    parts = chunks(50)
    for name in ("a.mat", "b.mat"):
        written(tmp_path / name, "mat", parts)
    assert (tmp_path / "a.mat").read_bytes() == (tmp_path / "b.mat").read_bytes()


def test_hdf5_by_h5py(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    parts = chunks(40_000)
    layout = written(tmp_path / "a.h5", "hdf5", parts)
    with h5py.File(tmp_path / "a.h5") as read:
        for name, column in table(layout, parts).items():
            np.testing.assert_array_equal(read[name][:], column)
        assert read.attrs["machine"] == "mill"
        assert read.attrs["period_s"] == 0.001


def test_mf4_by_asammdf(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    parts = chunks()
    layout = written(tmp_path / "a.mf4", "mf4", parts)
    columns = table(layout, parts)
    with asammdf.MDF(tmp_path / "a.mf4") as read:
        for name in layout.names[1:]:
            signal = read.get(name)
            np.testing.assert_array_equal(signal.samples, columns[name])
            np.testing.assert_array_equal(signal.timestamps, columns["t_s"])
        assert '"machine": "mill"' in html.unescape(read.header.comment)


def test_mf4_says_the_unit_of_each_channel(tmp_path: Path) -> None:
    """As docs/formats.md has them: the units of velocity and feed once were the end of the column's name, "s"."""
    asammdf = pytest.importorskip("asammdf")
    signals = {name: np.ones((3, 2)) for name in ("vel", "acc", "jerk")}
    signals |= {name: np.ones(3) for name in ("feed", "programmed", "line", "limit", "source")}
    part = Setpoints("XA", 0.001, 0, np.ones((3, 2)), signals=signals)
    with open_output(tmp_path / "a.mf4") as sink:
        writer = open_writer("mf4", sink, Layout("XA", 0.001, tuple(signals)))
        writer.write(part)
        writer.close()
    wanted = {
        "x_mm": "mm", "a_deg": "deg", "x_vel_mm_s": "mm/s", "a_vel_deg_s": "deg/s", "x_acc_mm_s2": "mm/s^2", "a_acc_deg_s2": "deg/s^2",
        "x_jerk_mm_s3": "mm/s^3", "a_jerk_deg_s3": "deg/s^3", "feed_mm_s": "mm/s", "programmed_feed_mm_s": "mm/s",
        "line": "", "limit": "", "source": "",
    }  # fmt: skip
    with asammdf.MDF(tmp_path / "a.mf4") as read:
        assert {name: read.get(name).unit for name in wanted} == wanted


def test_mcap_by_its_own_reader(tmp_path: Path) -> None:
    reading = pytest.importorskip("mcap.reader")
    parts = chunks(20_000)
    written(tmp_path / "a.mcap", "mcap", parts)
    rows, times = [], []
    with open(tmp_path / "a.mcap", "rb") as file:
        reader = reading.make_reader(file, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            assert (schema.name, schema.encoding) == ("trajectory_msgs/msg/JointTrajectory", "ros2msg")
            assert channel.message_encoding == "cdr"
            names, at, place = decode(message.data)
            assert names == ["x", "y", "a"]
            rows.append(place)
            times.append(at)
        (about,) = [m.metadata for m in reader.iter_metadata()]
    assert about["machine"] == "mill"
    wanted = np.concatenate([part.position for part in parts]) / [1000.0, 1000.0, 1.0]
    np.testing.assert_array_equal(np.concatenate(rows), wanted)
    np.testing.assert_array_equal(np.concatenate(times), np.arange(20_000) * 1_000_000)


@pytest.mark.parametrize(("velocity", "acceleration"), [(0, 0), (1, 0), (0, 1), (1, 1)])
@pytest.mark.parametrize("axes", ["X", "XY", "XYA"])
def test_messages_are_cdr_number_by_number(axes: str, velocity: int, acceleration: int) -> None:
    """Against a plain walk over the fields, each aligned to its size (DDS-XTypes 1.3, 7.4.3, XCDR1)."""
    n, count = len(axes), 4
    numbers = np.random.default_rng(3).uniform(-1, 1, (3, count, n))
    v, a = numbers[1][:, : n * velocity], numbers[2][:, : n * acceleration]
    time = np.array([0, 999_999_999, 1_000_000_000, 7_000_000_001])
    data = encode(JointPoints(axes, time, numbers[0], v, a))
    plain = b""

    def put(kind: str, value: object) -> None:
        nonlocal plain
        size = struct.calcsize(kind)
        plain += b"\0" * (-len(plain) % size) + struct.pack(f"<{kind}", value)

    def text(value: str) -> None:
        nonlocal plain
        put("I", len(value) + 1)
        plain += value.encode() + b"\0"

    put("i", 0), put("I", 0), text("machine"), put("I", n)
    for axis in axes:
        text(axis.lower())
    put("I", count)
    for k in range(count):
        for row in (numbers[0][k], v[k], a[k], ()):
            put("I", len(row))
            for value in row:
                put("d", value)
        put("i", int(time[k]) // 10**9), put("I", int(time[k]) % 10**9)
    assert data == b"\x00\x01\x00\x00" + plain


@pytest.mark.parametrize("kind", ["csp", "csp-raw"])
def test_a_drive_is_within_half_an_increment_at_every_sample(tmp_path: Path, kind: str) -> None:
    drives = {"X": Drive(1000.0, offset=123), "Y": Drive(4096.7, reversed=True), "A": Drive(30000.0)}
    parts = chunks(1_000_000, pieces=20)
    written(tmp_path / "a", kind, parts, drives)
    row = 0
    wanted = np.concatenate([part.position for part in parts])
    with open_setpoints(tmp_path / "a") as stream:
        assert (stream.axes, stream.period_s) == ("XYA", 0.001)
        for chunk in stream:
            off = np.abs(chunk.position - wanted[row : row + len(chunk)]) * [1000.0, 4096.7, 30000.0]
            assert off.max() <= 0.5 + 1e-9
            row += len(chunk)
    assert row == 1_000_000


def test_feedforward_of_a_drive_in_closed_form(tmp_path: Path) -> None:
    """Constant acceleration: central differences are exact, so the objects are those of v = a t and a."""
    time = np.arange(200) * 0.001
    place = 0.5 * 3000.0 * time[:, None] ** 2
    drive = Drive(1000.0, velocity_scale=10.0, torque_inertia=0.05, torque_viscous=0.1, torque_friction=20.0)
    written_part = [Setpoints("X", 0.001, 0, place, {"vel": place, "line": np.zeros(200, int)})]
    written(tmp_path / "a.csp", "csp", written_part, {"X": drive})
    lines = (tmp_path / "a.csp").read_text().splitlines()
    about = json.loads(lines[0][2:])
    assert about["drives"]["X"]["counts_per_mm"] == 1000.0
    assert lines[1] == "t_s,x_607a,x_60b0,x_60b1,x_60b2"
    row = [float(v) for v in lines[2 + 100].split(",")]
    velocity = 3000.0 * 0.1
    torque = round(0.05 * 3000.0 + 0.1 * velocity + 20.0)
    assert row == [0.1, round(1000.0 * 0.5 * 3000.0 * 0.01), 0, round(10.0 * velocity), torque]


def test_frames_are_packed(tmp_path: Path) -> None:
    parts = [Setpoints("XY", 0.001, 0, np.array([[0.0, 0.0], [1.0, -2.0]]), {})]
    layout = Layout("XY", 0.001, (), ABOUT, {"X": Drive(100.0), "Y": Drive(200.0)})
    with open_output(tmp_path / "a.cspraw") as sink:
        writer = open_writer("csp-raw", sink, layout)
        writer.write(parts[0])
        writer.close()
    data = (tmp_path / "a.cspraw").read_bytes()
    (size,) = struct.unpack("<I", data[4:8])
    about, frames = json.loads(data[8 : 8 + size]), data[8 + size :]
    assert about["frame_bytes"] == 28
    assert struct.unpack("<iiihiiih", frames[28:]) == (100, 0, 50000, 0, -400, 0, -200000, 0)


@pytest.mark.parametrize(
    ("drive", "place", "told"),
    [
        (Drive(1e6), 3000.0, "target position 607Ah of axis X is 3e+09, beyond 2147483647"),
        (Drive(100.0, torque_inertia=10.0), 100.0, "torque offset 60B2h of axis X"),
    ],
)
def test_an_object_that_cannot_hold_its_number_is_refused(
    tmp_path: Path, drive: Drive, place: float, told: str
) -> None:
    part = Setpoints("X", 0.001, 0, np.array([[0.0], [place], [place]]))
    with pytest.raises(UsageError) as caught:
        written(tmp_path / "a.csp", "csp", [part], {"X": drive})
    assert told in caught.value.diagnostics[0].message
    assert not (tmp_path / "a.csp").exists()


def test_a_machine_without_drives_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"drive scaling of axis X, Y"), open_output(tmp_path / "a") as sink:
        open_writer("csp", sink, Layout("XY", 0.001))
