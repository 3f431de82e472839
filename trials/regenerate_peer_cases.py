"""Store what LinuxCNC's `rs274` prints for the cases of tests/peer: ``python -m trials.regenerate_peer_cases [NAME…]``.

Without names every program is run. A new case is written into a file of `tests/peer/cases` by hand, without its output.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from trials.peer_cases import CASES, read_file, write_file, write_programs
from trials.rs274 import installed, run


def main(names: list[str]) -> int:
    """Run the peer on the programs of these names (all of them without names) and write what it said."""
    if not installed():
        print("rs274 is not installed (apt-get install linuxcnc-uspace)", file=sys.stderr)
        return 2
    count = 0
    with tempfile.TemporaryDirectory() as folder:
        write_programs(Path(folder))
        for path in sorted(CASES.glob("*.txt")):
            found = read_file(path)
            chosen = {case.name for case in found if not names or case.name in names}
            count += len(chosen)
            if chosen:
                write_file(
                    path,
                    [
                        replace(case, expected=run(Path(folder, f"{case.name}.ngc")).text())
                        if case.name in chosen
                        else case
                        for case in found
                    ],
                )
    print(f"{count} programs")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
