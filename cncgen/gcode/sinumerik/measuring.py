"""MEAS and MEAW of SINUMERIK: a motion that a probe watches (840D sl, Job planning 03/2006, 5.7, "Measurements with touch trigger probe").
Measuring cycles (840D sl, "Measuring cycles" 03/2009), which measure a part or a tool and lead back to where they began.

The places of all axes where the probe switches are kept; with MEAS the motion ends there, with MEAW it goes on to its end. Nothing switches
here: the motion is planned to its end, and it is taken as touched there, so that the program goes on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cncgen.gcode.sinumerik.cycles import Values
    from cncgen.gcode.sinumerik.motions import Motions, Words

WORDS = ("MEAS", "MEAW")
#: The variables of the places: in the program's coordinates, and in the machine's. One of each probe tells whether it switched.
PLACES = {"$AA_MW": 0, "$AA_MM": 1}
SWITCHED = "$AC_MEA"


def keep(motions: Motions, words: Words) -> None:
    """Keep where the motion of a block with MEAS or MEAW has ended."""
    given = [name for name in WORDS if words.named.pop(name, None)]
    if not given:
        return
    name, ip = given[0], motions.ip
    hint = f"{SWITCHED}[1] is 1, and $AA_MW[X] and its kin are the end of the motion"
    ip.note_once("probe-not-run", f"{name} is planned to the programmed point", name, hint)
    motions.store.touched = list(ip.state.position), list(ip.machine_position())


def pass_over(motions: Motions, name: str, values: Values) -> None:
    """Pass over a measuring cycle, as nothing can be touched."""
    list(values)
    message = f"{name} measures with a probe: passed over, and offsets, tools and results stay as they are"
    hint = "its motions take time that is not counted; origins and tools are those of --parameters and --tool-table"
    motions.ip.warn_once("probe-not-run", message, name, hint)


CYCLES = {
    f"CYCLE{number}": pass_over
    for number in (*range(961, 964), *range(971, 980), 982, *range(994, 999), 9960)
}
