"""Material removal of a program: reading it, its stock and tools, and cutting."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, UsageError
from cncgen.pipeline.reading import _opened, _reading, language_of
from cncgen.toolpath.reading import ReadOptions

if TYPE_CHECKING:
    from cncgen.removal.record import Cutter, Removal, Target
    from cncgen.removal.stock import Stock
    from cncgen.stepnc.geometry.solids import Solid
    from cncgen.toolpath.record import Toolpath

#: Columns along the longer side of a stock by which `check` cuts generated toolpaths.
COARSE_COLUMNS = 250


def cut(
    source: str | os.PathLike[str],
    *,
    stock: Stock | str | None = None,
    tools: Sequence[str] = (),
    target: str | None = None,
    cell_mm: float | None = None,
    language: str | None = None,
    options: ReadOptions | None = None,
    diagnostics: Diagnostics | None = None,
) -> Removal:
    """Cut the stock of a program, upright tools from above; see docs/removal.md.

    Args:
        source: A file, or ``-`` for standard input.
        stock: The raw piece, or text as of ``--stock``; None: that of a STEP-NC file.
        tools: Tools as texts of ``--tool``; they count before those of the program.
        target: STL file of the finished part, None: what features say.
        cell_mm: Width of a column, None: a 500th of the stock.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read.
        diagnostics: Takes what is said of the program.

    Raises:
        UsageError: A file cannot be read, or the stock is not known.
        ProgramError: The program has errors.
    """
    from dataclasses import replace

    from cncgen.removal.cutters import cutter_of_option
    from cncgen.removal.stock import stock_of_option

    cutters = {c.name: c for c in map(cutter_of_option, tools)}
    piece = stock_of_option(stock) if isinstance(stock, str) else stock
    found = Diagnostics() if diagnostics is None else diagnostics
    wanted: Target | None = None if target is None else _mesh_target(target)
    reading = replace(_reading(options), tool_tips=True, kinematics=None)
    with _opened(source, language) as (reader, file, name):
        if reader.__name__ == "cncgen.stepnc":
            from cncgen.stepnc.cutting import cut_program

            program = cut_program(file, name, reading)
            found.extend(program.diagnostics)
            axes, toolpaths, finished = program.axes, program.toolpaths, program.finished
            piece = piece or raw_stock(program.raw)
        else:
            read = reader.read(file, name, reading)
            axes, finished = read.axes, None
            toolpaths = list(read.chunks())
            found.extend(read.diagnostics)
    if found.has_errors:
        raise ProgramError(found)
    if _setups(toolpaths) > 1:
        text = f"the program has {_setups(toolpaths)} setups, and one stock is cut in one clamping"
        raise UsageError(Diagnostic("cut-setups", text, hint="cut the workplan of each setup by itself"))
    if any(letter in axes for letter in "ABC"):
        text = "the program turns rotary axes; tools that lean are not cut yet, three axes alone are"
        raise UsageError(Diagnostic("cut-tilted", text))
    if piece is None:
        text = f"{name}: the stock is not known"
        hint = "--stock box:X0,Y0,Z0,X1,Y1,Z1, cylinder:X,Y,DIAMETER,Z0,Z1 or an STL file; STEP-NC: its_rawpiece with a BLOCK"
        raise UsageError(Diagnostic("cut-stock", text, hint=hint))
    return cut_toolpaths(toolpaths, piece, name, cutters, wanted or finished, cell_mm)


def cut_toolpaths(
    toolpaths: Iterable[Toolpath],
    stock: Stock,
    name: str = "program",
    cutters: dict[str, Cutter] | None = None,
    target: Target | None = None,
    cell_mm: float | None = None,
) -> Removal:
    """Cut a stock along toolpaths whose positions are those of the tools' tips."""
    from cncgen.removal.cutting import Cutting

    return Cutting(stock.field(cell_mm), name, target, cutters or {}).run(toolpaths)


def raw_stock(solids: Sequence[Solid]) -> Stock | None:
    """Return the stock of a file's raw pieces: the first, as it stands upright; None without one."""
    import numpy as np

    from cncgen.removal.stock import Stock, box

    for solid in solids:
        axes = np.eye(3)
        bounds = np.array([solid.reach(np.zeros(3), axis) for axis in axes])
        made = box(bounds[:, 0].tolist(), bounds[:, 1].tolist())
        upright = abs(abs(float(solid.frame[2, 2])) - 1.0) < 1e-9
        return Stock("cylinder", made.low, made.high) if solid.kind == "cylinder" and upright else made
    return None


def _setups(toolpaths: Sequence[Toolpath]) -> int:
    """Return how many clampings a program has."""
    numbers = {e.values["number"] for path in toolpaths for e in path.events if e.name == "setup"}
    return max(len(numbers), 1)


def _mesh_target(name: str) -> Target:
    from cncgen.removal.targets import MeshTarget

    return MeshTarget.of_file(name)


def coarse_findings(
    name: str, language: str | None, options: ReadOptions, content: bytes | None = None
) -> list[Diagnostic]:
    """Return what cutting a STEP-NC program of features finds at a coarse grid; nothing where its stock is not known.

    A program that is not made of features alone is not cut: the finished part is not known. Standard input, which is read
    once, is cut where its `content` is given.
    """
    if content is None:
        if not os.path.isfile(name):
            return []
        with open(name, "rb") as file:
            head = file.read(4096)
    else:
        head = content[:4096]
    if (language or language_of(name, head)) != "stepnc":
        return []
    data = Path(name).read_bytes() if content is None else content
    # Without the shape of a raw piece there is nothing to cut.
    if b"BLOCK" not in data.upper() and b"RIGHT_CIRCULAR_CYLINDER" not in data.upper():
        return []
    from dataclasses import replace

    from cncgen.stepnc.cutting import cut_program

    program = cut_program(data, name, replace(options, kinematics=None))
    piece = raw_stock(program.raw)
    if program.diagnostics.has_errors or piece is None or program.finished is None or len(program.axes) > 3:
        return []
    if _setups(program.toolpaths) > 1:
        return []
    cell = float((piece.high - piece.low)[:2].max()) / COARSE_COLUMNS
    return list(cut_toolpaths(program.toolpaths, piece, name, None, program.finished, cell).findings)
