"""How long LinuxCNC's own motion takes for a program, beside the estimate of ``cncgen plan --as linuxcnc``.

    python -m trials.linuxcnc_motion [PROGRAM ...]

LinuxCNC runs as it is installed: its interpreter, task and trajectory planner, with simulated axes.

The configuration has axes X Y Z that follow at once, with the velocity and acceleration of a machine of ours. Each servo
period is sampled, so that the time is counted in periods and not by a clock: a busy computer changes nothing.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

import cncgen
from cncgen.machine.record import Machine
from cncgen.planner import PlanOptions

#: Programs of ours that LinuxCNC reads: one a kind of corner, with arcs, short lines and three axes.
PROGRAMS = tuple(
    f"programs/{name}.nc" for name in ("square_sharp", "square_r5", "butterfly_g1", "helix", "bracket")
)

#: The interpreter that LinuxCNC's Python module is made for.
_PYTHON = "/usr/bin/python3"
_SAMPLES = 200_000

_INI = """\
[EMC]
VERSION = 1.1
MACHINE = timing
[DISPLAY]
DISPLAY = {folder}/run.py
[TASK]
TASK = milltask
CYCLE_TIME = 0.001
[RS274NGC]
PARAMETER_FILE = {folder}/timing.var
RS274NGC_STARTUP_CODE = G21 G17 G40 G49 G54 G80 G90 G94
[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 4.0
SERVO_PERIOD = {period_ns}
[TRAJ]
COORDINATES = X Y Z
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
DEFAULT_LINEAR_VELOCITY = {velocity}
MAX_LINEAR_VELOCITY = {velocity}
MAX_LINEAR_ACCELERATION = {acceleration}
DEFAULT_LINEAR_ACCELERATION = {acceleration}
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.005
TOOL_TABLE = {folder}/tools.tbl
[KINS]
KINEMATICS = trivkins coordinates=XYZ
JOINTS = 3
[HAL]
HALFILE = {folder}/core.hal
"""

_AXIS = """\
[AXIS_{letter}]
MIN_LIMIT = -100000
MAX_LIMIT = 100000
MAX_VELOCITY = {velocity}
MAX_ACCELERATION = {acceleration}
[JOINT_{number}]
TYPE = LINEAR
HOME = 0
HOME_OFFSET = 0
HOME_SEARCH_VEL = 0
HOME_LATCH_VEL = 0
HOME_SEQUENCE = 0
MIN_LIMIT = -100000
MAX_LIMIT = 100000
MAX_VELOCITY = {velocity}
MAX_ACCELERATION = {acceleration}
FERROR = 1000
MIN_FERROR = 1000
"""

_HAL = """\
loadrt [KINS]KINEMATICS
loadrt motmod servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=3
loadrt sampler depth={samples} cfg=fff
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd => joint.0.motor-pos-fb sampler.0.pin.0
net y joint.1.motor-pos-cmd => joint.1.motor-pos-fb sampler.0.pin.1
net z joint.2.motor-pos-cmd => joint.2.motor-pos-fb sampler.0.pin.2
addf sampler.0 servo-thread
net ok iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net prepared iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net changed iocontrol.0.tool-change => iocontrol.0.tool-changed
"""

_RUN = """\
#!{python}
import subprocess, sys, time
import linuxcnc
command, status = linuxcnc.command(), linuxcnc.stat()
def wait(done, seconds):
    end = time.time() + seconds
    while time.time() < end:
        status.poll()
        if done():
            return
        time.sleep(0.02)
    sys.exit("LinuxCNC did not come so far: state %d, interpreter %d" % (status.task_state, status.interp_state))
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete(10)
command.state(linuxcnc.STATE_ON)
command.wait_complete(10)
command.home(-1)
wait(lambda: all(status.homed[:3]), 30)
command.mode(linuxcnc.MODE_AUTO)
command.wait_complete(10)
command.program_open({program!r})
command.wait_complete(30)
samples = subprocess.Popen(["halsampler", {csv!r}])
time.sleep(0.5)
command.auto(linuxcnc.AUTO_RUN, 0)
wait(lambda: status.interp_state != linuxcnc.INTERP_IDLE, 10)
wait(lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos, {seconds})
time.sleep(0.5)
samples.terminate()
samples.wait()
"""


@dataclass(frozen=True, slots=True)
class Motion:
    """What LinuxCNC sent to its axes.

    Attributes:
        period_s: The servo period.
        position: Shape (n, 3), mm: X Y Z in each period, from the last one before the first motion to the first one after the last.
    """

    period_s: float
    position: NDArray[np.float64]

    @property
    def time_s(self) -> float:
        """From the first change of a position to the last, rests between motions included."""
        return (len(self.position) - 1) * self.period_s


def available() -> bool:
    """Tell whether LinuxCNC with its motion is installed."""
    return shutil.which("linuxcnc") is not None and Path(_PYTHON).exists()


def run(program: Path, machine: Machine, *, period_s: float = 0.001, seconds: float = 300.0) -> Motion:
    """Run a program on LinuxCNC with simulated axes and return the positions.

    Args:
        program: A file that LinuxCNC reads.
        machine: X Y Z of it give velocity and acceleration.
        period_s: The servo period.
        seconds: How long the run may take by the clock.

    Raises:
        RuntimeError: LinuxCNC did not end the program.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o777)
        _write(folder, program, machine, period_s, seconds)
        done = subprocess.run(
            ["linuxcnc", "-r", str(folder / "timing.ini")],
            capture_output=True, text=True, timeout=seconds + 60.0, cwd=folder, check=False,
            # As root it wants to be told which user to become.
            env=os.environ | {"RTAPI_UID": "65534", "RTAPI_FIFO_PATH": str(folder / "fifo"), "HOME": str(folder)},
        )  # fmt: skip
        csv = folder / "positions.txt"
        if not csv.exists():
            raise RuntimeError(
                f"LinuxCNC ended with {done.returncode}: {done.stdout[-2000:]} {done.stderr[-2000:]}"
            )
        rows = np.loadtxt(csv, ndmin=2)
    moved = np.flatnonzero(np.any(np.diff(rows, axis=0) != 0.0, axis=1))
    if not len(moved):
        raise RuntimeError(f"nothing moved: {done.stdout[-2000:]} {done.stderr[-2000:]}")
    return Motion(period_s, rows[moved[0] : moved[-1] + 2])


