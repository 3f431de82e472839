"""Simulated axes as a co-simulation unit of FMI 2.0 or 3.0: an archive with a description, C text, and the library compiled of it.

The unit runs the same loops as `simulate`: their tables are written into C, and the steps of the kernel `servo_loop` stand in C
beside them (``fmi_axes.c.in``; ``fmi2_unit.c.in`` and ``fmi3_unit.c.in`` have the functions of the standards). Its export needs a C
compiler; its use needs nothing.

Standards: Modelica Association, Functional Mock-up Interface for Model Exchange and Co-Simulation, version 2.0.1 (2019);
Functional Mock-up Interface Specification, version 3.0.2 (2024).
"""

from __future__ import annotations

import hashlib
import io
import os
import platform
import shlex
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import scratch_folder
from cncgen.servo.loop import AxisLoop
from cncgen.servo.scheme import Scheme
from cncgen.units import DEGREE, file_unit, to_file

Floats = NDArray[np.float64]

#: Name of the model within the unit: its C library and its instances are called so.
MODEL = "cncgen_axes"
#: Flags of the compiler: products are rounded before they are added, as in the kernels.
_FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")


def fmu_bytes(scheme: Scheme, controller: str, axes: str, period_s: float, fmi: int = 2) -> bytes:
    """Return the archive of a co-simulation unit.

    Its inputs are ``x_cmd_mm`` …, its outputs ``x_mm``, ``x_force`` and ``x_saturated`` …, for each axis. A step is one period of the
    setpoints, or several; inputs are held, or rise: by the derivative that is set (FMI 2.0: ``canInterpolateInputs``), or to
    what is set when the unit asks for the setpoints at the end of a period (FMI 3.0: ``providesIntermediateUpdate``). The
    axes stand where the first setpoints are.

    Args:
        scheme: The loops of the axes.
        controller: Its name, for messages.
        axes: Letters.
        period_s: Period of the setpoints, s.
        fmi: Version of the standard, 2 or 3.

    Raises:
        UsageError: The scheme shapes setpoints beforehand or couples axes, an axis has noise (``fmu-scheme``), or there is no C
            compiler (``fmu-compiler``).
    """
    _check(scheme, controller, axes)
    tables = _tables(scheme.loops, axes, period_s)
    parts = ("fmi_axes", f"fmi{fmi}_unit")
    body = "".join(Path(__file__).with_name(f"{part}.c.in").read_text(encoding="utf-8") for part in parts)
    guid = hashlib.sha256((tables + body).encode()).hexdigest()
    source = f'#define GUID "{guid}"\n{tables}\n{body}'
    folder, suffix = _platform(fmi)
    described = _description_3 if fmi == 3 else _description_2
    entries = {
        "modelDescription.xml": described(_variables(scheme.loops, axes), axes, period_s, guid).encode(),
        f"sources/{MODEL}.c": source.encode(),
        f"binaries/{folder}/{MODEL}{suffix}": _compiled(source, suffix),
    }
    if fmi == 3:
        entries["sources/buildDescription.xml"] = _BUILD.encode()
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in entries.items():
            # A fixed date: the same axes give the same bytes.
            file.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def _check(scheme: Scheme, controller: str, axes: str) -> None:
    what = ""
    if scheme.coupling is not None:
        what = f"the controller {controller} couples the axes along the path"
    elif scheme.prefilter is not None:
        what = f"the controller {controller} shapes setpoints before the axes receive them"
    noisy = [letter for letter, loop in zip(axes, scheme.loops, strict=True) if loop.imperfections.noise]
    if not what and noisy:
        what = f"the encoder of axis {', '.join(noisy)} has random noise (noise_rms)"
    if what:
        hint = "controllers p, plain and h-infinity can be exported, without noise"
        raise UsageError(Diagnostic("fmu-scheme", f"{what}, which an FMU cannot have", hint=hint))


def _tables(loops: Sequence[AxisLoop], axes: str, period_s: float) -> str:
    """Return the tables of the loops as C."""
    lines = [
        "/* Written by cncgen simulate --fmu. */",
        "#include <math.h>",
        f"#define AXES {len(loops)}",
        f"#define MOST_STATES {max(max(len(loop.output) for loop in loops), 1)}",
        f"#define PERIOD_S {period_s!r}",
        _RECORD,
    ]
    records = []
    for k, (letter, loop) in enumerate(zip(axes, loops, strict=True)):
        for name in _ARRAYS:
            lines.append(_array(f"{name}_{k}", getattr(loop, name)))
        records.append("    {" + ", ".join(_record(k, letter, loop, period_s)) + "},")
    return "\n".join([*lines, "static const Loop loops[AXES] = {", *records, "};"])


