"""Random features of ISO 14649, generated and cut: what the toolpaths leave wrong without a word.

A block with one feature (pocket, slot, hole, face, profile), a random tool, strategy, allowance and approach. Each part is read,
cut on a grid, and counted: refused with an error, cut without a finding, or with findings. A gouge, a rapid in stock, or
material left without a diagnostic that says so is a fault; its file is kept.

    python -m trials.stepnc_cut 200 [SEED] [FOLDER] [KIND]
"""

from __future__ import annotations

import collections
import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cncgen.diagnostics import Diagnostic
from cncgen.pipeline.removing import cut_toolpaths, raw_stock
from cncgen.stepnc.cutting import cut_program
from tests.stepnc.building import E
from tests.stepnc.featured import ORIGIN, Features

#: Width of a column, mm.
CELL = 0.5
STRATEGIES: dict[str, Callable[[random.Random], tuple[Any, ...]]] = {
    "CONTOUR_PARALLEL": lambda r: (r.uniform(0.1, 0.6), E("T"), E(r.choice(["CW", "CCW"])), E("CLIMB")),
    "CONTOUR_SPIRAL": lambda r: (r.uniform(0.1, 0.6), E("T"), E(r.choice(["CW", "CCW"])), E("CLIMB")),
    "BIDIRECTIONAL_MILLING": lambda r: (
        r.uniform(0.1, 0.6),
        E("T"),
        None,
        E(r.choice(["LEFT", "RIGHT"])),
        None,
    ),
    "UNIDIRECTIONAL_MILLING": lambda r: (r.uniform(0.1, 0.6), E("T"), None, E("CLIMB")),
}
APPROACHES = (
    None,
    ("PLUNGE_TOOLAXIS", None),
    ("PLUNGE_RAMP", None, 5.0),
    ("PLUNGE_HELIX", None, 3.0, 5.0),
    ("PLUNGE_ZIGZAG", None, 5.0, 12.0),
)


def boundary(part: Features, rng: random.Random) -> Any:
    """Return a closed profile within 60 x 50 mm."""
    kind = rng.choice(["rectangle", "circle", "polygon"])
    if kind == "rectangle":
        return part.rectangle(rng.uniform(12, 60), rng.uniform(12, 50))
    if kind == "circle":
        return part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(rng.uniform(12, 50)))
    a, b, c, d = rng.uniform(12, 30), rng.uniform(12, 25), rng.uniform(-8, 8), rng.uniform(-6, 6)
    return part.polygon((-a, -b), (a, -b), (a, d), (c, d), (c, b), (-a, b))


def slot_end(part: Features, rng: random.Random) -> Any:
    """Return the end of a slot: round mostly, else open, or flat with the radii of its corners."""
    kind = rng.choice(["OPEN", "RADIUSED", "FLAT"]) if rng.random() < 0.5 else "RADIUSED"
    corners = (part.size(rng.uniform(0, 3)), part.size(rng.uniform(0, 3))) if kind == "FLAT" else ()
    return part.add(f"{kind}_SLOT_END_TYPE", *corners)


