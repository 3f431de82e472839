"""Whole commands with their files, as inputs of a door: stocks and tools of `cut`, servo data, modes, sweeps, units, conversions.

A case is one text: words of the command, one a line, then files, each behind `MARK` and beginning with a line of its name. Files that
a command may write begin with an o.
"""

from __future__ import annotations

import random
import tomllib
from collections.abc import Iterable
from functools import cache

from trials.generators import door_inputs, door_programs

#: Stands alone on a line between the parts of a case.
MARK = b"%%%%\n"
_TABLE = '\n[kinematics]\nmodel = "table-table"\naxes = ["a", "c"]\ncentre_mm = [20, 15, 0]\n'
_MILLED = "G21 G90 G94\nT1 M6\nS1000 M3\nG0 X-5 Y5 Z5\nG1 Z-2 F1000\nX25\nG2 X25 Y15 I0 J5\nG1 X-5 Z-4\nG0 Z5\nG81 X10 Y10 Z-8 R1 F100\nG80\nM2\n"
_LEANING = "G21 G90 G94 S1000 M3\nG0 X29 Y15 Z5\nG1 Z-3 F300\nA20 C90\nX20 A-30 C400\nC0\nG0 Z5 A0\nM2\n"
_TURNED = "G18 G21 G90 G94\nT1 M6\nS500 M3\nG0 X30 Z2\nG1 X20 F100\nZ-20\nX24 Z-25\nG0 X30\nZ2\nG1 X15\nZ-10\nG0 X30\nM2\n"
_MOVED = "G21 G17 G90 G64 P0.01\nG1 X3 Y0.4 F3000\nX0.4 Y2\nG2 X1.4 Y2 I0.5 J0\nM2\n"
_CORNERS = ("0 0 0", "10 0 0", "0 10 0", "0 0 10")
STL = "".join(
    "\n".join(["facet normal 0 0 0", "outer loop", *(f"vertex {_CORNERS[k]}" for k in face), "endloop", "endfacet", ""])
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
)  # fmt: skip
STL = f"solid a\n{STL}endsolid a\n"
SWEEP = """programs = ["p.nc"]
machine = "m.toml"
[options]
feedrate = "ild"
[vary]
"axes.*.max_jerk_mm_s3" = { log = [2e4, 1e5], count = 3 }
"axes.x.servo.position_gain_1_s" = { normal = [121, 6], count = 2 }
path_tolerance_mm = [0.01, 0.02]
[draw]
design = "sobol"
points = 4
seed = 1
[keep]
figures = ["cycle_time_s", "contour_error_max_mm"]
"""
_PLANNED = "--feedrate ild --path-tolerance 0.01"
#: Words of commands, and the files that they read beside the machine m.toml and the program p.nc.
_CASES: tuple[tuple[str, dict[str, str]], ...] = (
    ("cut p.nc --stock box:0,0,-10,30,20,0 --tool 1=flat:6 --cell 0.5 -o o.stl --report o.json", {"p.nc": _MILLED}),
    ("cut p.nc --stock box:0,0,-10,30,20,0 --tool 1=bull:6,1;length=9;shank=8;holder=20,30 --cell 1", {"p.nc": _MILLED}),
    ("cut p.nc --stock box:0,0,-10,30,20,0 --tool 1=drill:6,118 --tool 2=chamfer:6,90,1 --target t.stl", {"p.nc": _MILLED, "t.stl": STL}),
    ("cut p.nc --stock t.stl --tool 1=ball:4 --cell 0.5 -o o.stl", {"p.nc": _MILLED, "t.stl": STL}),
    ("cut p.nc -m five.toml --stock box:0,0,-20,40,30,0 --tool *=flat:6 --cell 1 -o o.stl", {"p.nc": _LEANING, "five.toml": ""}),
    ("cut p.nc -m five.toml --stock cylinder:20,15,30,-20,0 --tool *=ball:6 --cell 1 --report o.json", {"p.nc": _LEANING, "five.toml": ""}),
    ("cut p.nc --stock cylinder:0,0,50,-60,0 --tool 1=turn:0.8,30 --cell 0.5 -o o.stl", {"p.nc": _TURNED}),
    ("cut p.nc --stock cylinder:0,0,50,-60,0 --tool 1=groove:3,0.2 --cell 0.5", {"p.nc": _TURNED}),
    (f"simulate p.nc -m m.toml --axis-params m.toml {_PLANNED} --perturb 0.1 --draws 4 --draw-seed 1 -o o.csv --summary o.json", {}),
    (f"simulate p.nc -m m.toml --axis-params m.toml {_PLANNED} --controller ccc --settle 0.1 --reference p.nc -o o.csv", {}),
    ("simulate --axis-params m.toml --fmu o.fmu", {}),
    ("simulate --axis-params m.toml --fmu o.fmu --fmi 3", {}),
    (f"compensate p.nc -m m.toml {_PLANNED} --passes 2 --room 0.8 -o o.csv --summary o.json", {}),
    (f"compensate p.nc -m m.toml {_PLANNED} --shaper zvd --modes 38:0.05,71:0.03 -o o.csv", {}),
    (f"compensate p.nc -m m.toml {_PLANNED} --perturb 0.1 --draws 3 --settle 0.1 -o o.csv", {}),
    (f"compare p.nc -m m.toml {_PLANNED} --controllers p,ccc --perturb 0.1 --draws 3 -o o.txt --summary o.json", {}),
    ("compare p.nc -m m.toml --feedrates optimal,ild --interpolators arclength,taylor2 -o o.txt", {}),
    ("why p.nc -m m.toml --effort fast -o o.txt --summary o.json", {}),
    ("report p.nc -m m.toml --feedrate ild -o o.html", {}),
    ("convert p.nc --linearize 0.01 -o o.nc", {}),
    ("convert p.nc --fit 0.05 -o o.nc", {}),
    ("convert p.nc --stock box:0,0,-10,30,20,0 -o o.stp", {"p.nc": _MILLED}),
    ("plan p.nc -m m.toml --feedrate ild --interpolator stateline --stateline-bound 0.01 -o o.csv", {}),
    ("plan p.nc -m m.toml --feedrate ild --interpolator two-stage-causal --master-period 0.016 -o o.csv", {}),
    ("plan p.nc -m m.toml --feedrate adaptive --interpolator taylor2 --saturation predictive --profile bell -o o.csv", {"m.toml": "die-bonder"}),
    ("plan p.nc -m m.toml --feedrate curvature --saturation reactive --profile exponential --kbar 2 --corner-distance 0.1 -o o.csv", {"m.toml": "die-bonder"}),
    ("plan p.nc -m m.toml --feedrate ild --max-contour-error 0.001 --fit 0.05 --events o.jsonl --save-parameters o.var -o o.npz", {}),
    ("plan p.nc -m m.toml --as linuxcnc --summary o.json", {}),
    ("plan p.nc -m m.toml --as grbl --summary o.json", {}),
    ("tune -m m.toml --bandwidth 20 --damping 0.7 -o o.toml", {}),
    ("tune -m m.toml --controller h-infinity -o o.toml", {"m.toml": "flexure-stage"}),
    ("tune p.nc -m m.toml --sets 3 --jobs 1 --modulus 0.5 --seed 1 -o o.toml", {}),
    ("excite --axis X --duration 0.2 --low 10 --high 50 --share 0.5 --center 3 -m m.toml -o o.csv", {}),
    ("sweep s.toml --dry-run -o o", {"s.toml": SWEEP}),
    ("machines show m.toml", {}),
    ("identify log.csv --model velocity-loop --counts-per-mm 1000 --counts-per-rad 100 -o o.toml --summary o.json", {"log.csv": ""}),
    ("verify s.csv -p p.nc -m m.toml --resolution 1e-6 --report o.json", {"s.csv": ""}),
)  # fmt: skip


