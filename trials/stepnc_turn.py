"""Random turned features of ISO 14649-12, generated and cut: what the toolpaths leave wrong without a word.

A bar is faced, roughed and finished along a random profile of cylinders, cones, shoulders and falls, and gets a groove or none. Each
part is refused with an error, cut without a finding, or wrong; the files of those that are wrong are kept.

    python -m trials.stepnc_turn 200 [SEED] [FOLDER]
"""

from __future__ import annotations

import collections
import random
import sys
from pathlib import Path

from cncgen.pipeline.removing import raw_stock, turn_toolpaths
from cncgen.stepnc.cutting import cut_program
from tests.stepnc.turning_parts import Turned

#: Length of a ring, mm.
CELL = 0.02


def profile(rng: random.Random) -> list[tuple[float, float]]:
    """Return a profile from Z 0 down as (radius, z), mm; it rises mostly."""
    points = [(rng.choice([0.0, rng.uniform(1, 10)]), 0.0)]
    for _ in range(rng.randint(1, 7)):
        radius, z = points[-1]
        rise = rng.choice([0.0, rng.uniform(0.2, 6), rng.uniform(0.05, 1), -rng.uniform(0.1, 1.5)])
        shoulder = rise > 0 and rng.random() < 0.3
        points.append((max(radius + rise, 0.5), z - (0.0 if shoulder else rng.uniform(0.2, 12))))
    radius, z = points[-1]
    return [*points, (radius, z - 2.0)]


def part_of(rng: random.Random) -> Turned:
    """Return a bar with random features."""
    points = profile(rng)
    part = Turned(2 * max(p[0] for p in points) + rng.uniform(0.5, 20), 150, rng.uniform(0, 4))
    tool = part.turning_tool(rng.choice([0.0, 0.2, 0.4, 0.8, 1.2]), trailing=rng.choice([20.0, 35.0, 50.0]))
    depths = tuple(rng.uniform(0.5, 4) for _ in range(rng.randint(1, 2)))
    ways = part.ways(depths=depths, lift=rng.choice([0.3, 1.0]))
    feature = part.revolution(*points)
    part.turn("FACING_ROUGH", part.face(part.bar[0] / 2), tool, ways, 0.0)
    part.turn("CONTOURING_ROUGH", feature, tool, ways, rng.choice([0.0, 0.3]))
    part.turn("CONTOURING_FINISH", feature, tool)
    if rng.random() < 0.5:
        width, corner = rng.uniform(2, 6), rng.choice([0.0, 0.5])
        groove = part.groove(rng.uniform(1, 5), width, rng.uniform(-60, -3), corner or None)
        wide = rng.uniform(1, width)
        blade = part.grooving_tool(wide, nose=min(corner, wide / 3))
        part.turn("GROOVING_ROUGH", groove, blade, None, rng.choice([0.0, 0.1]))
        part.turn("GROOVING_FINISH", groove, blade)
    return part


def judged(text: str) -> tuple[str, str]:
    """Return ``refused``, ``right`` or ``wrong`` of a part, and what is said of it."""
    program = cut_program(text.encode(), "t.stp")
    errors = [d for d in program.diagnostics if d.severity == "error"]
    if errors:
        return "refused", errors[0].code
    stock = raw_stock(program.raw)
    assert stock is not None
    found = turn_toolpaths(program.toolpaths, stock, "t.stp", None, program.turned, CELL).findings
    return ("wrong", found[0].message) if found else ("right", "")


def main(arguments: list[str]) -> int:
    """Run the trial and print a table."""
    count, seed = int(arguments[0]), int(arguments[1]) if len(arguments) > 1 else random.randrange(10**9)
    folder = Path(arguments[2]) if len(arguments) > 2 else Path("stepnc_turn_faults")
    rng, totals = random.Random(seed), collections.Counter[str]()
    faults = 0
    for k in range(count):
        text = part_of(random.Random(rng.randrange(10**12))).whole()
        try:
            verdict, said = judged(text)
        except Exception as error:
            verdict, said = "wrong", f"{type(error).__name__}: {error}"
        totals[f"{verdict} {said}" if verdict == "refused" else verdict] += 1
        if verdict == "wrong":
            faults += 1
            folder.mkdir(exist_ok=True)
            (folder / f"{seed}-{k}.stp").write_text(text)
            print(f"{k}: {said}")
    print(f"seed {seed}, {count} parts")
    for verdict, number in sorted(totals.items()):
        print(f"{number:6} {verdict}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
