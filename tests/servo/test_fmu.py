"""The exported FMU against `simulate`, in fmpy, an importer of the Modelica Association's standard."""

from __future__ import annotations

import io
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen import pipeline
from cncgen.cli.app import run
from cncgen.diagnostics import UsageError
from cncgen.machine import Servo
from cncgen.setpoints.record import Setpoints
from cncgen.units import file_unit, to_file

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="an FMU is compiled by a C compiler")

PERIOD = 0.001
#: Tables of every model, with friction, backlash, encoder steps, bounds and dead time among them.
SERVOS = {
    "first-order": {"position_gain_1_s": 60.0, "time_constant_s": 0.004, "saturation_mm_s": 25.0},
    "first-order with play": {
        "position_gain_1_s": 40.0,
        "coulomb_lag_mm": 0.01,
        "backlash_mm": 0.02,
        "encoder_resolution_mm": 0.001,
        "control_period_s": 0.0005,
    },
    "pi-p-feedforward": {
        "velocity_pole_1_s": 36.4609,
        "velocity_gain_1_s": 346.592,
        "integral_rate_1_s": 146.167,
        "position_gain_1_s": 121.31,
        "feedforward_gain": 0.961191,
        "feedforward_filter_rad_s": 315.347,
    },
    "plant with friction": {
        "numerator": [40.0],
        "denominator": [0.02, 1.0, 0.0],
        "position_gain_1_mm": 0.4,
        "coulomb": 0.05,
        "saturation": 0.8,
    },
    "plant with dead time": {
        "numerator": [40.0],
        "denominator": [0.01, 1.0, 0.0],
        "position_gain_1_mm": 0.5,
        "delay_s": 0.0013,
    },
    "transfer-function": {"numerator": [50.0], "denominator": [1.0, 50.0], "delay_s": 0.0025},
}


def motion(count: int = 800) -> np.ndarray:
    """Return a motion that reverses, and stands at the end: 5 mm and 2 Hz, shape (count,), from 3 mm on."""
    t = PERIOD * np.arange(count)
    moving = 3.0 + 5.0 * np.sin(4.0 * np.pi * t) ** 2
    moving[600:] = moving[600]
    return moving


@pytest.fixture
def unit(tmp_path: Path) -> Iterator[Any]:
    """Open FMUs; free them at the end."""
    opened: list[Any] = []

    def open_unit(content: bytes) -> tuple[Any, dict[str, int]]:
        path = tmp_path / "axes.fmu"
        path.write_bytes(content)
        about = fmpy.read_model_description(str(path))
        folder = fmpy.extract(str(path), str(tmp_path / "unpacked"))
        slave = fmpy.fmi2.FMU2Slave(
            guid=about.guid,
            unzipDirectory=folder,
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName="axes",
        )
        slave.instantiate()
        opened.append(slave)
        return slave, {variable.name: variable.valueReference for variable in about.modelVariables}

    yield open_unit
    for slave in opened:
        slave.terminate()
        slave.freeInstance()