def _write(folder: Path, program: Path, machine: Machine, period_s: float, seconds: float) -> None:
    """Write the configuration of a run."""
    axes = [machine.axes.get(letter) or machine.axes["X"] for letter in "XYZ"]
    fastest, strongest = (
        max(axis.max_velocity for axis in axes) * 2.0,
        max(axis.max_acceleration for axis in axes) * 2.0,
    )
    ini = _INI.format(
        folder=folder, period_ns=round(1e9 * period_s), velocity=fastest, acceleration=strongest
    )
    for number, (letter, axis) in enumerate(zip("XYZ", axes, strict=True)):
        ini += _AXIS.format(
            letter=letter,
            number=number,
            velocity=axis.max_velocity,
            acceleration=axis.max_acceleration,
        )
    (folder / "timing.ini").write_text(ini)
    (folder / "core.hal").write_text(_HAL.format(samples=_SAMPLES))
    (folder / "tools.tbl").write_text("".join(f"T{k} P{k} D3 Z0\n" for k in range(1, 51)))
    (folder / "timing.var").touch()
    shutil.copy(program, folder / "program.ngc")
    run = folder / "run.py"
    run.write_text(
        _RUN.format(
            python=_PYTHON,
            program=str(folder / "program.ngc"),
            csv=str(folder / "positions.txt"),
            seconds=seconds,
        )
    )
    run.chmod(0o755)


def estimated_s(program: Path, machine: Machine, name: str = "linuxcnc") -> float:
    """Return the time that the rules of a control give, from the first motion to the end of the last."""
    stream, summary = cncgen.plan_with_summary(cncgen.read(program), machine, PlanOptions(control=name))
    for _ in stream.chunks:
        pass
    time: float = summary.as_json()["cycle_time_s"]
    return time


def main() -> None:
    """Print a row a program: LinuxCNC's time, the estimate, their ratio."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("programs", nargs="*", default=PROGRAMS, metavar="PROGRAM")
    given = parser.parse_args()
    if not available():
        parser.exit(2, "LinuxCNC is not installed: apt-get install linuxcnc-uspace\n")
    machine = cncgen.load_machine("xy-table")
    machine = replace(
        machine, axes=MappingProxyType({k: replace(machine.axes["X"], letter=k) for k in "XYZ"})
    )
    for name in given.programs:
        with tempfile.TemporaryDirectory() as folder:
            # LinuxCNC does not know the comment that says where a program starts: both start at zero.
            text = Path(name).read_text().splitlines(keepends=True)
            program = Path(folder) / "program.ngc"
            program.write_text("".join(line for line in text if not line.startswith("(START")))
            theirs, ours = run(program, machine).time_s, estimated_s(program, machine)
        print(
            f"{name:28} LinuxCNC {theirs:8.3f} s, estimate {ours:8.3f} s, ratio {ours / theirs:.4f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
