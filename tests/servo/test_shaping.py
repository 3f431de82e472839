"""Input shapers: residual vibration against closed forms, several modes at once, limits, and the error of the path."""

import json
import math
import re

import numpy as np
import pytest

from cncgen.cli.app import run as cncgen
from cncgen.diagnostics import UsageError
from cncgen.machine.record import Servo
from cncgen.servo.shaping import SHAPERS, TOLERABLE, Mode, impulses, shaped, taps

from .bench import circle, run


def bang(rows=40, jerk=50_000.0):
    """A short move under full jerk, mm at 1 ms, at rest at both ends: it excites everything."""
    signs = np.concatenate([np.ones(rows), -np.ones(2 * rows), np.ones(rows)])
    return np.concatenate(
        [np.zeros(3), np.cumsum(np.cumsum(np.cumsum(np.concatenate([signs, -signs]) * jerk * 1e-9)))]
    )


def load_on_a_spring(modes):
    """The load of a two-mass axis whose motor follows its setpoint: a product of ω²/(s² + 2ζωs + ω²)."""
    below = np.ones(1)
    above = 1.0
    for mode in modes:
        omega = 2.0 * math.pi * mode.frequency_hz
        below, above = np.polymul(below, [1.0, 2.0 * mode.damping * omega, omega**2]), above * omega**2
    return {"X": Servo("transfer-function", {"numerator": [above], "denominator": below.tolist()})}


def rung(command, modes, start):
    """Complex amplitude of each mode at row 0, fitted to the axis's position after row `start`, where the command stands."""
    held = np.concatenate([command, np.full(start + 400 - len(command), command[-1])])
    position = run(held[:, None], load_on_a_spring(modes), "X").position[start:, 0] - command[-1]
    t = np.arange(start, start + len(position)) * 0.001
    basis = np.column_stack([part(np.exp(m.pole * t)) for m in modes for part in (np.real, np.imag)])
    found, *_ = np.linalg.lstsq(basis, position, rcond=None)
    assert np.abs(basis @ found - position).max() < 1e-4 * np.abs(position).max() + 1e-9
    return np.abs(found[0::2] - 1j * found[1::2])


@pytest.mark.parametrize("shaper", SHAPERS)
@pytest.mark.parametrize("off", [0.8, 0.93, 1.0, 1.1, 1.25])
def test_what_a_load_rings_is_what_the_closed_form_says(shaper, off):
    """Of a mode that is `off` times as fast as the shaper thinks: |Σ A_i e^(−s t_i)| (Singer and Seering 1990), within 1 %."""
    thought, mode = Mode(38.0, 0.05), Mode(38.0 * off, 0.05)
    motion = bang()
    command = shaped(motion[:, None], shaper, [thought], 0.001, [0]).command[:, 0]
    start = len(motion) + 60
    ratio = rung(command, [mode], start)[0] / rung(motion, [mode], start)[0]
    assert ratio == pytest.approx(impulses(shaper, thought).residual(mode), abs=0.01)


def test_the_closed_forms_are_those_of_the_sources():
    """Undamped: ZV leaves |cos(πr/2)| at r times the frequency, ZVD its square; EI leaves V at the frequency itself."""
    thought = Mode(40.0, 0.0)
    for r in (0.7, 0.9, 1.0, 1.2):
        mode = Mode(40.0 * r, 0.0)
        assert impulses("zv", thought).residual(mode) == pytest.approx(
            abs(math.cos(math.pi * r / 2)), abs=1e-12
        )
        assert impulses("zvd", thought).residual(mode) == pytest.approx(
            math.cos(math.pi * r / 2) ** 2, abs=1e-12
        )
    assert impulses("ei", thought).residual(thought) == pytest.approx(TOLERABLE)
    for shaper in ("zv", "zvd", "mzv"):
        assert impulses(shaper, Mode(40.0, 0.1)).residual(Mode(40.0, 0.1)) == pytest.approx(0.0, abs=1e-12)
    lengths = [impulses(shaper, thought).times[-1] * 40.0 for shaper in SHAPERS]
    assert lengths == pytest.approx([0.5, 1.0, 1.0, 0.75])


@pytest.mark.parametrize("shaper", ["zv", "zvd", "mzv"])
def test_two_modes_at_once_are_still(shaper):
    modes, motion = [Mode(38.0, 0.05), Mode(71.0, 0.03)], bang()
    start = len(motion) + 90
    command = shaped(motion[:, None], shaper, modes, 0.001, [0]).command[:, 0]
    before, after = rung(motion, modes, start), rung(command, modes, start)
    assert (after < 0.01 * before).all()


