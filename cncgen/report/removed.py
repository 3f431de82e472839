"""Pictures of a cut stock: from above with its depths, in relief, and the removal rate over time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cncgen.removal.record import Dexels, Field, Removal, Turned
from cncgen.report import drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

Floats = NDArray[np.float64]

#: Columns along the longer side of the relief, and from where it is seen, rad.
RELIEF_COLUMNS = 240
AZIMUTH, ELEVATION = math.radians(-60.0), math.radians(50.0)
#: Stretches of time of the removal rate.
STRETCHES = 400


def as_text(removal: Removal) -> str:
    """Return the removed volume, in all and by operation, as a table."""
    removed = sum(o.volume_mm3 for o in removal.operations)
    raw = removal.raw_volume_mm3
    share = f" ({100 * removed / raw:.1f} %)" if raw > 0 else ""
    kind = "rings" if isinstance(removal.stock, Turned) else "grid"
    lines = [f"removed {removed:.1f} of {raw:.1f} mm³{share}, {kind} of {removal.stock.cell:.4g} mm"]
    width = max([9, *(len(o.name) for o in removal.operations)])
    lines.append(f"{'operation':<{width}}  {'tool':<12} {'mm³':>12} {'s':>9} {'mm³/s':>9} {'deepest mm':>11}")
    for o in removal.operations:
        rate = f"{o.volume_mm3 / o.cutting_s:9.2f}" if o.cutting_s > 0 else f"{'-':>9}"
        row = f"{o.name:<{width}}  {o.tool:<12} {o.volume_mm3:12.1f} {o.cutting_s:9.1f} {rate} {o.deepest_mm:11.3f}"
        lines.append(row)
    return "\n".join(lines)


def _section(made: Figure, place: SubplotSpec, stock: Turned, removal: Removal) -> None:
    """Draw the half section of a bar, the raw piece behind it."""
    part = made.add_subplot(place)
    z = stock.z
    part.fill_between(z, 0.0, stock.raw, color="0.9", linewidth=0, label="raw piece")
    part.fill_between(
        z, stock.bore, np.maximum(stock.radius, stock.bore), color="#4477aa", linewidth=0, label="left"
    )
    part.axhline(0.0, color="0.3", linewidth=0.8, linestyle="-.")
    _crosses(part, removal, 2, 0)
    part.set_aspect("equal")
    part.set_xlabel("Z (mm)")
    part.set_ylabel("radius (mm)")
    part.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize=8)


def _crosses(part: Axes, removal: Removal, across: int, up: int) -> None:
    """Mark the findings at their places, with the given coordinates to the right and upwards."""
    for finding in removal.findings:
        where = finding.values.get("place_mm")
        if where is not None:
            colour = drawing.RED if finding.severity == "error" else drawing.ORANGE
            part.plot(where[across], where[up], "x", color=colour, markersize=6)


def figure(removal: Removal, title: str) -> Figure:
    """Return a figure: heights from above, the relief, and the removal rate over the time at programmed feeds.

    Raises:
        UsageError: matplotlib is not installed.
    """
    made, _ = drawing.new_figure(title, 1, 1, height=8.0, width=11.0)
    made.clear()
    made.suptitle(title, fontsize=11)
    grid = made.add_gridspec(2, 2, height_ratios=(3, 1))
    if isinstance(removal.stock, Turned):
        _section(made, grid[0, :], removal.stock, removal)
    else:
        seen = removal.stock.seen() if isinstance(removal.stock, Dexels) else removal.stock
        _from_above(made, grid[0, 0], seen, removal)
        _relief(made, grid[0, 1], seen)
    _rates(made.add_subplot(grid[1, :]), removal)
    return made


def _from_above(made: Figure, place: SubplotSpec, field: Field, removal: Removal) -> None:
    from matplotlib.colors import LightSource

    part = made.add_subplot(place)
    heights = np.where(field.heights > field.bottom, field.heights, np.nan)
    x, y, half = field.x, field.y, field.cell / 2
    extent = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    shown = part.imshow(heights, origin="lower", extent=extent, cmap="viridis", interpolation="nearest")
    shade = LightSource(azdeg=315, altdeg=50).hillshade(
        np.nan_to_num(heights, nan=float(field.bottom.min())), dx=field.cell, dy=field.cell
    )
    part.imshow(shade, origin="lower", extent=extent, cmap="gray", alpha=0.35, interpolation="nearest")
    _crosses(part, removal, 0, 1)
    part.set_xlabel("X (mm)")
    part.set_ylabel("Y (mm)")
    made.colorbar(shown, ax=part, label="height (mm)", shrink=0.8)


def _relief(made: Figure, place: SubplotSpec, field: Field) -> None:
    """Draw the stock in relief, with its sides."""
    from matplotlib import colormaps

    part = made.add_subplot(place)
    met, shade, dot = seen_obliquely(field)
    low, high = float(field.heights.min()), float(field.heights.max())
    colours = colormaps["viridis"]((met - low) / max(high - low, 1e-9))
    colours[..., :3] *= shade[..., None]
    colours[np.isnan(met)] = 0.0
    sides = (0, dot[0] * met.shape[1], 0, dot[1] * met.shape[0])
    part.imshow(colours, origin="lower", extent=sides, interpolation="nearest")
    part.set_axis_off()


def seen_obliquely(field: Field) -> tuple[Floats, Floats, tuple[float, float]]:
    """Return a picture of a stock from afar, of dots where a line of sight first meets it.

    Returns:
        Height of each place, mm, nan beside the stock; its brightness, 1 where no wall is; width and height of a dot, mm.
    """
    step = max(1, -(-max(field.heights.shape) // RELIEF_COLUMNS))
    heights = np.maximum(field.heights, field.bottom)[::step, ::step]
    (rows, columns), cell = heights.shape, field.cell * step
    low, high = float(field.bottom.min()), float(heights.max())
    right, back = (np.array([math.cos(a), math.sin(a)]) for a in (AZIMUTH + math.pi / 2, AZIMUTH))
    corners = np.array([[x, y] for x in (0, columns * cell) for y in (0, rows * cell)])
    # A line of sight falls towards the back; it is told by where it comes to the height of the stock's top.
    fall = (high - low) / math.tan(ELEVATION)
    across, along = corners @ right, corners @ -back
    u, v = np.meshgrid(
        np.linspace(across.min(), across.max(), 2 * RELIEF_COLUMNS),
        np.linspace(along.min() - fall, along.max(), 2 * RELIEF_COLUMNS),
    )
    met, shade = np.full(u.shape, np.nan), np.ones(u.shape)
    steps = max(math.ceil(4 * fall / cell), 1)
    for k, z in enumerate(np.linspace(high, low, steps + 1)):
        gone = v + fall * k / steps
        i, j = (np.floor((u * right[a] - gone * back[a]) / cell).astype(int) for a in (0, 1))
        open_ = np.flatnonzero((i >= 0) & (i < columns) & (j >= 0) & (j < rows) & np.isnan(met))
        above = heights[j.flat[open_], i.flat[open_]] - z
        there = (above >= 0) & (above + z > low)
        met.flat[open_[there]] = z
        # A wall is met below its top.
        below = above[there] * steps / max(high - low, 1e-9) - 1.0
        shade.flat[open_[there]] = 1.0 - np.clip(0.1 * below, 0.0, 0.35)
    dot = float(u[0, 1] - u[0, 0]), float(v[1, 0] - v[0, 0]) * math.sin(ELEVATION)
    return met, shade, dot


def _rates(part: Axes, removal: Removal) -> None:
    times, rates = removal.time_s, removal.rate_mm3_s
    end = float(times[-1]) if len(times) else 0.0
    if end > 0:
        borders = np.linspace(0.0, end, STRETCHES + 1)
        before = np.concatenate([[0.0], times])
        removed = np.concatenate([[0.0], np.cumsum(rates * np.diff(before))])
        mean = np.diff(np.interp(borders, before, removed)) / np.diff(borders)
        part.step(borders[1:], mean, color=drawing.BLUE, linewidth=0.9)
    part.set_xlabel("time at programmed feeds (s)")
    part.set_ylabel("removed (mm³/s)")
    part.grid(True, linewidth=0.4, alpha=0.5)
