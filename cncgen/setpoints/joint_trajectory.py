"""ROS 2's `trajectory_msgs/msg/JointTrajectory` as bytes, and back: the common data representation (CDR) of DDS-XTypes 1.3.

Little-endian, each number aligned to its own size from the start of the message; four bytes in front say so. Positions are
in m and rad (REP 103), so mm are divided by 1000.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cncgen.units import is_rotary

Floats = NDArray[np.float64]

#: Name and definition of the type, as ROS 2 spells them.
TYPE = "trajectory_msgs/msg/JointTrajectory"
_RULE = "=" * 80
DEFINITION = f"""std_msgs/Header header
string[] joint_names
JointTrajectoryPoint[] points
{_RULE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_RULE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{_RULE}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
{_RULE}
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""
_ENCAPSULATION = b"\x00\x01\x00\x00"
_NANO = 1_000_000_000


@dataclass(frozen=True, slots=True)
class JointPoints:
    """Points of a trajectory.

    Attributes:
        axes: A letter a joint.
        time_ns: Shape (n,): time from the start of the program, ns.
        position: Shape (n, axes), m and rad.
        velocity: Shape (n, axes), m/s and rad/s, or (n, 0).
        acceleration: Shape (n, axes), m/s² and rad/s², or (n, 0).
    """

    axes: str
    time_ns: NDArray[np.int64]
    position: Floats
    velocity: Floats
    acceleration: Floats


def to_metres(values: Floats, axes: str) -> Floats:
    """Convert mm to m; columns of rotary axes stay in rad."""
    return np.where([is_rotary(axis) for axis in axes], values, values / 1000.0)


def from_metres(values: Floats, axes: str) -> Floats:
    """Convert m to mm; columns of rotary axes stay in rad."""
    return np.where([is_rotary(axis) for axis in axes], values, values * 1000.0)


def encode(points: JointPoints) -> bytes:
    """Return a message with these points."""
    head = struct.pack("<iI", 0, 0) + _text("machine", 8)
    head += struct.pack("<I", len(points.axes))
    for axis in points.axes:
        head += _text(axis.lower(), len(head))
    head += struct.pack("<I", len(points.position))
    body = b""
    for first, last in ((0, 1), (1, len(points.position))):
        if last > first:
            body += _rows(points, slice(first, last), (len(head) + len(body)) % 8).tobytes()
    return _ENCAPSULATION + head + body


def _text(text: str, at: int) -> bytes:
    """Return a string: length with the final zero, bytes, and what aligns the next length from `at`."""
    data = text.encode() + b"\0"
    whole = struct.pack("<I", len(data)) + data
    return whole + b"\0" * (-(at + len(whole)) % 4)


def _rows(points: JointPoints, rows: slice, at: int) -> NDArray[np.void]:
    """Return points as packed records that begin at `at` modulo 8.

    A first point ends where, modulo 8, every further one begins and ends, so two layouts serve a whole message.
    """
    fields: list[tuple] = []
    named = {"p": points.position, "v": points.velocity, "a": points.acceleration}
    offset = at
    for name, values in named.items():
        fields.append((f"{name}_count", "<u4"))
        offset += 4
        if values.shape[1]:
            if offset % 8:
                fields.append((f"{name}_pad", "<u4"))
                offset += 4
            fields.append((name, "<f8", (values.shape[1],)))
    fields += [("effort_count", "<u4"), ("sec", "<i4"), ("nanosec", "<u4")]
    count = rows.stop - rows.start
    records = np.zeros(count, np.dtype(fields))
    for name, values in named.items():
        records[f"{name}_count"] = values.shape[1]
        if values.shape[1]:
            records[name] = values[rows]
    records["sec"], records["nanosec"] = np.divmod(points.time_ns[rows], _NANO)
    return records


class _Cursor:
    """Reads aligned numbers from the body of a message."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def count(self) -> int:
        """Read an unsigned integer of four bytes."""
        self._at += -self._at % 4
        (value,) = struct.unpack_from("<I", self._data, self._at)
        self._at += 4
        return int(value)

    def text(self) -> str:
        """Read a string."""
        length = self.count()
        raw = self._data[self._at : self._at + length]
        if len(raw) < length:
            raise ValueError("a string is longer than the message")
        self._at += length
        return raw.rstrip(b"\0").decode()

    def doubles(self) -> Floats:
        """Read a sequence of doubles."""
        count = self.count()
        if count:
            self._at += -self._at % 8
        values = np.frombuffer(self._data, "<f8", count, self._at)
        self._at += 8 * count
        return values


def decode(data: bytes) -> tuple[list[str], NDArray[np.int64], Floats]:
    """Return names of joints, times from the start (ns) and positions, shape (n, joints), of a message.

    Raises:
        ValueError: The bytes do not form such a message (struct.error too).
    """
    if data[:4] != _ENCAPSULATION:
        raise ValueError("the message is not in little-endian CDR")
    cursor = _Cursor(data[4:])
    cursor.count(), cursor.count(), cursor.text()
    names = [cursor.text() for _ in range(_bounded(cursor.count(), data))]
    count = _bounded(cursor.count(), data)
    times, rows = np.empty(count, np.int64), np.empty((count, len(names)))
    for k in range(count):
        positions = cursor.doubles()
        if len(positions) != len(names):
            raise ValueError(f"point {k + 1} has {len(positions)} positions for {len(names)} joints")
        rows[k] = positions
        for _ in range(3):
            cursor.doubles()
        times[k] = cursor.count() * _NANO + cursor.count()
    return names, times, rows


def _bounded(count: int, data: bytes) -> int:
    """Return a count that fits into the message."""
    if count > len(data):
        raise ValueError(f"{count} items cannot be in {len(data)} bytes")
    return count