_ARRAYS = (
    *("phi", "inputs", "output", "encoder", "jump"),
    *("jump_inputs", "law", "law_inputs", "stick_law", "stick_inputs"),
)
_RECORD = f"""typedef struct {{
    const double {", ".join(f"*{name}" for name in _ARRAYS)};
    double bound, coulomb, dead_band, backlash, resolution, feedthrough, factor, force_factor;
    int order, levels, velocity, parts, sampled, load_side;
}} Loop;"""


def _array(name: str, values: Floats) -> str:
    numbers = ", ".join(_number(value) for value in np.asarray(values, float).ravel()) or "0"
    return f"static const double {name}[] = {{{numbers}}};"


def _number(value: float) -> str:
    return repr(float(value)) if np.isfinite(value) else "INFINITY" if value > 0 else "-INFINITY"


def _record(number: int, letter: str, loop: AxisLoop, period_s: float) -> list[str]:
    faults = loop.imperfections
    force_factor = 1.0 / DEGREE if loop.force_unit.startswith("rad") else 1.0
    numbers = (
        *(faults.bound, faults.coulomb if loop.velocity >= 0 else 0.0, loop.dead_band),
        *(faults.backlash, faults.encoder_step, loop.feedthrough, to_file(letter), force_factor),
    )
    switches = (
        *(len(loop.output), loop.phi.shape[1], loop.velocity),
        *(round(period_s / loop.period), int(loop.sampled), int(faults.load_feedback)),
    )
    return [*(f"{name}_{number}" for name in _ARRAYS), *map(_number, numbers), *map(str, switches)]


@dataclass(frozen=True)
class _Variable:
    """A variable of the unit; `reference` is the number by which the functions know it."""

    name: str
    reference: int
    flag: bool
    input: bool
    meaning: str


def _variables(loops: Sequence[AxisLoop], axes: str) -> list[_Variable]:
    """Return the variables in the order of their references: of each axis the input first."""
    found = []
    for k, (letter, loop) in enumerate(zip(axes, loops, strict=True)):
        low, unit = letter.lower(), file_unit(letter)
        force = (
            loop.force_unit.replace("rad", "deg", 1) if loop.force_unit.startswith("rad") else loop.force_unit
        )
        of_axis = (
            (f"{low}_cmd_{unit}", f"setpoint, {unit}"),
            (f"{low}_{unit}", f"position, {unit}"),
            (f"{low}_force", f"drive input at the start of the last step, {force}"),
            (f"{low}_saturated", "whether the drive met its bound in the last step"),
        )
        for place, (name, meaning) in enumerate(of_axis):
            found.append(_Variable(name, 4 * k + place, place == 3, place == 0, meaning))
    return found


def _description_2(variables: Sequence[_Variable], axes: str, period_s: float, guid: str) -> str:
    """Return modelDescription.xml of FMI 2.0.1 (section 2.2)."""
    import cncgen

    declared = []
    for one in variables:
        causality, start = ("input", ' start="0"') if one.input else ("output", "")
        kind, variability = ("Boolean", "discrete") if one.flag else ("Real", "continuous")
        declared.append(
            f'    <ScalarVariable name="{one.name}" valueReference="{one.reference}" causality="{causality}"'
            f' variability="{variability}" description={quoteattr(one.meaning)}><{kind}{start}/></ScalarVariable>'
        )
    outputs = [f'      <Unknown index="{k}"/>' for k, one in enumerate(variables, 1) if not one.input]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="2.0" modelName="cncgen axes {axes}" guid="{guid}"'
            f' generationTool="cncgen {cncgen.__version__}" variableNamingConvention="flat" numberOfEventIndicators="0">',
            f'  <CoSimulation modelIdentifier="{MODEL}" canHandleVariableCommunicationStepSize="true"'
            ' canInterpolateInputs="true" canNotUseMemoryManagementFunctions="true">',
            f'    <SourceFiles><File name="{MODEL}.c"/></SourceFiles>',
            "  </CoSimulation>",
            f'  <DefaultExperiment startTime="0" stepSize="{period_s!r}"/>',
            "  <ModelVariables>",
            *declared,
            "  </ModelVariables>",
            "  <ModelStructure>",
            "    <Outputs>",
            *outputs,
            "    </Outputs>",
            "    <InitialUnknowns>",
            *outputs,
            "    </InitialUnknowns>",
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


