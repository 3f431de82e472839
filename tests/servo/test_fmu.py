"""The exported FMU against `simulate`, in fmpy, an importer of the Modelica Association's standards."""

from __future__ import annotations

import ctypes
import io
import re
import shutil
import subprocess
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


class Importer:
    """A unit in fmpy, of FMI 2.0 or 3.0: the same calls for both."""

    def __init__(self, content: bytes, folder: Path) -> None:
        path = folder / "axes.fmu"
        path.write_bytes(content)
        about = fmpy.read_model_description(str(path))
        self.names = {variable.name: variable.valueReference for variable in about.modelVariables}
        self.new = about.fmiVersion == "3.0"
        #: What setpoints become in the step, by reference: one value, or one a period.
        self.coming: dict[int, Any] = {}
        self.asked: list[float] = []
        kind = fmpy.fmi3.FMU3Slave if self.new else fmpy.fmi2.FMU2Slave
        self.slave = kind(
            guid=about.guid,
            unzipDirectory=fmpy.extract(str(path), str(folder / "unpacked")),
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName="axes",
        )
        if self.new:
            inputs = [v.valueReference for v in about.modelVariables if v.causality == "input"]
            self.slave.instantiate(intermediateUpdate=self.between, requiredIntermediateVariables=inputs)
        else:
            self.slave.instantiate()

    def between(self, environment: Any, time: float, *about: Any) -> None:
        values = [np.atleast_1d(value)[len(self.asked)] for value in self.coming.values()]
        self.slave.setFloat64(list(self.coming), values)
        self.asked.append(time)

    def set(self, reference: int, value: float) -> None:
        (self.slave.setFloat64 if self.new else self.slave.setReal)([reference], [value])

    def get(self, reference: int) -> float:
        (value,) = (self.slave.getFloat64 if self.new else self.slave.getReal)([reference])
        return value

    def start(self) -> None:
        if not self.new:
            self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def rise(self, reference: int, value: Any, step: float) -> None:
        """Let a setpoint become a value at the end of the next step; of FMI 3.0 also values, one at the end of each period."""
        if self.new:
            self.coming[reference] = value
        else:
            self.slave.setRealInputDerivatives([reference], [1], [(value - self.get(reference)) / step])

    def step(self, time: float, step: float) -> None:
        self.asked.clear()
        self.slave.doStep(currentCommunicationPoint=time, communicationStepSize=step)


@pytest.fixture
def unit(tmp_path: Path) -> Iterator[Any]:
    """Open FMUs; free them at the end."""
    opened: list[Importer] = []

    def open_unit(content: bytes) -> Importer:
        opened.append(Importer(content, tmp_path))
        return opened[-1]

    yield open_unit
    for one in opened:
        one.slave.terminate()
        one.slave.freeInstance()


