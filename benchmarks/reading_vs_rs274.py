"""Reading speed: `cncgen check` and LinuxCNC's `rs274 -g` on the same programs of several shapes, in one run.

    python benchmarks/reading_vs_rs274.py [SHAPE …] [--repeat N] [--keep FOLDER]

Whole processes take turns; the least processor time of each counts. Prints it, peak memory and the ratio for each shape, and first of
a program of one line, which is the start. Needs `rs274` (``apt-get install linuxcnc-uspace``) for the comparison. Languages that it does
not read are measured beside `cncgen check` on the same motions as plain G-code (`BESIDE`). The package is copied into an environment of its
own, as a user has it: where a checkout is installed, Python starts with what finds its folders, for 12 ms.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import shutil
import subprocess
import sysconfig
import tempfile
import venv
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cncgen
from cncgen import grammars


@dataclass(frozen=True)
class Measured:
    """One whole process: processor time, s, and peak resident memory, MiB."""

    cpu_s: float
    peak_mib: float


def start() -> Iterator[str]:
    """Yield one motion."""
    yield from ("G21 G90 F1000", "G1 X1", "M2")


def plain() -> Iterator[str]:
    """Yield a spiral of 1,000,000 short segments, three axes in each line."""
    yield "G21 G90 G64 P0.01 F6000"
    for k in range(1_000_000):
        angle, radius = 0.004 * k, 20.0 + 1e-5 * k
        yield f"G1 X{radius * math.cos(angle):.4f} Y{radius * math.sin(angle):.4f} Z{1e-5 * k:.4f}"
    # Without an end, rs274 asks for more for ever.
    yield "M2"


def sinumerik() -> Iterator[str]:
    """Yield the same spiral as posts for SINUMERIK write it, numbered."""
    yield "G17 G90 G64 F6000"
    for k in range(1_000_000):
        angle, radius = 0.004 * k, 20.0 + 1e-5 * k
        x, y = radius * math.cos(angle), radius * math.sin(angle)
        yield f"N{10 + k} G1 X{x:.4f} Y={y:.4f} Z{1e-5 * k:.4f}"
    yield "M30"


def heidenhain() -> Iterator[str]:
    """Yield the same spiral in Heidenhain's plain language."""
    yield from ("0 BEGIN PGM SPIRAL MM", "1 TOOL CALL 1 Z S5000 F6000", "2 L X+20 Y+0 Z+0 R0 F AUTO M3")
    for k in range(1_000_000):
        angle, radius = 0.004 * k, 20.0 + 1e-5 * k
        yield f"{3 + k} L X{radius * math.cos(angle):+.4f} Y{radius * math.sin(angle):+.4f} Z{1e-5 * k:+.4f}"
    yield from ("1000003 M30", "1000004 END PGM SPIRAL MM")


def pockets() -> Iterator[str]:
    """Yield 100,000 lines of pockets: straight cuts, arcs in and out of them, a feed each, a comment on every tenth block."""
    yield from ("%", "G21 G90 G17 G94", "T1 M6", "S12000 M3", "M8", "G0 X0 Y0 Z5", "F1500")
    x = y = 0.0
    for k in range(100_000):
        note = f" (row {k // 10})" if k % 10 == 0 else ""
        kind = k % 5
        if kind == 0:
            x, y = 20.0 + 10.0 * math.cos(0.01 * k), 20.0 + 10.0 * math.sin(0.01 * k)
            yield f"G1 X{x:.4f} Y{y:.4f} F{800 + k % 700}{note}"
        elif kind in (1, 3):
            x, y = x + 1.2, y + 0.8
            yield f"G{2 if kind == 1 else 3} X{x:.4f} Y{y:.4f} R1.5{note}"
        elif kind == 2:
            x -= 2.0
            yield f"G3 X{x:.4f} Y{y:.4f} I-1.0000 J0.0000{note}"
        else:
            yield f"G1 Z{-0.001 * (k % 1000):.4f}{note}"
    yield from ("G0 Z50", "M30", "%")