@pytest.mark.parametrize("shaper", SHAPERS)
def test_a_shaped_command_keeps_the_limits_of_its_motion(shaper):
    motion = bang()
    command = shaped(motion[:, None], shaper, [Mode(38.3, 0.05), Mode(71.7, 0.03)], 0.001, [0]).command[:, 0]
    weights = taps(shaper, [Mode(38.3, 0.05), Mode(71.7, 0.03)], 0.001)
    assert weights.min() >= 0.0
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    for order in (1, 2, 3):
        most = [np.abs(np.diff(np.pad(x, 3, mode="edge"), order)).max() for x in (command, motion)]
        assert most[0] <= most[1] * (1.0 + 1e-9)


def test_the_error_of_the_path_is_that_of_a_smaller_circle():
    """A steady circle shrinks to |Σ A_i e^(−iΩ t_i)| of its radius: cos(Ω Td/4) under ZV without damping."""
    rows = circle(10.0, 300.0, turns=3.0, ramp=0.4)
    found = shaped(rows, "zv", [Mode(25.0, 0.0)], 0.001, [0, 1])
    steady = found.command[len(rows) // 2 : -100]
    wanted = 10.0 * math.cos(30.0 * 0.04 / 4.0)
    assert np.hypot(*steady.T) == pytest.approx(np.full(len(steady), wanted), abs=1e-3)
    assert found.delay_s == pytest.approx(0.01)
    assert found.path_max_mm >= 10.0 - wanted - 1e-3


@pytest.mark.parametrize(
    ("shaper", "modes", "words"),
    [
        ("zw", [Mode(38.0, 0.05)], "no shaper is called 'zw'"),
        ("zv", [], "needs a mode"),
        ("zv", [Mode(38.0, 1.0)], "does not vibrate"),
        ("zv", [Mode(0.0, 0.1)], "does not vibrate"),
        ("zv", [Mode(300.0, 0.1)], "too fast"),
        # Half a period: 0.5 / 1e-9 Hz = 5e8 s without damping.
        ("zv", [Mode(1e-9, 0.0)], r"1e-09 Hz lasts 5e\+08 s, 5e\+11 setpoints of 1 ms; 100000 is the limit"),
    ],
)
def test_what_nobody_can_shape_is_refused(shaper, modes, words):
    with pytest.raises(UsageError, match=words):
        shaped(bang()[:, None], shaper, modes, 0.001, [0])


def test_compensate_shapes_programs_and_setpoints(tmp_path, programs, capfd):
    program, plan, command = str(programs / "square_r5.nc"), str(tmp_path / "p.csv"), str(tmp_path / "c.csv")
    summary = tmp_path / "s.json"
    more = ["--shaper", "mzv", "--modes", "38:0.05,71:0.03", "-o", command, "--summary", str(summary)]
    assert cncgen(["compensate", program, "-m", "xy-table", *more]) == 0
    assert "the command leaves the path by 0." in capfd.readouterr().err
    found = json.loads(summary.read_text())
    assert found["modes"] == [
        {"frequency_hz": 38.0, "damping": 0.05},
        {"frequency_hz": 71.0, "damping": 0.03},
    ]
    assert 0.0 < found["path_max_mm"] < 1.0
    assert cncgen(["plan", program, "-m", "xy-table", "-o", plan, "-q"]) == 0
    again = str(tmp_path / "again.csv")
    assert (
        cncgen(["compensate", plan, "--shaper", "mzv", "--modes", "38:0.05,71:0.03", "-o", again, "-q"]) == 0
    )
    ours, theirs = (np.loadtxt(name, delimiter=",", skiprows=1) for name in (command, again))
    assert ours == pytest.approx(theirs, abs=2e-9)
    assert cncgen(["compensate", plan, "--shaper", "zv", "-o", again]) == 2
    assert cncgen(["compensate", plan, "--shaper", "zv", "--modes", "38", "-o", again]) == 2
    assert "FREQUENCY:DAMPING" in capfd.readouterr().err


def test_a_shaped_command_of_a_plan_that_breaks_limits_is_refused(tmp_path, programs, capfd):
    """`ild` takes some 135 % of the jerk on the butterfly; shaped by 38 Hz that is still over 102 %, which was written in silence.

    How much depends on rounding: with a coordinate 10⁻¹² mm off the plan takes 6.969 to 6.990 s.
    """
    command = tmp_path / "c.csv"
    words = ["compensate", str(programs / "butterfly.nc"), "-m", "xy-table", "--feedrate", "ild"]
    words += ["--shaper", "zvd", "--modes", "38:0.05", "-o", str(command)]
    assert cncgen(words) == 3
    said = capfd.readouterr().err
    assert "compensate-limit" in said
    told = [float(each) for each in re.findall(r"([\d.]+) times the limit 50000", said)]
    assert not command.exists()
    assert cncgen([*words, "--no-limits", "-q"]) == 0
    rows = np.loadtxt(command, delimiter=",", skiprows=1)[:, 1:]
    peak = np.abs(np.diff(rows, 3, axis=0)).max() / 0.001**3 / 50000.0
    assert peak > 1.02
    assert max(told) == pytest.approx(peak, abs=1e-3)
