"""The centre of an arc that is given by its radius; `gcode_motion` calls it as C, by ``arc_centres.pxd``."""

import cython
from cython.cimports.libc.math import asin, atan2, cos, fabs, hypot, sin

_QUARTER = cython.declare(cython.double, 1.5707963267948966)
_NAN = cython.declare(cython.double, float("nan"))
#: A radius this much (relative) above half the chord is a semicircle.
_SEMICIRCLE = cython.declare(cython.double, 1e-7)


@cython.ccall
@cython.nogil
@cython.exceptval(check=False)
def centre_from_radius(
    x0: cython.double,
    y0: cython.double,
    x1: cython.double,
    y1: cython.double,
    radius: cython.double,
    clockwise: cython.bint,
    tolerance: cython.double,
) -> cython.doublecomplex:
    """Return the centre of the arc of `radius` between two points of a plane, NaN where there is none.

    A negative radius asks for the arc of more than half a turn (RS274/NGC, 3.5.3.1). A radius shorter than half the
    chord by at most `tolerance` counts as half the chord.
    """
    mx: cython.double = (x0 + x1) / 2.0
    my: cython.double = (y0 + y1) / 2.0
    half: cython.double = hypot(mx - x1, my - y1)
    r: cython.double = fabs(radius)
    if half - r > tolerance or half == 0.0:
        return _NAN
    if r / half < 1.0 + _SEMICIRCLE:
        r = half
    # The centre lies left of the chord for a counter-clockwise arc of less than half a turn.
    normal: cython.double = atan2(y1 - y0, x1 - x0)
    normal += -_QUARTER if clockwise == (radius > 0.0) else _QUARTER
    distance: cython.double = r * cos(asin(half / r))
    return mx + distance * cos(normal) + 1j * (my + distance * sin(normal))