def shop() -> Iterator[str]:
    """Yield 100,000 numbered lines, nine of forty of which are no plain motion: coolant, spindle, dwell, distance, drilling."""
    yield from ("%", "G21 G90 G17 G94", "T1 M6", "S8000 M3", "G54", "F900")
    for k in range(100_000):
        x, y = 30.0 * math.cos(0.01 * k), 30.0 * math.sin(0.01 * k)
        rare = {
            0: f"M8 (pass {k})",
            1: f"S{6000 + k % 500} M3",
            2: "G0 Z5.",
            3: f"G0 X{k % 90}.5 Y{k % 70}.25",
            4: f"G1 Z-{(k % 7) / 2} F300.",
            5: "G4 P0.1",
            6: "G91 G1 X1. F800",
            7: "G90",
            20: "M9",
            21: "G17 G40 G80",
            22: f"G81 X{k % 90}. Y5. Z-3. R2. F200",
            23: f"X{k % 91}.5",
            24: "G80",
        }
        usual = (
            f"G1 X{x:.3f} Y{y:.3f} F{900 + k % 50}",
            f"G2 X{x + 2.0:.3f} Y{y:.3f} R90.",
            f"G1 X{x:.3f} Z{-(k % 100) / 50:.3f}",
        )
        yield f"N{10 + 5 * k} {rare.get(k % 40, usual[k % 3])}"
    yield from ("M30", "%")


def loops() -> Iterator[str]:
    """Yield a program whose nested loops execute about 1,000,000 blocks with expressions, and call a subroutine."""
    yield """G21 G90 G94 F1000
o<point> sub
#<r> = [#1 * 0.5 + #2]
o<point> endsub [#<r> * 2]
#1 = 0
o100 while [#1 LT 1420]
#2 = 0
#3 = [10 + 5 * SIN[#1 / 10]]
o101 while [#2 LT 100]
#4 = [#3 + 0.01 * #2]
o102 if [#2 MOD 2 EQ 0]
G1 X[#4 * COS[#2 * 3.6]] Y[#4 * SIN[#2 * 3.6]] Z[-#2 / 100]
o102 else
X[#4 + 1] Y[ABS[#4 - 5]] F[500 + #2]
o102 endif
#2 = [#2 + 1]
o101 endwhile
o<point> call [#1] [#2]
#1 = [#1 + 1]
o100 endwhile
M2"""


def expressions() -> Iterator[str]:
    """Yield 100,000 lines of two expressions, no two alike."""
    dice = random.Random(7)
    yield "G21 G90 F1000"
    for k in range(100_000):
        a, b, c = dice.randint(1, 99), dice.uniform(1, 9), dice.randint(1, 360)
        yield f"G1 X[{a} + {b:.3f} * SIN[{c}]] Y[{k % 977} / {b:.2f} - {a}]"
    yield "M2"


def posts() -> Iterator[str]:
    """Yield 100,000 lines as a post-processor of a CAM system writes them: tools, operations of five kinds, arcs, canned cycles."""
    dice = random.Random(3)
    yield from ("%", "(PART 1)", "G21 G90 G17 G40 G80 G94")
    lines = 0
    for operation in range(1_000_000):
        tool = 1 + operation % 12
        yield from (
            f"(OPERATION {operation}: D{tool})",
            f"T{tool} M6",
            f"S{2000 + 100 * tool} M3",
            "G54",
            "M8",
        )
        x, y, z = dice.uniform(0, 90), dice.uniform(0, 90), -dice.uniform(0, 5)
        yield from (f"G0 X{x:.3f} Y{y:.3f}", "Z5.", f"G1 Z{z:.3f} F{dice.randint(80, 300)}")
        for k in range(180):
            step = dice.uniform(0.1, 3)
            if k % 6 == 2:
                yield f"G{2 + k % 2} X{x + step:.3f} Y{y + step:.3f} I{step:.3f} J0."
            elif k % 6 == 5:
                yield f"X{x + step:.3f} Z{z:.3f}"
            else:
                yield f"G1 X{x + step:.3f} Y{y + step:.3f}" + (
                    f" F{dice.randint(500, 1500)}" if k % 9 == 0 else ""
                )
            x, y = x + step, y + (step if k % 6 != 5 else 0.0)
        yield from ("G0 Z5.", "G81 X10. Y10. Z-3. R2. F200", "X20.", "X30. Y20.", "G80", "M9", "M5")
        lines += 195
        if lines >= 100_000:
            break
    yield from ("G0 Z50", "M30", "%")


