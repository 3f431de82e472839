"""Material removal of a program: reading it, its stock and tools, and cutting."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence

from cncgen.arguments import declared
from cncgen.diagnostics import Diagnostic, Diagnostics, ProgramError, Severity, UsageError
from cncgen.pipeline.reading import _opened, _reading
from cncgen.toolpath.reading import ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from cncgen.machine.kinematics import Kinematics
    from cncgen.removal.record import Clamping, Cutter, Insert, Removal, Target, TurnedTarget
    from cncgen.removal.stock import Stock
    from cncgen.removal.sweeps import Poses
    from cncgen.stepnc.cutting import CutProgram
    from cncgen.stepnc.geometry.solids import Solid
    from cncgen.toolpath.record import Toolpath

#: Columns along the longer side of a stock by which `check` cuts generated toolpaths.
COARSE_COLUMNS = 250


@declared
def cut(
    source: str | os.PathLike[str],
    *,
    stock: Stock | str | None = None,
    tools: Sequence[str] = (),
    target: str | None = None,
    cell_mm: float | None = None,
    language: str | None = None,
    options: ReadOptions | None = None,
    on_lathe: bool = False,
    diagnostics: Diagnostics | None = None,
) -> Removal:
    """Cut the stock of a program; see docs/removal.md.

    Args:
        source: A file, or ``-`` for standard input.
        stock: The raw piece, or text as of ``--stock``; None: that of a STEP-NC file.
        tools: Tools as texts of ``--tool``; they count before those of the program.
        target: STL file of the finished part; None takes the features.
        cell_mm: Width of a column, None: some 500th of the stock.
        language: ``gcode`` or ``stepnc``; None: by content and suffix.
        options: How it is read.
        on_lathe: Whether the machine is a lathe (`Machine.is_lathe`); one whose dialect or tools are a lathe's is turned anyhow.
        diagnostics: Receives the diagnostics of the program.

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
    reading = replace(_reading(options), tool_tips=True)
    with _opened(source, language) as (reader, file, name):
        if reader.__name__ == "cncgen.stepnc":
            from cncgen.stepnc.cutting import cut_program

            # Positions stay those of the tip in the workpiece, and axes those of a fork head.
            tips = True
            program = cut_program(file, name, replace(reading, kinematics=None))
            found.extend(program.diagnostics)
            toolpaths = program.toolpaths
            finished, turned, part = program.finished, program.turned, program.part
            clampings, unlike = clampings_of(program), program.unlike
            pieces = 1 if piece is not None else len(program.raw)
            axes, for_lathe = "", False
            piece = piece or raw_stock(program.raw)
        else:
            read = reader.read(file, name, reading)
            finished, turned, part, clampings = None, None, None, {}
            unlike, pieces = "", 1
            axes, for_lathe = read.moving_axes, read.for_lathe or on_lathe
            toolpaths, tips = list(read.chunks()), False
            found.extend(read.diagnostics)
    if found.has_errors:
        raise ProgramError(found)
    _check(toolpaths, clampings, unlike)
    if piece is None:
        raise _no_stock(name, part, toolpaths)
    if turns(toolpaths, cutters, axes, for_lathe):
        _check_bar(toolpaths, wanted, pieces)
        return turn_toolpaths(toolpaths, piece, name, cutters, turned, cell_mm)
    stays = wanted if clampings else wanted or finished
    if not turned_axes(toolpaths):
        return cut_toolpaths(toolpaths, piece, name, cutters, stays, cell_mm, clampings)
    poses = _poses(None if tips else reading.kinematics, tips, toolpaths)
    return lean_toolpaths(toolpaths, piece, name, poses, cutters, stays, cell_mm, clampings)