def part_of(rng: random.Random, only: str = "") -> tuple[str, Features]:
    """Return a part with one random feature, of one kind if that is given."""
    part = Features()
    piece = part.block((0, 0, -20), (100, 80, 0))
    depth, diameter = rng.uniform(1, 12), rng.choice([3.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0])
    head = ("f", piece, (), part.placement(ORIGIN), part.plane(-depth))
    approach = rng.choice(APPROACHES)
    down = part.add(*approach) if approach else None
    name = rng.choice(list(STRATEGIES))
    plan = part.add(name, *STRATEGIES[name](rng))
    axial, radial = rng.uniform(0.5, 6), rng.choice([None, rng.uniform(0.2, 1.1) * diameter])
    side, low = rng.choice([None, 0.3]), rng.choice([None, 0.2])
    kind = only or rng.choice(["pocket", "boss pocket", "slot", "hole", "drilled", "face", "profile"])
    own: tuple[Any, ...] = (axial, radial, side, low)
    operation = "BOTTOM_AND_SIDE_ROUGH_MILLING"
    edge = rng.choice([None, None, 1.0]) if diameter >= 5 else None
    fillet = rng.choice([None, None, 1.0, rng.uniform(0.2, 3)])
    lean = rng.choice([None, None, rng.uniform(1, 30)])
    if kind in ("pocket", "boss pocket"):
        bosses = (
            (part.boss(part.add("CIRCULAR_CLOSED_PROFILE", None, part.size(8))),) if kind[0] == "b" else ()
        )
        bottom = part.add("PLANAR_POCKET_BOTTOM_CONDITION")
        round_floor = part.size(fillet) if fillet else None
        feature = part.add(
            "CLOSED_POCKET", *head, bosses, lean, bottom, round_floor, None, boundary(part, rng)
        )
    elif kind == "slot":
        width = rng.choice([diameter, diameter * rng.uniform(1.05, 3)])
        walls = (part.size(fillet) if fillet else None, lean) * 2
        profile = part.add("SQUARE_U_PROFILE", None, part.size(width), *walls)
        course = part.add("LINEAR_PATH", None, part.size(rng.choice([30.0, 50.0])), part.direction(1, 0, 0))
        ends = tuple(slot_end(part, rng) for _ in range(2))
        feature = part.add("SLOT", *head, course, profile, ends)
    elif kind in ("hole", "drilled"):
        bottom = part.add(rng.choice(["FLAT_HOLE_BOTTOM", "THROUGH_BOTTOM_CONDITION"]))
        size = diameter * rng.choice([0.9, 1.0, 1.0, 1.6, 3.0])
        feature = part.add("ROUND_HOLE", *head, part.size(size), None, bottom)
    elif kind == "face":
        course = part.add("LINEAR_PATH", None, part.size(80), part.direction(0, 1, 0))
        width = part.add("LINEAR_PROFILE", None, part.add("NUMERIC_PARAMETER", "", 100.0, "mm"))
        place = part.placement((0, 0, 0))
        feature = part.add(
            "PLANAR_FACE", "f", piece, (), place, part.plane(-min(depth, 4)), course, width, None, ()
        )
        operation, own = "PLANE_ROUGH_MILLING", (axial, low)
    else:
        feature = part.add("GENERAL_OUTSIDE_PROFILE", *head, None, boundary(part, rng))
        operation, own = rng.choice(
            [("SIDE_FINISH_MILLING", (axial, None, side)), ("BOTTOM_AND_SIDE_ROUGH_MILLING", own)]
        )
    tool = part.tool("T", diameter, edge=edge, body=rng.choice(["ENDMILL", "ENDMILL", "FACEMILL"]))
    first = (None, None, "op", 5.0, None, tool, part.technology(), None)
    overcut = rng.choice([None, 0.0, 3.0])
    if kind == "drilled":
        tool = part.tool("T", diameter, body="TWIST_DRILL", tip=31.0)
        first = (None, None, "op", 5.0, None, tool, part.technology(0.005), None)
        made = part.add("DRILLING", *first, None, None, None, None, None, None)
    else:
        made = part.add(operation, *first, overcut, down, None, plan, *own)
    return kind, part.mill(feature, made)


def judged(text: str) -> tuple[list[str], list[str], list[Diagnostic]]:
    """Return the codes of errors, warnings and findings of a part."""
    program = cut_program(text.encode(), "t.stp")
    errors = sorted({d.code for d in program.diagnostics if d.severity == "error"})
    warnings = sorted({d.code for d in program.diagnostics if d.severity == "warning"})
    if errors:
        return errors, warnings, []
    stock = raw_stock(program.raw)
    assert stock is not None
    removal = cut_toolpaths(program.toolpaths, stock, "t.stp", None, program.finished, CELL)
    return errors, warnings, list(removal.findings)


def main(arguments: list[str]) -> int:
    """Run the trial and print a table."""
    count, seed = int(arguments[0]), int(arguments[1]) if len(arguments) > 1 else random.randrange(10**9)
    folder = Path(arguments[2]) if len(arguments) > 2 else Path("stepnc_cut_faults")
    only = arguments[3] if len(arguments) > 3 else ""
    rng, totals = random.Random(seed), collections.Counter[tuple[str, str]]()
    faults: list[tuple[int, str, str, str]] = []
    for k in range(count):
        state = rng.randrange(10**12)
        kind, part = part_of(random.Random(state), only)
        text = part.text()
        try:
            errors, warnings, findings = judged(text)
        except Exception as error:
            faults.append((k, kind, f"{type(error).__name__}: {error}", text))
            continue
        told = {"stepnc-uncut", "stepnc-corner", "stepnc-tip", "stepnc-floor"} & set(warnings)
        wrong = [d for d in findings if d.severity == "error" or (d.code == "cut-left" and not told)]
        totals[
            kind, "refused" if errors else "told" if findings and not wrong else "wrong" if wrong else "right"
        ] += 1
        if wrong:
            faults.append((k, kind, f"{wrong[0].code}: {wrong[0].message}; warned of {warnings}", text))
    print(f"seed {seed}, {count} parts")
    for (kind, verdict), number in sorted(totals.items()):
        print(f"{kind:12} {verdict:8} {number}")
    for k, kind, what, text in faults[:20]:
        folder.mkdir(exist_ok=True)
        (folder / f"{seed}-{k}.stp").write_text(text)
        print(f"{k} {kind}: {what}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
