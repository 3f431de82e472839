"""Where subroutines are: in the texts of a run, or in a file of their name on the search path."""

from __future__ import annotations

import os

from cncgen.gcode.block import Value
from cncgen.gcode.budget import LINE
from cncgen.gcode.errors import BlockError
from cncgen.gcode.source import Source
from cncgen.gcode.text.labels import Cursor, Label, shown

TYPE_CHECKING = False
if TYPE_CHECKING:
    from cncgen.gcode.interpreter import Interpreter
    from cncgen.gcode.text.marked_lines import Labels, Marked


class Subroutines:
    """The texts of a run (files are added as they are called), and what begins where in each.

    `program` is the file of the main program, whose folder is searched too.
    """

    def __init__(
        self, ip: Interpreter, sources: list[Source], program: str | os.PathLike[str] | None
    ) -> None:
        self.ip = ip
        self.sources = sources
        #: Labels of subroutines that were found without an end.
        self.unclosed: set[Label] = set()
        self._labels: dict[int, Labels] = {}
        #: Where subroutines of a label, called from a source, begin.
        self._found: dict[tuple[Label, int, tuple[str, ...]], Marked] = {}
        self._files: dict[str, int] = {}
        self._program = program

    def labels(self, source: int) -> Labels:
        """Return the lines of a source that jumps may lead to."""
        if source not in self._labels:
            from cncgen.gcode.text.marked_lines import Labels

            self._labels[source] = Labels(self.sources[source], source, self.ip.dialect)
        return self._labels[source]

    def resolved(self, label: Value | str) -> Value | str:
        """Return the present value of a label; a computed label counts as a block, so that its search has a bound."""
        if not callable(label):
            return label
        self.ip.budget.count(1, LINE)
        return label(self.ip.parameters)

    def find(self, label: Label, here: Cursor, keywords: tuple[str, ...] = ("sub",)) -> Marked:
        """Return the line that begins a subroutine: in the text of the call, in another, or in the file of its name.

        Raises:
            BlockError: It is missing, it has no end, or its file cannot be used.
        """
        if label in self.unclosed:
            message = f"o{shown(label)} has no ENDSUB: it is not run"
            raise BlockError("sub-unfinished", message, "O", hint="see its SUB")
        key = label, here.source, keywords
        if key in self._found:
            return self._found[key]
        for source in dict.fromkeys((here.source, *range(len(self.sources)))):
            found = self.labels(source).first(label, keywords, self.resolved)
            if found is not None:
                if not self._labels[source].computes:
                    self._found[key] = found
                return found
        return self._first_of_file(self._file(label), label, keywords)

    def _first_of_file(self, source: int, label: Label, keywords: tuple[str, ...]) -> Marked:
        """Return where the subroutine begins that a file has the name of."""
        if self.ip.dialect == "fanuc":
            marks = self.labels(source).marks
            return next((m for m in marks if m.keyword == "program"), _whole(label, source))
        found = self.labels(source).first(label, keywords, self.resolved)
        if found is not None:
            return found
        name = self.sources[source].name
        hint = "the file of a subroutine holds the subroutine of its name"
        raise BlockError("sub-missing", f"{name} has no o{shown(label)} SUB", "O", hint=hint)

    def _file(self, label: Label) -> int:
        """Return the source of the file that holds a subroutine; it must lie in a folder of the search path."""
        from cncgen.gcode.text.search import leaves_path, opened, places, search_path

        name = label if isinstance(label, str) else f"{label:g}"
        if self.ip.dialect == "fanuc" and isinstance(label, float):
            name = f"O{int(label):04d}"
        if name in self._files:
            return self._files[name]
        if leaves_path(name):
            message = f"the subroutine name <{name}> leads out of the search path"
            hint = "give the bare name, and the folder with --include"
            raise BlockError("sub-path", message, "O", hint=hint)
        folders = search_path(self._program, self.ip.options.include)
        source = opened(folders, name)
        if source is not None:
            self.sources.append(source)
            self._files[name] = len(self.sources) - 1
            return self._files[name]
        what = f"program {name}" if self.ip.dialect == "fanuc" else f"subroutine o{shown(label)}"
        message = f"there is no {what} in the text, and no file of that name in {places(folders)}"
        raise BlockError("sub-missing", message, "O", hint="--include adds a folder to the search path")


def _whole(label: Label, source: int) -> Marked:
    """Return the beginning of a file that is one program without a number."""
    from cncgen.gcode.text.marked_lines import Marked

    first = Cursor(source, 0, 1)
    return Marked(label, "program", first, first)