def _check(toolpaths: Sequence[Toolpath], clampings: Mapping[int, Clamping], unlike: str) -> None:
    """Raise `UsageError` for a program in several setups whose raw pieces cannot be placed anew from one to the next."""
    if _setups(toolpaths) > 1 and not clampings:
        why = unlike or "the file does not say how its raw piece stands in each"
        text = f"the program has {_setups(toolpaths)} setups, and {why}"
        hint = "STEP-NC: its_rawpiece with its_bounding_geometry, and its_workpiece_setup in every setup"
        if unlike.startswith("they"):
            hint = "write the setups of each raw piece to a file of their own"
        raise UsageError(Diagnostic("cut-setups", text, hint=hint))


def _check_bar(toolpaths: Sequence[Toolpath], wanted: Target | None, pieces: int) -> None:
    """Raise `UsageError` for a program that turns its work, and asks for more than one bar that tools cut which stand."""
    if wanted is not None:
        text = "--target is for programs that mill; of one that turns the features say what is to stay"
        raise UsageError(Diagnostic("cut-stock", text))
    if pieces > 1:
        text = (
            f"the program turns its work, and has {pieces} raw pieces in a setup; one bar is turned at a time"
        )
        raise UsageError(Diagnostic("cut-stock", text, hint="write the work of each to a file of its own"))
    if (setups := _setups(toolpaths)) > 1:
        text = f"the program turns its work in {setups} setups; a bar is cut in one"
        raise UsageError(Diagnostic("cut-setups", text, hint="write each setup to a file of its own"))
    if moved := turned_axes(toolpaths):
        text = f"the program turns its work, and moves {moved}; a bar is cut by tools that stand"
        raise UsageError(Diagnostic("cut-tilted", text, hint="write what is milled to a file of its own"))


def turned_axes(toolpaths: Iterable[Toolpath]) -> str:
    """Return the letters of the rotary axes that are not at 0 throughout."""
    import numpy as np

    found = ""
    for path in toolpaths:
        for k, letter in enumerate(path.axes):
            moves = letter in "ABC" and (path.start[k] != 0.0 or bool(np.any(path.end[:, k] != 0.0)))
            found += letter if moves and letter not in found else ""
    return found


def _poses(mechanism: Kinematics | None, tips: bool, toolpaths: Sequence[Toolpath]) -> Poses:
    """Return where tools are: of STEP-NC by the tip, of G-code by the machine.

    Raises:
        UsageError: The machine does not say how its rotary axes carry table or head.
    """
    from cncgen.removal.poses import MachinePoses, TipPoses

    if tips:
        return TipPoses()
    letters = turned_axes(toolpaths)
    carried = "" if mechanism is None else "".join("ABC"[column - 3] for column in mechanism.axes)
    if mechanism is None or set(letters) - set(carried):
        text = f"the program moves {letters}, and how these axes carry table or head is not known"
        if mechanism is not None:
            text = f"the program moves {letters}; [kinematics] of the machine has {carried}"
        hint = "--machine FILE.toml with a table [kinematics]: model, axes and centre_mm or pivot_mm"
        raise UsageError(Diagnostic("cut-tilted", text, hint=hint))
    return MachinePoses(mechanism)


def _no_stock(name: str, part: Solid | None, toolpaths: Sequence[Toolpath]) -> UsageError:
    """Return the error of a program whose stock is not known; a hint has the box of the finished part, else of the cutting motions."""
    import numpy as np

    from cncgen.toolpath.record import FeedMode, Kind

    hint = "--stock box:X0,Y0,Z0,X1,Y1,Z1, cylinder:X,Y,DIAMETER,Z0,Z1 or an STL file; STEP-NC: its_rawpiece with a BLOCK"
    if part is not None:
        box = _box_text(np.array([part.reach(np.zeros(3), axis) for axis in np.eye(3)]).T)
        hint = f"the finished part fills {box} of its own frame; --stock with what is round it"
    else:
        feeds = [(path.kind != Kind.EVENT) & (path.feed_mode != FeedMode.RAPID) for path in toolpaths]
        ends = [path.end[rows, :3] for path, rows in zip(toolpaths, feeds, strict=True)]
        if sum(map(len, ends)):
            places = np.concatenate(ends)
            box = _box_text(np.array([places.min(axis=0), places.max(axis=0)]))
            hint = f"motions at the feed end within {box}; {hint}"
    return UsageError(Diagnostic("cut-stock", f"{name}: the stock is not known", hint=hint))


