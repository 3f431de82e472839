"""The response file has the columns and units that its header names."""

import math

import numpy as np
import pytest

from cncgen.machine.record import Servo
from cncgen.servo.response_csv import columns, matrix, written
from cncgen.servo.simulate import simulate

from .bench import circle, profile, run, stream


class Memory:
    """A sink that keeps what it is given."""

    def __init__(self):
        self.text = b""

    def write(self, data):
        self.text += bytes(data)


def test_header_and_rows():
    rows = circle(10.0, 50.0)[:300]
    sink = Memory()
    assert sum(map(len, written(sink, simulate(stream(rows), profile("die-bonder"))))) == 300
    lines = sink.text.decode().splitlines()
    assert lines[0] == (
        "t_s,x_cmd_mm,x_mm,x_force,x_saturated,y_cmd_mm,y_mm,y_force,y_saturated,contour_error_mm"
    )
    assert len(lines) == 301
    table = np.array([[float(v) for v in line.split(",")] for line in lines[1:]])
    response = run(rows, profile("die-bonder"))
    assert table[:, 0] == pytest.approx(np.arange(300) * 0.001)
    assert table[:, 6] == pytest.approx(response.position[:, 1], abs=5e-10)
    assert table[:, 3] == pytest.approx(response.force[:, 0], abs=5e-10)
    assert table[:, 9] == pytest.approx(response.contour_error_mm, abs=5e-10)
    assert {line.split(",")[4] for line in lines[1:]} <= {"0", "1"}


def test_rotary_axes_are_in_degrees():
    servo = Servo("first-order", {"position_gain_1_s": 50.0})
    response = run(np.linspace(0.0, math.pi, 100)[:, None], {"C": servo}, axes="C")
    assert columns("C") == ["t_s", "c_cmd_deg", "c_deg", "c_force", "c_saturated"]
    table = matrix(response)
    assert table[-1, 1] == pytest.approx(180.0)
    assert table[-1, 3] == pytest.approx(math.degrees(response.force[-1, 0]))