def calls() -> Iterator[str]:
    """Yield 50,000 lines of CALL."""
    yield from ("o<p> sub", "G1 X#1 Y[#2 + 1]", "o<p> endsub", "F1000")
    yield from (f"o<p> call [{k % 100}] [{k % 37}.5]" for k in range(50_000))
    yield "M2"


def labels() -> Iterator[str]:
    """Yield 20,000 branches, each with a label of its own."""
    yield "F1000"
    for k in range(1, 20_001):
        yield from (f"o{k} if [{k % 3} eq 0]", f"G1 X{k % 100}", f"o{k} else", f"G1 Y{k % 50}", f"o{k} endif")
    yield "M2"


SHAPES: dict[str, Callable[[], Iterator[str]]] = {
    shape.__name__: shape
    for shape in (
        start,
        plain,
        sinumerik,
        heidenhain,
        pockets,
        shop,
        posts,
        loops,
        expressions,
        calls,
        labels,
    )
}
#: Shapes in languages that rs274 does not read, and the one in G-code whose motions they make.
BESIDE = {"sinumerik": "plain", "heidenhain": "plain"}


def installed(folder: Path) -> str:
    """Copy the package into a new environment in a folder; return its Python."""
    venv.create(folder, symlinks=True)
    python = str(folder / "bin" / "python")
    place = Path(sysconfig.get_path("purelib", "venv", {"base": str(folder)})) / "cncgen"
    shutil.copytree(Path(cncgen.__file__).parent, place)
    shutil.copytree(Path(grammars.__file__).parent, place / "grammars", dirs_exist_ok=True)
    # What it needs stays where it is; a file of paths in there is not followed.
    (place.parent / "needed.pth").write_text(f"{sysconfig.get_path('purelib')}\n")
    subprocess.run([python, "-m", "compileall", "-q", place], check=True)
    return python


def measure(command: list[str]) -> Measured:
    """Run a command with its output thrown away."""
    # Compiled modules are kept between runs, as where the program is installed.
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=kept)
    assert process.stderr is not None
    said = process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{' '.join(command)} failed:\n{said.decode()[-2000:]}")
    return Measured(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def compare(name: str, folder: Path, python: str, repeat: int) -> str:
    """Write a shape's program, run both by turns, return a line of the table."""

    def written(shape: str) -> Path:
        path = folder / f"{shape}.ngc"
        with path.open("w") as file:
            file.writelines(f"{line}\n" for line in SHAPES[shape]())
        return path

    path, check = written(name), [python, "-P", "-m", "cncgen", "check"]
    commands = [[*check, str(path)]]
    if name in BESIDE:
        commands = [[*check, "--dialect", name, str(path)], [*check, str(written(BESIDE[name]))]]
    elif shutil.which("rs274"):
        commands.append(["rs274", "-g", "-n", "0", "-v", str(folder / "rs274.var"), str(path)])
    best: list[Measured] = []
    for _ in range(repeat):
        runs = [measure(command) for command in commands]
        best = [min(pair, key=lambda run: run.cpu_s) for pair in zip(best or runs, runs, strict=True)]
    row = " ".join(f"{run.cpu_s:8.3f} s {run.peak_mib:5.0f} MiB" for run in best)
    return f"{name:12}{row}" + (f"  {best[1].cpu_s / best[0].cpu_s:6.2f} x" if len(best) == 2 else "")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("shapes", nargs="*", choices=[*SHAPES, []], metavar="SHAPE", help=", ".join(SHAPES))
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--keep", type=Path, help="write the programs here and keep them")
    asked = parser.parse_args()
    print(f"{'':12}{'cncgen check':>20} {'rs274 -g, or G-code':>20}   ratio")
    with tempfile.TemporaryDirectory() as scratch:
        python = installed(Path(scratch) / "installed")
        for shape in asked.shapes or SHAPES:
            print(compare(shape, asked.keep or Path(scratch), python, asked.repeat), flush=True)
