"""The page on a program: planned, simulated where the machine has servo data, judged, and recorded, in one pass."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from cncgen.arguments import declared, expect, expect_number, wrong
from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, UsageError
from cncgen.pipeline.planning import (
    Plan,
    as_read,
    driven_axes,
    machine_of,
    output_axes,
    program_of,
    sample,
    sound_for,
    summary_of,
    trajectories_of,
)
from cncgen.pipeline.reading import sound
from cncgen.pipeline.using import simulate, why

if TYPE_CHECKING:
    from cncgen.machine import Machine
    from cncgen.planner import PlanOptions
    from cncgen.removal.record import Removal
    from cncgen.report.page import Contents, Recording
    from cncgen.report.summary import Summary
    from cncgen.report.widget import Viewer
    from cncgen.servo.record import Response
    from cncgen.servo.wanted_motion import WantedMotion
    from cncgen.setpoints.record import Setpoints
    from cncgen.toolpath.record import Program
    from cncgen.verify import Verdict


@dataclass(frozen=True, slots=True)
class Page:
    """The page on a plan: `html` is a whole document, `remarks` the diagnostics of the planner."""

    html: str
    remarks: Diagnostics

    def _repr_html_(self) -> str:
        from cncgen.report.notebook import framed

        return framed(self.html)

    def __repr__(self) -> str:
        return f"Page({len(self.html)} characters)"


@dataclass(frozen=True, slots=True)
class Variant:
    """The other side of a comparison: the same program planned otherwise, or setpoints from a file.

    Attributes:
        label: Its name on the page.
        machine: On which it is planned; None: on that of the plan.
        options: How it is planned; None: as the plan.
        setpoints: A setpoint file, instead of a plan.
    """

    label: str
    machine: Machine | str | os.PathLike[str] | None = None
    options: PlanOptions | None = None
    setpoints: str | os.PathLike[str] | None = None


@dataclass(frozen=True, slots=True)
class ShownPart:
    """How the part is cut that a page shows, see `cncgen.pipeline.removing.cut`.

    Attributes:
        stock: The raw piece, as text of ``--stock``; None: that of a STEP-NC file.
        tools: Tools as texts of ``--tool``.
        cell_mm: Width of a column; None: some 500th of the stock.
    """

    stock: str | None = None
    tools: tuple[str, ...] = ()
    cell_mm: float | None = None


def shown_plan(planned: Plan) -> str:
    """Return the page on a plan, in a frame; it is planned anew for it, since a plan is drawn once."""
    from cncgen.report.notebook import framed

    return framed(report_page(planned.program, planned.machine, planned.options).html)


def shown_record(record: Any) -> str:
    """Return the view of a plan, setpoints, a response or a verdict in a notebook."""
    from cncgen.report import notebook

    kinds: dict[str, Callable[[Any], str]] = {
        "Plan": shown_plan,
        "Setpoints": notebook.of_setpoints,
        "Response": notebook.of_response,
        "Verdict": notebook.of_verdict,
    }
    return kinds[type(record).__name__](record)


@declared
def viewer(
    result: Plan | Page | Setpoints | Response | Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str] | None = None,
    options: PlanOptions | None = None,
    *,
    height: int = 720,
) -> Viewer:
    """Return the page as a live widget of a notebook: its view, moment and line are values that Python reads and sets.

    Args:
        result: A plan, the page on one, setpoints, a response, or a program, which is planned.
        machine: Of a program: as for `report_page`. Of setpoints and responses: the machine whose limits the charts show; None: none.
        options: Of a program: as for `report_page`.
        height: Of the frame, in pixels.

    Returns:
        The widget. ``t_s`` is the moment and ``line`` its line; ``view`` is the text after ``#`` in a link, and setting it restores
        that view.

    Raises:
        UsageError: anywidget is not installed (``viewer-missing``), or a machine or options are given with what has its own; or as
            `report_page`.
    """
    from cncgen.pipeline.planning import Plan
    from cncgen.report import notebook
    from cncgen.servo.record import Response
    from cncgen.setpoints.record import Setpoints

    try:
        from cncgen.report.widget import Viewer
    except ImportError as error:
        hint = "install it: pip install 'cncgen[notebook]'"
        fault = Diagnostic("viewer-missing", "a live viewer in a notebook needs anywidget", hint=hint)
        raise UsageError(fault) from error
    planned, given = isinstance(result, Page | Plan), isinstance(result, Setpoints | Response)
    if options is not None and (planned or given):
        raise wrong("options of a plan are given: what is to be viewed is planned already, or without a plan")
    if machine is not None and planned:
        raise wrong("a machine is given: the plan to be viewed has its own")
    where = machine_of(machine) if machine is not None else None
    if isinstance(result, Page):
        page = result.html
    elif isinstance(result, Setpoints):
        page = notebook.setpoints_page(result, where)
    elif isinstance(result, Response):
        page = notebook.response_page(result, where)
    elif isinstance(result, Plan):
        page = report_page(result.program, result.machine, result.options).html
    else:
        page = report_page(result, where or "generic-mill", options).html
    return Viewer(page=page, height=int(expect_number(height, "height", 1.0, _HIGHEST)))


#: Largest height of a viewer, pixels.
_HIGHEST = 100_000
#: Settings that a comparison may name, with the fields of `cncgen.PlanOptions` that they are.
_SETTINGS = {
    "feedrate": "feedrate",
    "interpolator": "interpolator",
    "saturation": "saturation",
    "profile": "profile",
    "effort": "effort",
    "as": "control",
    "tolerance": "path_tolerance_mm",
    "max-contour-error": "max_contour_error_mm",
}


def variant_of(what: str, options: PlanOptions | None = None) -> Variant:
    """Return the target of ``--compare``.

    Args:
        what: A setpoint file, a machine, or settings: ``feedrate=ild``, ``machine=xy-table,tolerance=0.02``.
        options: How the plan is made that it is compared with; settings replace some of them.

    Raises:
        UsageError: A setting is unknown, or its value is not a number where it has to be one.
    """
    from cncgen.planner import PlanOptions

    if "=" not in what:
        # A name with a suffix is a file's, also where there is no such file: its reader says so.
        suffix = os.path.splitext(what)[1].lower()
        if suffix != ".toml" and (suffix or os.path.isfile(what)):
            return Variant(os.path.basename(what), setpoints=what)
        return Variant(os.path.basename(what).removesuffix(".toml"), machine=what)
    machine: str | None = None
    asked: dict[str, Any] = {}
    for part in what.split(","):
        name, _, value = part.partition("=")
        if name == "machine":
            machine = value
        elif name in _SETTINGS:
            asked[_SETTINGS[name]] = _number(name, value) if _SETTINGS[name].endswith("_mm") else value
        else:
            known = ", ".join(("machine", *_SETTINGS))
            raise wrong(f"compare: {name!r} is not a setting; these are: {known}")
    return Variant(what, machine, replace(options or PlanOptions(), **asked))


def _number(name: str, value: str) -> float:
    try:
        return expect_number(float(value), f"compare: {name}", open_low=True)
    except ValueError:
        raise wrong(f"compare: {name}={value} is not a number of mm") from None


@declared
def report_page(
    program: Program | str | os.PathLike[str],
    machine: Machine | str | os.PathLike[str] = "generic-mill",
    options: PlanOptions | None = None,
    *,
    compare: Sequence[Variant | str] | str = (),
    with_why: bool = False,
    reference: WantedMotion | None = None,
    shown_part: ShownPart | None = None,
    title: str | None = None,
) -> Page:
    """Plan a program, simulate and judge the plan, and make the page on it.

    Args:
        program: From `read`, or a file.
        machine: A profile's name, a TOML file, or a machine. Where all axes have servo data, the page has their errors and forces.
        options: How it is planned.
        compare: Other plans of the same program, or setpoints, shown over this one; texts as of ``--compare``.
        with_why: The page shows the results of `why`; the program is planned several times for them.
        reference: The motion that was wanted; the axes' contour error is given from it too. The whole response is in memory then.
        shown_part: How the part is cut that the page shows. None: of a STEP-NC file its raw piece is, where the file has one.
        title: Of the page; None: program and machine.

    Returns:
        The page; ``html`` is a document that needs nothing else.

    Raises:
        UsageError, ProgramError, NoPlanError: As `plan`; of `shown_part` as `cncgen.pipeline.removing.cut`. There is a reference,
            and axes lack servo data (``servo-missing``).
    """
    from cncgen.planner.strategies import strategy
    from cncgen.report.page import html

    where, asked = machine_of(machine), program
    program = program_of(asked, where)
    parts, remarks = [], Diagnostics()
    given = (
        [compare] if isinstance(compare, str) else expect(compare, Iterable, "compare", "plans, in a list")
    )
    others = [variant_of(each, options) if isinstance(each, str) else each for each in given]
    variants: list[tuple[Variant, Machine]] = []
    for each in (Variant(where.name), *others):
        variant = expect(each, Variant, "what is compared", "a text as of --compare, or a Variant")
        variants.append((variant, where if variant.machine is None else machine_of(variant.machine)))
        if variant.options is not None:
            variant.options.check()
            strategy(variant.options.feedrate)
    setpoints = {
        k: _read(v.setpoints, program, m, v.label)
        for k, (v, m) in enumerate(variants)
        if v.setpoints is not None
    }
    for k, (variant, there) in enumerate(variants):
        if k in setpoints:
            parts.append(setpoints[k])
            continue
        how, wanted = variant.options or options, None if parts else reference
        part, said = _recorded(program_of(asked, there), there, how, variant.label, wanted)
        parts.append(part)
        remarks.extend(said)
    removal = _cut(program, shown_part, where.is_lathe, remarks)
    parts[0] = replace(parts[0], removal=removal)
    if with_why:
        _, ranked = why(program, where, options)
        parts[0] = replace(parts[0], why=[item.as_json() for item in ranked])
    return Page(html(title or f"{_shown(program.name)} on {where.name}", parts), remarks)


def _shown(name: str) -> str:
    return os.path.basename(name) or name


def _read(name: str | os.PathLike[str], program: Program, machine: Machine, label: str) -> Contents:
    """Record setpoints from a file; their velocities and so on are differences."""
    from cncgen.report.page import Contents, Recording
    from cncgen.setpoints.differencing import differenced
    from cncgen.setpoints.readers import open_setpoints

    axes = output_axes(program)
    with open_setpoints(name, unnamed_axes=axes, default_period_s=machine.period_s) as stream:
        recording = Recording(machine, stream.axes, stream.period_s)
        for _ in recording.over_setpoints(differenced(stream.chunks)):
            pass
    return Contents(label, machine, recording, {}, for_lathe=program.for_lathe)


def _recorded(
    program: Program,
    machine: Machine,
    options: PlanOptions | None,
    label: str,
    wanted: WantedMotion | None,
) -> tuple[Contents, Diagnostics]:
    """Plan a program; record, simulate and judge the plan while it is computed.

    Servo axes that cannot follow (an unstable loop) are left out, with a warning.
    """
    from cncgen.report.page import Contents

    remarks = Diagnostics()
    try:
        run = _Run(program, machine, options, wanted is not None or _has_servos(program, machine), wanted)
        verdict = run.drawn()
    except UsageError as error:
        if wanted is not None or not all(item.code.startswith("servo-") for item in error.diagnostics):
            raise
        remarks.extend(replace(item, severity=Severity.WARNING) for item in error.diagnostics)
        run = _Run(program, machine, options, with_servos=False)
        verdict = run.drawn()
    remarks.extend(run.summary.remarks)
    summary, places = {**run.summary.as_json(), **run.against()}, run.summary.places()
    shown = Contents(label, machine, run.recording, summary, places, verdict, for_lathe=program.for_lathe)
    return shown, remarks


def _cut(
    program: Program,
    shown_part: ShownPart | None,
    on_lathe: bool,
    remarks: Diagnostics,
) -> Removal | None:
    """Return the stock that remains after a program; None if it is not requested and the program is not a STEP-NC file with known
    stock."""
    from cncgen.pipeline.removing import cut

    how = shown_part or ShownPart()
    if shown_part is None and (program.language != "stepnc" or not os.path.isfile(program.name)):
        return None
    try:
        removal = cut(
            program.name,
            stock=how.stock,
            tools=how.tools,
            cell_mm=how.cell_mm,
            language=program.language,
            options=program.options,
            on_lathe=on_lathe,
        )
        # The page has what is wrong with the cut; what is not cut would look like a part that is.
        remarks.extend(item for item in removal.findings if item.code in ("cut-tool", "cut-narrow"))
        return removal
    except UsageError as error:
        if shown_part is not None:
            raise
        remarks.extend(replace(item, severity=Severity.NOTE) for item in error.diagnostics)
        return None


def _has_servos(program: Program, machine: Machine) -> bool:
    axes = [machine.axes.get(letter) for letter in driven_axes(program, machine)]
    return bool(axes) and all(axis is not None and axis.servo is not None for axis in axes)


class _Run:
    """One plan of a program, with its observers."""

    def __init__(
        self,
        program: Program,
        machine: Machine,
        options: PlanOptions | None,
        with_servos: bool,
        wanted: WantedMotion | None = None,
    ) -> None:
        from cncgen import planner
        from cncgen.report.page import SIGNALS, Recording
        from cncgen.setpoints.differencing import differenced

        how = as_read(options or planner.PlanOptions(), program)
        self._program, self._machine, self._with_servos = program, machine, with_servos
        self._wanted = wanted
        self._responses: list[Response] = []
        axes = output_axes(program)
        self.summary: Summary = summary_of(program, machine, how)
        self.recording: Recording = Recording(machine, axes, machine.period_s)
        trajectories = trajectories_of(self.summary.over_toolpaths(sound_for(program, how)), machine, how)
        watched = self.recording.over_trajectories(self.summary.over_trajectories(trajectories))
        # The velocities of strategies that keep no limit of an axis jump, which their own derivatives do not show.
        signals = [name for name in SIGNALS if how.keeps_limits or name not in ("acc", "jerk")]
        stream = sample(Plan(program, machine, watched, how.keeps_limits, how), [*signals, "tool_length"])
        chunks = stream.chunks if how.keeps_limits else differenced(stream.chunks)
        self._chunks = self.recording.over_setpoints(self.summary.over_setpoints(chunks))

    def drawn(self) -> Verdict | None:
        """Draw the plan to its end; return the verdict on it, or None of one without setpoints."""
        from cncgen.setpoints.stream import SetpointStream

        chunks = self._followed() if self._with_servos else self._chunks
        head = next(chunks, None)
        if head is None:
            return None
        from itertools import chain

        from cncgen.verify import verify

        program = self._program
        stream = SetpointStream(program.name, head.axes, head.period_s, chain((head,), chunks))
        return verify(stream, sound(program), self._machine, named=program.moving_axes or None)

    def _followed(self) -> Iterator[Setpoints]:
        """Yield the setpoints behind the simulation of the servo axes, which the recording watches."""
        from cncgen.setpoints.record import Setpoints

        responses = simulate(self._chunks, self._machine)
        for chunk in self.recording.over_responses(responses):
            if self._wanted is not None:
                self._responses.append(chunk)
            yield Setpoints(chunk.axes, chunk.period_s, chunk.first, chunk.command)

    def against(self) -> dict[str, Any]:
        """Return the errors from the wanted motion for the summary, and record the contour error; {} without one."""
        if self._wanted is None or not self._responses:
            return {}
        from cncgen.servo.wanted_motion import judged_against, laid_over

        found = judged_against(self._wanted, self._responses)
        _, _, contour, _ = laid_over(self._wanted, self._responses)
        if contour is not None:
            self.recording.take_reference(contour)
        return {"reference": found}