def outputs(
    slave: Any, names: dict[str, int], letter: str, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, force and saturation, shapes (n,), of an FMU on setpoints that rise from row to row."""
    command = [names[f"{letter}_cmd_{file_unit(letter.upper())}"]]
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal(command, [rows[0]])
    slave.exitInitializationMode()
    position, force, saturated = [slave.getReal([command[0] + 1])[0]], [], []
    for k in range(len(rows) - 1):
        slave.setReal(command, [rows[k]])
        slave.setRealInputDerivatives(command, [1], [(rows[k + 1] - rows[k]) / PERIOD])
        slave.doStep(currentCommunicationPoint=k * PERIOD, communicationStepSize=PERIOD)
        position.append(slave.getReal([command[0] + 1])[0])
        force.append(slave.getReal([command[0] + 2])[0])
        saturated.append(bool(slave.getBoolean([command[0] + 3])[0]))
    return np.array(position), np.array(force), np.array(saturated)


@pytest.mark.parametrize("name", SERVOS)
def test_it_moves_as_simulate_does(name: str, unit: Any) -> None:
    servo = Servo(name.partition(" ")[0], SERVOS[name])
    rows = motion()
    setpoints = Setpoints("X", PERIOD, 0, rows[:, None])
    (response,) = pipeline.simulate(setpoints, {"X": servo})
    slave, names = unit(pipeline.fmu({"X": servo}))
    position, force, saturated = outputs(slave, names, "x", rows)
    assert position == pytest.approx(response.position[:, 0], abs=1e-9)
    assert force == pytest.approx(response.force[:-1, 0], abs=1e-9 * max(1.0, np.abs(response.force).max()))
    assert (saturated == response.saturated[:-1, 0]).all()
    assert np.ptp(position) > 1.0


def test_rotary_axes_are_in_degrees(unit: Any) -> None:
    servo = Servo("first-order", {"position_gain_1_s": 60.0, "time_constant_s": 0.004})
    rows = motion()
    setpoints = Setpoints("A", PERIOD, 0, rows[:, None] / to_file("A"))
    (response,) = pipeline.simulate(setpoints, {"A": servo})
    slave, names = unit(pipeline.fmu({"A": servo}))
    position, _, _ = outputs(slave, names, "a", rows)
    assert position == pytest.approx(response.position[:, 0] * to_file("A"), abs=1e-9)


def test_fmpy_finds_the_unit_of_a_machine_valid(tmp_path: Path) -> None:
    path = tmp_path / "table.fmu"
    assert run(["simulate", "-m", "xy-table", "--fmu", str(path), "-q"]) == 0
    assert fmpy.validation.validate_fmu(str(path)) == []


def test_fmpys_own_simulation_of_two_axes(tmp_path: Path) -> None:
    """fmpy interpolates the setpoints itself and holds them over a step, which is all that a sampled controller sees of them."""
    servos = {
        letter: Servo("plant", SERVOS[name])
        for letter, name in (("X", "plant with friction"), ("Y", "plant with dead time"))
    }
    path = tmp_path / "axes.fmu"
    path.write_bytes(pipeline.fmu(servos))
    rows = np.column_stack([motion(), 10.0 - motion()])
    (response,) = pipeline.simulate(Setpoints("XY", PERIOD, 0, rows), servos)
    t = PERIOD * np.arange(len(rows))
    signals = np.array(
        list(zip(t, rows[:, 0], rows[:, 1], strict=True)),
        dtype=[("time", float), ("x_cmd_mm", float), ("y_cmd_mm", float)],
    )
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=float(t[-1]),
        output_interval=PERIOD,
        input=signals,
        output=["x_mm", "y_mm"],
    )
    assert len(found) == len(rows)
    assert found["x_mm"] == pytest.approx(response.position[:, 0], abs=1e-9)
    assert found["y_mm"] == pytest.approx(response.position[:, 1], abs=1e-9)


def test_the_same_axes_give_the_same_unit_and_its_sources_are_in_it() -> None:
    first, second = (pipeline.fmu("xy-table") for _ in range(2))
    names = zipfile.ZipFile(io.BytesIO(first)).namelist()
    assert "modelDescription.xml" in names
    assert "sources/cncgen_axes.c" in names
    texts = [zipfile.ZipFile(io.BytesIO(one)).read("sources/cncgen_axes.c") for one in (first, second)]
    assert texts[0] == texts[1]


def test_steps_that_are_no_multiple_of_the_period_are_refused(unit: Any) -> None:
    slave, _ = unit(pipeline.fmu("xy-table"))
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.0007)


@pytest.mark.parametrize("controller", ["ccc", "tcf", "zpetc", "feedforward", "mirror", "zpetc+ccc"])
def test_controllers_that_see_more_than_an_axis_are_refused_by_name(controller: str) -> None:
    servo = Servo("first-order", {"position_gain_1_s": 60.0, "time_constant_s": 0.004})
    with pytest.raises(UsageError) as raised:
        pipeline.fmu({"X": servo, "Y": servo}, controller=controller)
    assert raised.value.diagnostics[0].code == "fmu-scheme"
    assert f"controller {controller}" in raised.value.diagnostics[0].message


def test_noise_is_refused() -> None:
    servo = Servo("first-order", {"position_gain_1_s": 60.0, "noise_rms_mm": 0.001})
    with pytest.raises(UsageError, match="noise_rms"):
        pipeline.fmu({"X": servo})


def test_a_missing_compiler_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    path = tmp_path / "t.fmu"
    assert run(["simulate", "-m", "xy-table", "--fmu", str(path)]) == 2
    assert not path.exists()
