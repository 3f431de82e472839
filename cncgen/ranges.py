"""The ranges of input numbers that planning supports: stated once, checked at every entry.

A double has 53 bits. A place of 1e8 mm is known to 1.5e-8 mm, and jerk is its third difference: beyond that, rounding alone
breaks the limits of a fine machine at its period. A rational curve with weights of a ratio r has speeds of a ratio up to r² along
its parameter, of which 1e6 leaves four digits.
"""

from __future__ import annotations

#: Largest coordinate of a place, mm or rad: a hundred kilometres.
POSITION = 1e8
#: Largest ratio of two weights of one rational curve.
WEIGHT_RATIO = 1e6
#: Smallest part that the distance of two different knots has of the range of all knots of a curve.
KNOT_PART = 1e-9
#: Factors of a frame that scales: programmed places are within `POSITION` too, and both ways need digits.
FACTORS = 1e-6, 1e6
#: Periods of setpoints, s, and times of theirs, which are a whole number of periods that a double holds.
PERIOD_S = 1e-7, 1e3
TIME_S = 1e8
#: Largest tolerance of a path, mm.
TOLERANCE_MM = 1e6
#: Coarsest rounding of positions, mm or degrees: with a coarser one no place on a path is told from another.
RESOLUTION = 1.0
#: Feeds, mm/s, rad/s or 1/s.
FEEDS = 1e-9, 1e9
#: Numbers of options, apart from 0 and their signs: products of a few of them stay within the range of a double.
OPTION = 1e-12, 1e12
#: Cells of a grid of material, mm.
CELL_MM = 1e-6, 1e6