@cache
def seeds() -> list[bytes]:
    """Return the cases."""
    machine = {tomllib.loads(file.decode())["name"]: file.decode() for file in door_inputs.machines()}
    text = {
        "m.toml": machine["xy-table"],
        "p.nc": _MOVED,
        "five.toml": machine["generic-mill"] + _TABLE,
        "log.csv": door_inputs.logs()[3].decode(),
        "s.csv": door_inputs.setpoints("csv")[0].decode(),
    }
    found = []
    for words, files in _CASES:
        named = (
            {word for word in words.split() if word in text}
            | set(files)
            | ({"m.toml", "p.nc"} if "sweep" in words else set())
        )
        chosen = {
            name: machine.get(files.get(name, ""), files.get(name)) or text[name] for name in sorted(named)
        }
        parts = [f"{name}\n{content}" for name, content in chosen.items()]
        found.append(MARK.join(part.encode() for part in ("\n".join([*words.split(), ""]), *parts)))
    return found


def parts_of(data: bytes) -> tuple[list[str], dict[str, bytes]]:
    """Return words and files of a case; names lead nowhere else."""
    words, *files = data.split(MARK)
    named = (file.partition(b"\n")[::2] for file in files)
    plain = {
        name.decode("utf-8", "replace").replace("/", "").strip("\0. ") or "f": text for name, text in named
    }
    return list(filter(None, words.decode("utf-8", "replace").split("\n"))), plain


def change(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Change one part of a case: its words or a file."""
    parts = data.split(MARK)
    at = rng.randrange(len(parts))
    others = [source.split(MARK)[0] for source in sources]
    if at == 0:
        words = parts[0].split(b"\n")
        where = rng.randrange(1, max(len(words), 2))
        words[where : where + 1] = _word(rng, words[where : where + 1], others)
        parts[0] = b"\n".join(words)
    else:
        name, _, text = parts[at].partition(b"\n")
        if name.endswith(b".nc"):
            text = door_programs.changed(rng, text, [text], "linuxcnc")
        else:
            text = door_inputs.change(rng, text, [text])
        parts[at] = name + b"\n" + text
    return MARK.join(parts)


def _word(rng: random.Random, old: list[bytes], others: Iterable[bytes]) -> list[bytes]:
    """Return what stands in place of a word: other numbers, nothing, or an option of another command with its value."""
    kind = rng.random()
    if kind < 0.6 and old:
        return [door_inputs.numbers(rng, old[0])]
    if kind < 0.7:
        return []
    words = rng.choice(list(others)).split(b"\n")
    at = rng.randrange(len(words))
    return [*old, *words[at : at + 2]]
