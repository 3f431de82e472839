"""The work of `cncgen check`."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from cncgen.cli import messages
from cncgen.diagnostics import CncgenError, one_line

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.diagnostics import Diagnostic
    from cncgen.toolpath.reading import ReadOptions

#: Bytes by which a language is known.
_HEAD = 4096
#: Shapes of a workplan that is printed.
TEXT, JSON = "text", "json"


def check_all(programs: Sequence[str], shape: str | None, language: str | None, options: ReadOptions) -> int:
    """Check one program after the other, and print their workplans in a `shape`; return the exit code."""
    from cncgen.files import read_bytes, together

    code = failed = 0
    for name in programs:
        try:
            with together():
                # A tree is made from the text again, which standard input has once.
                content = read_bytes(name) if shape else None
                _check(name, language, options, content)
                if content is not None and shape is not None:
                    _show_tree(name, language, options, content, shape)
        except CncgenError as error:
            messages.show_error(error)
            messages.note(one_line(f"{name}: {_counts(error.diagnostics, error.suppressed)}"))
            code, failed = max(code, error.exit_code), failed + 1
    if len(programs) > 1:
        messages.note(f"{len(programs)} files: {len(programs) - failed} without errors, {failed} with errors")
    return code


def _counts(found: Iterable[Diagnostic], suppressed: int = 0) -> str:
    """Return how many errors and warnings there are; "no errors" without any."""
    from cncgen.diagnostics import Severity

    severities = [item.severity for item in found]
    errors, warnings = (severities.count(each) for each in (Severity.ERROR, Severity.WARNING))
    texts = [] if errors else ["no errors"]
    if errors or warnings:
        from cncgen.report.tables import counted

        texts += [counted(n, what) for n, what in ((errors, "error"), (warnings, "warning")) if n]
    if suppressed:
        texts.append(f"{suppressed} more of either")
    return ", ".join(texts)


def _check(name: str, language: str | None, options: ReadOptions, content: bytes | None) -> None:
    from cncgen.diagnostics import CncgenError, Diagnostics, ProgramError
    from cncgen.kernels import warn_if_uncompiled
    from cncgen.pipeline import check

    warn_if_uncompiled()
    found = Diagnostics()
    try:
        count = check(name, found, language=language, options=options, content=content)
    except CncgenError as error:
        raised = {id(item) for item in error.diagnostics}
        messages.show(item for item in found if id(item) not in raised)
        raise
    if not found.has_errors and _is_stepnc(name, language, content):
        from cncgen.pipeline.removing import coarse_findings

        found.extend(coarse_findings(name, options, content))
    if found.has_errors:
        raise ProgramError(found)
    messages.show(found)
    counts = _counts(found, found.suppressed)
    motions = "motion or event" if count == 1 else "motions and events"
    messages.note(one_line(f"{name}: {counts}, {count} {motions}"))


def _is_stepnc(name: str, language: str | None, content: bytes | None) -> bool:
    """Tell whether a program is STEP-NC: by the option, or by the content of its file."""
    from cncgen.pipeline import language_of

    if language is None and content is None and os.path.isfile(name):
        with open(name, "rb") as file:
            content = file.read(_HEAD)
    return (language or language_of(name, content or b"")) == "stepnc"


def _show_tree(name: str, language: str | None, options: ReadOptions, content: bytes, shape: str) -> None:
    from cncgen.files import write_text

    if not _is_stepnc(name, language, content):
        return
    from cncgen.stepnc import entries, tree

    if shape == JSON:
        import json

        plans = [entry.as_json() for entry in entries(content, name, options)]
        write_text(None, json.dumps({"schema_version": 1, "program": name, "workplans": plans}) + "\n")
    else:
        write_text(None, "".join(f"{line}\n" for line in tree(content, name, options)))
