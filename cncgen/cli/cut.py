"""`cncgen cut`: the material that a program removes from its stock, and the faults of the cut."""

from __future__ import annotations

from typing import Any

import click

from cncgen.cli import messages
from cncgen.cli.options import control_option, message_options, program_options, stock_options
from cncgen.cli.types import FILE


@click.command("cut")
@click.argument("program", metavar="PROGRAM", type=FILE)
@stock_options
@click.option("--target", metavar="STL", type=FILE, help="The finished part [default: what features say].")
@click.option("-o", "--output", metavar="STL", type=FILE, help="Write the stock that is left as STL.")
@click.option("--picture", metavar="FILE", type=FILE, help="Draw it: PNG, SVG or PDF.")
@click.option("--report", metavar="FILE", type=FILE, help="Write volumes, engagement and findings as JSON.")
@control_option
@program_options
@message_options
def command(
    program: str,
    stock: str | None,
    tools: tuple[str, ...],
    target: str | None,
    cell: float | None,
    output: str | None,
    picture: str | None,
    report: str | None,
    machine: str | None,
    reading: dict[str, Any],
) -> int:
    """Cut the stock of a program and report the faults.

    The command names motions that enter the stock at rapid, that cut with a standing spindle or one that turns the wrong way,
    that cut into the finished part, or that touch the stock with shank or holder. It also names material that is left where a
    feature demands its removal. Exit 1 if a motion is wrong, or if cuts are left out because their tool has no size. Positions are
    those of the tools' tips.
    """
    import json
    from pathlib import Path

    from cncgen.cli.reading import read_options
    from cncgen.diagnostics import Diagnostic, Diagnostics, Severity, json_values
    from cncgen.files import write_text
    from cncgen.pipeline import machine_of
    from cncgen.pipeline.removing import cut
    from cncgen.report.drawing import check_format
    from cncgen.report.removed import as_text, figure

    if output and Path(output).suffix.lower() not in ("", ".stl"):
        raise click.UsageError(f"--output {output}: the stock is written as .stl; --picture draws it.")
    if picture:
        check_format(picture)
    language, options = read_options(reading, machine=machine)
    said = Diagnostics()
    removal = cut(
        program,
        stock=stock,
        tools=tools,
        target=target,
        cell_mm=cell,
        language=language,
        options=options,
        on_lathe=machine is not None and machine_of(machine).is_lathe,
        diagnostics=said,
    )
    messages.show(said)
    if output:
        from cncgen.files import open_output
        from cncgen.removal.surfaces import EMPTY_BYTES, mesh_of, stl_bytes

        solid = stl_bytes(*mesh_of(removal.stock))
        with open_output(output) as sink:
            sink.write(solid)
        if len(solid) == EMPTY_BYTES:
            message = f"nothing is left of the stock: {output} has no triangles"
            messages.show(
                [
                    Diagnostic(
                        "cut-empty",
                        message,
                        Severity.WARNING,
                        hint="are stock and tools those of the program?",
                    )
                ]
            )
    if picture:
        from cncgen.report.drawing import save

        save(figure(removal, program), picture)
    if report:
        write_text(report, json.dumps(json_values(removal.as_json()), indent=2) + "\n")
    messages.show(removal.findings)
    messages.note(as_text(removal))
    return 0 if removal.holds else 1