def outputs(unit: Importer, letter: str, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, force and saturation, shapes (n,), of an FMU on setpoints that rise from row to row."""
    command = unit.names[f"{letter}_cmd_{file_unit(letter.upper())}"]
    unit.start()
    unit.set(command, rows[0])
    unit.slave.exitInitializationMode()
    position, force, saturated = [unit.get(command + 1)], [], []
    for k in range(len(rows) - 1):
        unit.set(command, rows[k])
        unit.rise(command, rows[k + 1], PERIOD)
        unit.step(k * PERIOD, PERIOD)
        position.append(unit.get(command + 1))
        force.append(unit.get(command + 2))
        saturated.append(bool(unit.slave.getBoolean([command + 3])[0]))
    return np.array(position), np.array(force), np.array(saturated)


both = pytest.mark.parametrize("fmi", [2, 3])


@both
@pytest.mark.parametrize("name", SERVOS)
def test_it_moves_as_simulate_does(name: str, fmi: int, unit: Any) -> None:
    servo = Servo(name.partition(" ")[0], SERVOS[name])
    rows = motion()
    setpoints = Setpoints("X", PERIOD, 0, rows[:, None])
    (response,) = pipeline.simulate(setpoints, {"X": servo})
    position, force, saturated = outputs(unit(pipeline.fmu({"X": servo}, fmi=fmi)), "x", rows)
    assert position == pytest.approx(response.position[:, 0], abs=1e-9)
    assert force == pytest.approx(response.force[:-1, 0], abs=1e-9 * max(1.0, np.abs(response.force).max()))
    assert (saturated == response.saturated[:-1, 0]).all()
    assert np.ptp(position) > 1.0


@both
def test_rotary_axes_are_in_degrees(fmi: int, unit: Any) -> None:
    servo = Servo("first-order", {"position_gain_1_s": 60.0, "time_constant_s": 0.004})
    rows = motion()
    setpoints = Setpoints("A", PERIOD, 0, rows[:, None] / to_file("A"))
    (response,) = pipeline.simulate(setpoints, {"A": servo})
    position, _, _ = outputs(unit(pipeline.fmu({"A": servo}, fmi=fmi)), "a", rows)
    assert position == pytest.approx(response.position[:, 0] * to_file("A"), abs=1e-9)


@both
def test_a_step_of_many_periods_is_their_sequence(fmi: int, unit: Any) -> None:
    """A setpoint that rises evenly over 20 periods: one step of 20 ms is 20 steps of 1 ms."""
    servo = Servo("first-order", SERVOS["first-order"])
    rows = 2.0 + np.linspace(0.0, 1.0, 21)
    (response,) = pipeline.simulate(Setpoints("X", PERIOD, 0, rows[:, None]), {"X": servo})
    one = unit(pipeline.fmu({"X": servo}, fmi=fmi))
    one.start()
    one.set(0, rows[0])
    one.slave.exitInitializationMode()
    one.rise(0, rows[1:] if fmi == 3 else rows[-1], 20 * PERIOD)
    one.step(0.0, 20 * PERIOD)
    assert one.get(1) == pytest.approx(response.position[-1, 0], abs=1e-9)
    if fmi == 3:
        assert one.asked == pytest.approx(PERIOD * np.arange(1, 21))
        assert one.get(one.names["time"]) == pytest.approx(20 * PERIOD)


@both
def test_fmpy_finds_the_unit_of_a_machine_valid(fmi: int, tmp_path: Path) -> None:
    path = tmp_path / "table.fmu"
    assert run(["simulate", "-m", "xy-table", "--fmu", str(path), "--fmi", str(fmi), "-q"]) == 0
    assert fmpy.validation.validate_fmu(str(path)) == []
    assert fmpy.read_model_description(str(path)).fmiVersion == f"{fmi}.0"


def test_the_standard_of_a_unit_without_a_unit_is_refused() -> None:
    assert run(["simulate", "-m", "xy-table", "--fmi", "3"]) == 2
    with pytest.raises(UsageError, match="fmi = 1"):
        pipeline.fmu("xy-table", fmi=1)


def test_a_unit_of_fmi_3_has_every_function_of_the_standard(tmp_path: Path) -> None:
    """The names are those of the standard's header, which fmpy carries."""
    header = (Path(fmpy.__file__).parent / "c-code" / "fmi3FunctionTypes.h").read_text(encoding="utf-8")
    names = re.findall(r"(fmi3\w+)TYPE", header)
    folder = Path(fmpy.extract(io.BytesIO(pipeline.fmu("xy-table", fmi=3)), str(tmp_path)))
    (library,) = (folder / "binaries").glob("*/*")
    assert len(names) > 70
    assert [name for name in names if not hasattr(ctypes.CDLL(str(library)), name)] == []


def test_the_functions_of_fmi_3_are_declared_as_in_the_standard(tmp_path: Path) -> None:
    """The C text compiles beside the standard's own header, which repeats each declaration."""
    headers = Path(fmpy.__file__).parent / "c-code"
    folder = Path(fmpy.extract(io.BytesIO(pipeline.fmu("xy-table", fmi=3)), str(tmp_path)))
    source = (folder / "sources" / "cncgen_axes.c").read_text(encoding="utf-8")
    body = re.sub(r"typedef [^;{]*(\{[^}]*\})?[^;]*\bfmi3\w+(\)\([^;]*)?;\n", "", source)
    assert body != source
    text = tmp_path / "with_header.c"
    text.write_text(f'#include "fmi3Functions.h"\n{body}', encoding="utf-8")
    words = ["cc", "-std=c99", "-fsyntax-only", "-Wall", "-Werror", f"-I{headers}", str(text)]
    made = subprocess.run(words, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr


@both
def test_fmpys_own_simulation_of_two_axes(fmi: int, tmp_path: Path) -> None:
    """fmpy interpolates the setpoints itself and holds them over a step, which is all that a sampled controller sees of them."""
    servos = {
        letter: Servo("plant", SERVOS[name])
        for letter, name in (("X", "plant with friction"), ("Y", "plant with dead time"))
    }
    path = tmp_path / "axes.fmu"
    path.write_bytes(pipeline.fmu(servos, fmi=fmi))
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


@both
def test_steps_that_are_no_multiple_of_the_period_are_refused(fmi: int, unit: Any) -> None:
    one = unit(pipeline.fmu("xy-table", fmi=fmi))
    one.start()
    one.slave.exitInitializationMode()
    with pytest.raises(fmpy.fmi1.FMICallException):
        one.step(0.0, 0.0007)


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


@pytest.mark.parametrize("compiler", ['"', "", "no-such-compiler", "true", "cat", "/etc/passwd", "false"])
def test_a_compiler_that_is_none_is_named(
    compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """A quote without an end in CC was an internal error, and so was a command that ends well and writes nothing."""
    monkeypatch.setenv("CC", compiler)
    assert run(["simulate", "--axis-params", "xy-table", "--fmu", str(tmp_path / "o.fmu")]) == 2
    assert "fmu-compiler" in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []
