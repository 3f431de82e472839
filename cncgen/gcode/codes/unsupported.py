"""The meaning of codes on controls that are not read here, so that a diagnostic can name it."""

from __future__ import annotations

MEANING: dict[tuple[str, int], str] = {
    **dict.fromkeys((("G", 22), ("G", 32)), "involute interpolation"),
    **dict.fromkeys((("G", 23), ("G", 33)), "exponential interpolation"),
    **dict.fromkeys((("G", 24), ("G", 34)), "circular interpolation in space"),
    ("G", 54): "high-speed cycle machining",
    # Of TinyG and g2core.
    ("G", 282): "homing of the axes",
    ("G", 284): "homing that sets no zero",
    ("G", 340): "thread cutting with a variable lead",
    **dict.fromkeys((("G", 412), ("G", 422)), "three-dimensional cutter compensation"),
    **dict.fromkeys((("G", 512),), "polygon turning"),
    **dict.fromkeys((("G", 721), ("G", 722)), "copies of a subprogram, turned or shifted"),
    ("G", 661): "a modal macro called in each block",
    **dict.fromkeys((("G", 683), ("G", 684)), "a tilted working plane"),
    **dict.fromkeys((("G", n) for n in (750, 770, 780, 790)), "a grinding cycle"),
    ("G", 811): "chopping",
    # Of Haas's controls.
    ("G", 1020): "output over RS-232",
    ("G", 1560): "broaching",
    **dict.fromkeys((("G", 1740), ("G", 1840)), "tapping along a direction other than the spindle's"),
    **dict.fromkeys((("G", n) for n in (1860, 1950, 1960)), "tapping with a driven tool"),
    ("G", 1880): "the program of a pallet, by the schedule of pallets",
    ("G", 2000): "turning the turret on the way",
    ("G", 2110): "setting a tool by hand",
    ("G", 1410): "cutter compensation in space",
    ("G", 1430): "tool length compensation of five axes",
    ("G", 2470): "boring along X with a retraction by hand",
    ("G", 2350): "tool centre point control of Haas",
    **dict.fromkeys((("M", n) for n in (820, 830, 840)), "a code of 3D printers"),
}

_TILTED = "post it with the rotary axes in place and X Y Z as the axes go, with G68.2, or with G43.4"
WITHOUT: dict[tuple[str, int], str] = {
    **dict.fromkeys((("G", n) for n in (683, 684)), _TILTED),
    ("G", 721): "G68 with its own angle before each M98 turns the copies",
    ("G", 722): "G52 with its own place before each M98 shifts the copies",
}
#: Codes of FANUC's lathes (system A) in place of those of mills, G numbers in tenths.
ON_LATHES: dict[int, str] = {
    330: "lathes cut threads with G32",
    680: "on lathes it is the mirror image of a second turret, which is not read",
    770: "G77 mills flats on Haas's lathes, which is not read; post it as the moves that it makes",
    **dict.fromkeys((430, 440), "T has the offset on lathes: T0101"),
    910: "U and W are distances on lathes",
    930: "G98 and G99 say what F means on lathes",
    950: "G98 and G99 say what F means on lathes; those of Okuma, which are not read, have G95 beside G50 S",
    **dict.fromkeys((870, 880, 890), "G83 to G85 drill along Z; cycles of driven tools along X are not read"),
}