def _box_text(bounds: NDArray[np.float64]) -> str:
    """Return bounds, shape (2, 3), as an option has them."""
    return "box:" + ",".join(f"{value:g}" for value in bounds.ravel().tolist())


def clampings_of(program: CutProgram) -> dict[int, Clamping]:
    """Return the setups of a program that has several, if its raw piece stands in all of them."""
    from cncgen.removal.record import Clamping

    each = program.clampings if len(program.clampings) > 1 else {}
    return {number: Clamping(frame, target) for number, (frame, target) in each.items()}


def turns(
    toolpaths: Iterable[Toolpath],
    cutters: Mapping[str, Cutter | Insert] | None = None,
    axes: str = "",
    for_lathe: bool = False,
) -> bool:
    """Tell whether a program turns its work: as `turns_work` says, or by a tool that is given."""
    from cncgen.removal.cutters import turns_work
    from cncgen.removal.record import Insert

    events = [event for path in toolpaths for event in path.events]
    named = {str(e.values.get("tool", "")) for e in events if e.name == "tool"} | {"*"}
    given = any(isinstance(c, Insert) and c.name in named for c in (cutters or {}).values())
    return given or turns_work([event.values for event in events], axes, for_lathe)


def turn_toolpaths(
    toolpaths: Iterable[Toolpath],
    stock: Stock,
    name: str = "program",
    cutters: Mapping[str, Cutter | Insert] | None = None,
    target: TurnedTarget | None = None,
    cell_mm: float | None = None,
) -> Removal:
    """Turn a stock about X 0 Y 0 along toolpaths whose positions are those of the tools' corners."""
    from cncgen.removal.bars import TurnedCutting, bar_of

    return TurnedCutting(bar_of(stock, cell_mm), name, target, cutters).run(toolpaths)


def cut_toolpaths(
    toolpaths: Iterable[Toolpath],
    stock: Stock,
    name: str = "program",
    cutters: Mapping[str, Cutter | Insert] | None = None,
    target: Target | None = None,
    cell_mm: float | None = None,
    clampings: Mapping[int, Clamping] | None = None,
) -> Removal:
    """Cut a stock along toolpaths of upright tools whose positions are those of the tools' tips."""
    from cncgen.removal.cutting import Cutting
    from cncgen.removal.poses import TipPoses

    if clampings:
        return lean_toolpaths(toolpaths, stock, name, TipPoses(), cutters, target, cell_mm, clampings)
    return Cutting(stock.field(cell_mm), name, target, cutters).run(toolpaths)


def lean_toolpaths(
    toolpaths: Iterable[Toolpath],
    stock: Stock,
    name: str,
    poses: Poses,
    cutters: Mapping[str, Cutter | Insert] | None = None,
    target: Target | None = None,
    cell_mm: float | None = None,
    clampings: Mapping[int, Clamping] | None = None,
) -> Removal:
    """Cut a stock along toolpaths of tools that lean, or that stand otherwise in several setups."""
    from cncgen.removal.dexels import dexels_of
    from cncgen.removal.leaning import LeaningCutting

    return LeaningCutting(dexels_of(stock, cell_mm), name, poses, target, cutters, clampings).run(toolpaths)


def raw_stock(solids: Sequence[Solid]) -> Stock | None:
    """Return the stock of the raw pieces in a setup, as they stand; None without one.

    Raises:
        UsageError: One stands in another, or beyond the range of places.
    """
    from cncgen.removal.stock import together

    stocks = [_stock_of(solid) for solid in solids]
    return together(stocks) if stocks else None


