"""Geometry of paths, from arrays to arrays; it is independent of programs and machines.

    tables, nurbs, arcs     curves as flat arrays, their derivatives and their arc length
    path                    lines, arcs and NURBS one after the other as functions of one coordinate s (`Path`)
    curvature, extents      where a path bends most, and how far it reaches in each axis
    pieces, corridor        a smooth spline within a tolerance of a path, for G64
    fitting, linearize      a path as cubic NURBS or as lines, for other controls
    splitting               curves cut at parameters
    contour_distance        how far positions are from the commanded path
    columns                 reductions over short rows

The loops over knots and cells are in `cncgen.kernels` (``bspline``, ``arc_length``, ``path_derivatives``, ``smoothing``). Notation
is that of Piegl and Tiller, The NURBS Book (1997); docs/nurbs.md, docs/arc-length.md.
"""
