"""Store what LinuxCNC's `rs274` prints for the programs: ``python -m trials.regenerate_peer_cases [NAME…]``.

Without names every program is run. Output that no program asks for any more is removed.
"""

from __future__ import annotations

import sys

from trials.rs274 import EXPECTED, installed, programs, run


def main(names: list[str]) -> int:
    """Run the peer on the programs of these names (all of them without names) and write what it said."""
    if not installed():
        print("rs274 is not installed (apt-get install linuxcnc-uspace)", file=sys.stderr)
        return 2
    EXPECTED.mkdir(exist_ok=True)
    chosen = [p for p in programs() if not names or p.stem in names]
    for program in chosen:
        (EXPECTED / f"{program.stem}.canon").write_text(run(program).text())
    if not names:
        kept = {p.stem for p in chosen}
        for stale in (p for p in EXPECTED.glob("*.canon") if p.stem not in kept):
            stale.unlink()
    print(f"{len(chosen)} programs")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