def _stock_of(solid: Solid) -> Stock:
    """Return a raw piece as a stock: a mesh where no axis of the machine is one of its own."""
    import numpy as np

    from cncgen.removal.stock import Stock, box, prism

    bounds = np.array([solid.reach(np.zeros(3), axis) for axis in np.eye(3)])
    made = box(bounds[:, 0].tolist(), bounds[:, 1].tolist())
    turned = solid.frame[:3, :3]
    if solid.kind == "cylinder":
        upright = abs(abs(float(turned[2, 2])) - 1.0) < 1e-9
        return Stock("cylinder", made.low, made.high) if upright else prism(solid.frame, solid.size, True)
    straight = np.allclose(np.abs(turned).max(axis=0), 1.0, atol=1e-9)
    return made if straight else prism(solid.frame, solid.size, False)


def _setups(toolpaths: Sequence[Toolpath]) -> int:
    """Return how many clampings a program has."""
    numbers = {e.values["number"] for path in toolpaths for e in path.events if e.name == "setup"}
    return max(len(numbers), 1)


def _mesh_target(name: str) -> Target:
    from cncgen.removal.targets import MeshTarget

    return MeshTarget.of_file(name)


def coarse_findings(name: str, options: ReadOptions, content: bytes | None = None) -> list[Diagnostic]:
    """Return the findings of cutting a STEP-NC program of features at a coarse grid; nothing if its stock is unknown.

    A program that is not made of features alone is not cut: the finished part is not known. Standard input, which is read
    once, is cut where its `content` is given. Steep ways down are left out: making the toolpaths has told them.
    """
    if content is None and not os.path.isfile(name):
        return []
    from dataclasses import replace
    from pathlib import Path

    data = Path(name).read_bytes() if content is None else content
    # Without the shape of a raw piece there is nothing to cut.
    if b"BLOCK" not in data.upper() and b"RIGHT_CIRCULAR_CYLINDER" not in data.upper():
        return []
    found = _coarsely_cut(data, name, options)
    untold = {"cut-plunge"}
    if any(d.code == "cut-narrow" for d in found):
        # A tool may be too narrow for the coarse grid alone; then what is left is not its fault.
        untold |= {"cut-narrow", "cut-left"}
    # A tool without a size is no mistake of the program.
    return [
        replace(d, severity=Severity.WARNING) if d.code == "cut-tool" else d
        for d in found
        if d.code not in untold
    ]


def _coarsely_cut(data: bytes, name: str, options: ReadOptions) -> Sequence[Diagnostic]:
    """Return the findings of cutting a STEP-NC program of features at a coarse grid."""
    from dataclasses import replace

    from cncgen.stepnc.cutting import cut_program

    program = cut_program(data, name, replace(options, kinematics=None))
    try:
        piece = raw_stock(program.raw)
    except UsageError as fault:
        return [replace(d, severity=Severity.WARNING) for d in fault.diagnostics]
    if program.diagnostics.has_errors or piece is None or len(program.axes) > 3:
        return []
    clampings = clampings_of(program)
    if _setups(program.toolpaths) > 1:
        if program.unlike.startswith("they"):
            text = f"its cut is not looked at: {_setups(program.toolpaths)} setups, and {program.unlike}"
            return [Diagnostic("cut-setups", text, severity=Severity.NOTE)]
        if not clampings or any(c.target is None for c in clampings.values()):
            return []
        cell = float((piece.high - piece.low).max()) / COARSE_COLUMNS
        return cut_toolpaths(program.toolpaths, piece, name, None, None, cell, clampings).findings
    if program.turned is not None and turns(program.toolpaths):
        return turn_toolpaths(program.toolpaths, piece, name, None, program.turned).findings
    if program.finished is None:
        return []
    cell = float((piece.high - piece.low)[:2].max()) / COARSE_COLUMNS
    return cut_toolpaths(program.toolpaths, piece, name, None, program.finished, cell).findings
