"""The hot loops, in Cython's pure-Python mode: plain arrays in, plain arrays out, nothing imported from other rooms.

A ``.pxd`` file beside a kernel declares the functions that other kernels call as C. Each module runs compiled or as plain Python;
`warn_if_uncompiled` warns once, when a command starts work, if it is the slow way.

    grammar_tables, gcode_lines, decimals                       the run of a grammar's tables, lines as instructions, numbers
    gcode_codes, gcode_parse, gcode_names, gcode_scan, gcode_signs   reading G-code
    grammar_values, language_code                               reading SINUMERIK and Heidenhain
    gcode_run, gcode_instructions, gcode_jumps                  executing lines
    gcode_rows, gcode_marks, gcode_frames                       lines that are kept, and calls in progress
    gcode_store, language_store, gcode_arithmetic, gcode_formulas    their parameters and values
    gcode_motion, gcode_words, arc_centres                      executing blocks
    part21_scan, part21_graph                                   reading STEP-NC
    bspline, arc_length, path_derivatives                       curves, and paths by their length
    smoothing, smoothing_lengths                                splines within a tolerance
    along_path, node_places                                     what a path allows at given places, nodes spread over them
    least_time and least_time_*, planned_motion                 the least-time problem (interior point), and its motion
    least_time_tube, tube_point, tube_step                      least time within a tolerance (interior point)
    tube_motion, tube_places                                    its motion, rows on the plan
    seven_phase, profile, step_limit                            profiles of the papers, exact evaluation, limited steps
    filters, servo_loop, servo_stateline, servo_contour         servo axes, and their contour error
    removal, dexel_sweeps, swept_body                           material that tools cut, upright and leaning
    free_space                                                  matching two polylines (Fréchet distance)
    decimal_rows                                                numbers to text and back
    elementary                                                  cbrt, exp, log … of the C library
"""

import functools
import importlib.machinery
import os
import sys
import warnings


class UncompiledWarning(RuntimeWarning):
    """Kernels run as plain Python."""


@functools.cache
def uncompiled() -> list[str]:
    """Return the names of the kernel modules that have no compiled form beside their source."""
    names = os.listdir(os.path.dirname(__file__))
    suffixes = tuple(importlib.machinery.EXTENSION_SUFFIXES)
    built = {name.split(".")[0] for name in names if name.endswith(suffixes)}
    return sorted({name[:-3] for name in names if name.endswith(".py")} - built - {"__init__"})


def warn_if_uncompiled() -> None:
    """Warn once (an `UncompiledWarning`) where kernels run as plain Python."""
    slow = uncompiled()
    if slow:
        warnings.warn(
            f"kernels run uncompiled, some 50 times slower ({', '.join(slow)}): "
            "reinstall where a C compiler is present",
            UncompiledWarning,
            stacklevel=2,
        )


def _provide_cython() -> None:
    """Let uncompiled kernels find a module `cython`; compiled ones need none."""
    if "cython" not in sys.modules and uncompiled():
        from cncgen.kernels.plain import install

        install()


_provide_cython()