def _description_3(variables: Sequence[_Variable], axes: str, period_s: float, guid: str) -> str:
    """Return modelDescription.xml of FMI 3.0.2 (section 2.4)."""
    import cncgen

    declared = []
    for one in variables:
        kind, variability = ("Boolean", "discrete") if one.flag else ("Float64", "continuous")
        rest = 'input" intermediateUpdate="true" start="0"' if one.input else 'output"'
        declared.append(
            f'    <{kind} name="{one.name}" valueReference="{one.reference}" variability="{variability}"'
            f' description={quoteattr(one.meaning)} causality="{rest}/>'
        )
    outputs = [one.reference for one in variables if not one.input]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="3.0" modelName="cncgen axes {axes}" instantiationToken="{guid}"'
            f' generationTool="cncgen {cncgen.__version__}" variableNamingConvention="flat">',
            f'  <CoSimulation modelIdentifier="{MODEL}" canHandleVariableCommunicationStepSize="true"'
            f' fixedInternalStepSize="{period_s!r}" providesIntermediateUpdate="true"/>',
            f'  <DefaultExperiment startTime="0" stepSize="{period_s!r}"/>',
            "  <ModelVariables>",
            *declared,
            f'    <Float64 name="time" valueReference="{len(variables)}" variability="continuous" description="time, s"'
            ' causality="independent"/>',
            "  </ModelVariables>",
            "  <ModelStructure>",
            *(f'    <Output valueReference="{k}"/>' for k in outputs),
            *(f'    <InitialUnknown valueReference="{k}"/>' for k in outputs),
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


#: How the sources are compiled (FMI 3.0.2, section 2.5.1.5).
_BUILD = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{MODEL}">
    <SourceFileSet language="C99" compilerOptions="-ffp-contract=off">
      <SourceFile name="{MODEL}.c"/>
    </SourceFileSet>
    <Library name="m" external="true" description="C mathematics"/>
  </BuildConfiguration>
</fmiBuildDescription>
"""


def _platform(fmi: int) -> tuple[str, str]:
    """Return the folder of binaries and the suffix of libraries of this computer (FMI 2.0.1, 2.3; FMI 3.0.2, 2.5.1.4)."""
    system = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib")}.get(platform.system())
    if system is None:
        raise UsageError(Diagnostic("fmu-compiler", f"no FMU is compiled on {platform.system()}"))
    wide = sys.maxsize > 2**32
    if fmi == 2:
        return system[0] + ("64" if wide else "32"), system[1]
    machine = platform.machine().lower()
    arm = machine.startswith(("arm", "aarch"))
    narrow = "aarch32" if arm else "x86"
    processor = narrow if not wide else "aarch64" if arm else "x86_64" if machine == "amd64" else machine
    return f"{processor}-{system[0]}", system[1]


#: Longest time that a compiler may take, s.
_COMPILING_S = 120.0


def _compiled(source: str, suffix: str) -> bytes:
    """Compile a C text; return the library.

    Raises:
        UsageError: A compiler is missing, or it refuses the text.
    """
    named = os.environ.get("CC", "cc")
    try:
        command = shlex.split(named)
    except ValueError:  # quotes without an end
        command = []
    if not command or shutil.which(command[0]) is None:
        text = f"an FMU is compiled from C, and there is no compiler {command[0] if command else 'in CC'}"
        raise UsageError(Diagnostic("fmu-compiler", text, hint="install one, or name it: CC=gcc"))
    with scratch_folder() as folder:
        path, library = Path(folder) / f"{MODEL}.c", Path(folder) / f"{MODEL}{suffix}"
        path.write_text(source, encoding="utf-8")
        words = [*command, *_FLAGS, str(path), "-o", str(library), "-lm"]
        try:
            made = subprocess.run(
                words, capture_output=True, text=True, errors="replace", check=False, timeout=_COMPILING_S
            )
            said = next(iter(made.stderr.strip().splitlines()), f"exit {made.returncode}")
            if made.returncode == 0 and library.exists():
                return library.read_bytes()
        except (OSError, subprocess.TimeoutExpired) as error:
            said = str(error)
        raise UsageError(Diagnostic("fmu-compiler", f"{command[0]} refuses the C text of the FMU: {said}"))
