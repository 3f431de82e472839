"""`cncgen convert`: a program in another form."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli.options import control_option, message_options, program_options
from cncgen.cli.types import FILE, FiniteRange

#: Tolerances below it are finer than any position, and make a file of millions of lines out of an arc.
_LEAST_MM = 1e-9


@click.command("convert")
@click.argument("program", metavar="PROGRAM", type=FILE)
@click.option("-o", "--output", metavar="FILE", type=FILE, help="Where to write [default: standard output].")
@click.option(
    "--to",
    type=click.Choice(("gcode", "stepnc")),
    help="Language to write [default: by the suffix of the output, else G-code].",
)
@click.option(
    "--for",
    "control",
    type=click.Choice(("linuxcnc", "fanuc")),
    default="linuxcnc",
    show_default=True,
    help="Control that G-code is written for: taps are G33.1, or M29 with G84; probing is G38.2, or G31.",
)
@click.option(
    "--linearize",
    metavar="TOL",
    type=FiniteRange(min=_LEAST_MM),
    help="Write splines and arcs as lines within TOL mm.",
)
@click.option(
    "--fit",
    metavar="TOL",
    type=FiniteRange(min=_LEAST_MM),
    help="Write runs of short lines as curves (G6.2) within TOL mm.",
)
@click.option(
    "--stock",
    metavar="STOCK",
    help="Raw piece to write into STEP-NC: box:X0,Y0,Z0,X1,Y1,Z1 or cylinder:X,Y,DIAMETER,Z0,Z1, mm [default: the program's].",
)
@control_option
@program_options
@message_options
def command(
    program: str,
    output: str | None,
    to: str | None,
    control: str,
    linearize: float | None,
    fit: float | None,
    stock: str | None,
    machine: str | None,
    reading: dict[str, Any],
) -> None:
    """Rewrite a program in another form.

    STEP-NC to G-code, G-code to STEP-NC, curves to lines, short lines to curves. Splines of STEP-NC become G6.2, and
    the entity that a motion comes from stands before it in a comment.
    """
    from cncgen.cli import messages
    from cncgen.cli.reading import opened
    from cncgen.diagnostics import Diagnostics
    from cncgen.files import write_text
    from cncgen.pipeline import language_of, sound

    target = to or (language_of(output, b"") if output else "gcode")
    piece = _raw_piece(stock, target)
    with opened(program, reading | {"workingsteps": target == "stepnc"}, machine=machine) as source:
        chunks = sound(source)
        if fit is not None:
            from cncgen.planner.smoothing.fitted import fit_runs

            chunks = fit_runs(chunks, fit)
        if target == "stepnc":
            import io

            from cncgen.stepnc import write_ap238
            from cncgen.toolpath.lines import lines_alone

            if linearize is not None:
                chunks = lines_alone(chunks, linearize)
            stream = io.StringIO()
            messages.show(write_ap238(chunks, stream, source.name, stock=piece))
            text = stream.getvalue()
        else:
            from cncgen.stepnc import gcode_lines

            describe = _entities(program) if source.language == "stepnc" else None
            remarks = Diagnostics()
            lines = list(gcode_lines(chunks, source.name, linearize, describe, control, remarks))
            messages.show(remarks)
            text = "\n".join(lines) + "\n"
    write_text(output, text)


def _raw_piece(text: str | None, target: str) -> dict[str, Any] | None:
    """Return the raw piece of ``--stock`` as AP238 has it.

    Raises:
        UsageError: It is not a box or a cylinder, or G-code is written, which has no place for it.
    """
    if text is None:
        return None
    from cncgen.diagnostics import Diagnostic, UsageError
    from cncgen.removal.stock import stock_of_option

    if target != "stepnc":
        raise UsageError(Diagnostic("usage", "--stock goes with STEP-NC as output; G-code has no raw piece"))
    return stock_of_option(text).solid_values()


def _entities(program: str) -> Any:
    """Return a function that names the entity of a line, if the file can be read again."""
    from pathlib import Path

    from cncgen.stepnc import entities_by_line

    if program == "-":
        return None
    names = entities_by_line(Path(program), program)
    return lambda line: names.get(line, "")
