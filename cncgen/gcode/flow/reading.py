"""Lines of a run as parsed blocks, in the program's dialect; and the lines of ``%`` around it."""

from __future__ import annotations

from cncgen.diagnostics import Severity
from cncgen.gcode.block import Block, Parsed
from cncgen.gcode.errors import BlockError
from cncgen.gcode.interpreter import Interpreter
from cncgen.gcode.source import MAX_LINE, Source
from cncgen.gcode.text import signs
from cncgen.gcode.text.dialects import bare
from cncgen.gcode.text.labels import Cursor

_PERCENT = rb"(?m)^[ \t]*%"
#: Bytes behind the end of a program that are looked at.
_REST = 65_536
#: The end of a program, a block that moves, what ends a subprogram or calls from one, and what leads to lines by their numbers.
_END, _MOVES = rb"M(?:0*2|30)(?![\d.])", rb"[XYZUW][ \t]*[-+.\d#\[]"
_SUBPROGRAM, _LEADS = rb"M[ \t]*99(?![\d.])|ENDSUB", rb"GOTO|M9[678]|G7[0-3][^\n]*P\d+Q|M99P"
#: A program by its number and what stands in it, and a call by a number or a computed one (FANUC).
_PROGRAM, _CALLED = rb"(?ms)^[O:](\d+)(.*?)(?=^[O:]\d|\Z)", rb"P(\d+|[#\[])"
_MAX_TEXTS = 1024


class LineReader:
    """Reads lines of the sources; the latest texts are remembered with their blocks."""

    def __init__(self, sources: list[Source], dialect: str, *, increments: bool) -> None:
        self._sources = sources
        self._dialect = dialect
        self._increments = increments
        self._parsed: dict[str, Parsed] = {}

    def text(self, here: Cursor) -> str:
        """Return a line's text; raise where it is too long to be one."""
        source = self._sources[here.source]
        length = source.line_end(here.offset) - here.offset
        if length > MAX_LINE:
            message = f"a line of {length} bytes; the longest is {MAX_LINE}"
            raise BlockError("line-too-long", message, column=1)
        return source.text_at(here.offset)

    def after(self, here: Cursor) -> Cursor:
        """Return the next line."""
        return Cursor(here.source, self._sources[here.source].line_end(here.offset) + 1, here.line + 1)

    def parse(self, text: str) -> Parsed:
        """Return the block of a text."""
        parsed = self._parsed.get(text)
        if parsed is None:
            from cncgen.gcode.text import grammar

            parsed = grammar.parse(text, self._dialect, self._increments)
            if len(self._parsed) >= _MAX_TEXTS:
                self._parsed.clear()
            self._parsed[text] = parsed
        return parsed


def first_line(ip: Interpreter, source: Source) -> Cursor:
    """Return the first line of a program: of FANUC's, that of the main program which stands behind subprograms."""
    if ip.dialect != "fanuc":
        return Cursor(0, 0, 1)
    from cncgen.gcode.main_program import main_behind

    main = main_behind(source)
    return main[0] if main is not None else _behind_leader(ip, source)


def _behind_leader(ip: Interpreter, source: Source) -> Cursor:
    """Return the first line of a tape: for FANUC's controls the first % where text stands before it and another % behind its blocks.

    That text is the leader of a tape, which the control passes over (B-63324EN, 13.1); a note says how much. Where it has blocks
    behind a program's number it is a program, which the % ends.
    """
    import re

    first = re.search(_PERCENT, source.data[:_REST])
    before = b"" if first is None else bare(source.data[: first.start()]).strip()
    if first is None or not before or re.match(rb"[O:]\d++\s*+\S", before):
        return Cursor(0, 0, 1)
    second = re.compile(_PERCENT).search(source.data, first.end())
    if (
        second is None
        or not bare(source.data[first.end() : min(second.start(), first.end() + _REST)]).strip()
    ):
        return Cursor(0, 0, 1)
    begin = Cursor(0, first.start(), source.data[: first.start()].count(b"\n") + 1)
    ip.base.block = Block({}, line=1)
    message = f"{begin.line - 1} lines before the % that begins the program are passed over"
    hint = "a control reads from the first % on"
    ip.remark(BlockError("text-before-start", message, column=1, hint=hint), Severity.WARNING)
    return begin


def tell_of_rest(ip: Interpreter, source: Source, last: Block) -> None:
    """Warn of blocks behind the one whose M2 or M30 ended the program: controls end there, senders to grbl go on.

    Subprograms stand there as well, and lines that a jump or a cycle leads to.
    """
    begin, behind = last.offset, source.line_end(last.offset)
    data = source.data[behind : behind + _REST]
    if not data.strip(b"% \t\r\n\x00\x1a"):
        return
    import re

    end = re.search(_END, bare(source.data[begin:behind]))
    code = re.sub(signs.OUT_OF_CODE, b"", data.upper())
    if (
        end is not None
        and ip.dialect == "fanuc"
        and (own := _uncalled(code, bare(source.data[:behind][-_REST:])))
    ):
        ip.base.block = last
        message = f"{own} behind {end[0].decode()} has an end of its own, and nothing calls it: it is another program, which is not run"
        hint = "programs of their own belong into files of their own"
        ip.warn("text-behind-end", message, end[0].decode(), hint)
        return
    rest = code.partition(b"\n%")[0].strip()
    lines = [line for line in rest.splitlines() if re.search(_MOVES, line)]
    if end is None or not lines or rest[:1] in b"%O:<" or re.search(_SUBPROGRAM, rest):
        return
    if re.search(_LEADS, bare(source.data[:begin][-_REST:])):
        return
    ip.base.block = last
    least = "at least " if behind + _REST < len(source) else ""
    name = end[0].decode()
    message = f"{least}{len(lines)} blocks with motions stand behind {name}, which ends the program: they are not run"
    hint = f"remove {name} where they belong to it; programs of their own belong into files of their own"
    ip.warn("text-behind-end", message, name, hint)


def _uncalled(rest: bytes, before: bytes) -> str:
    """Return the first program behind the end of the main one that moves, ends as a main program does and has no call; "" without one."""
    import re

    calls = re.findall(_CALLED, before) + re.findall(_CALLED, rest)
    if not all(call.isdigit() for call in calls):
        return ""
    # The first digits of P may be the number of times.
    called = {digits.lstrip(b"0") for call in calls for digits in (call, call[-4:])}
    for number, body in re.findall(_PROGRAM, rest):
        alone = re.search(_MOVES, body) and re.search(_END, body) and not re.search(_SUBPROGRAM, body)
        if alone and number.lstrip(b"0") not in called:
            return f"O{number.decode()}"
    return ""


class Percent:
    """The lines of ``%`` that may stand around a program.

    Attributes:
        seen: Whether a line was read; a ``%`` before it, or behind comments alone, begins the program.
    """

    def __init__(self, ip: Interpreter, source: Source) -> None:
        self._ip = ip
        self._source = source
        self._begun = False
        self.seen = False

    def line(self, text: str, before: int) -> None:
        """Begin or end the program; `before` is how many bytes of it are read."""
        if self._ip.dialect == "linuxcnc" and not self._stands_alone(text):
            message = "a line of % holds nothing else"
            raise BlockError("syntax", message, column=text.index("%") + 1, hint="put the rest in a line")
        if not self._begun and not self._is_late(before):
            self._begun = True
        elif self._begun:
            self._tell_of_rest(text, before)
            self._ip.state.ended = True
            self._ip.base.call("FINISH()")
        else:
            self._tell_of_rest(text, before)
            self._end_alone(text)

    def _tell_of_rest(self, text: str, before: int) -> None:
        """Warn of blocks behind the % that ends the program, which are not read."""
        rest = bare(self._source.data[before : before + _REST])
        count = sum(1 for line in rest.splitlines() if line and not line.startswith((b"%", b";")))
        if count and not self._ip.options.stand_alone:
            begin = self._source.data.rfind(b"\n", 0, max(0, before - 1)) + 1
            line = self._source.data[:begin].count(b"\n") + 1
            self._ip.base.block = Block({}, line=line, offset=begin)
            least = "at least " if before + _REST < len(self._source) else ""
            message = f"{least}{count} lines stand behind the % that ends the program: they are not read"
            hint = "remove the % where they belong to it"
            fault = BlockError("text-behind-end", message, column=text.index("%") + 1, hint=hint)
            self._ip.remark(fault, Severity.WARNING)

    def _end_alone(self, text: str) -> None:
        """End a program at a % that no % began: the rest of a tape, which LinuxCNC's interpreter alone refuses."""
        message = "a % that ends a program that no % began"
        fault = BlockError("stray-percent", message, column=text.index("%") + 1)
        self._ip.state.ended = True
        if self._ip.options.stand_alone:
            raise fault
        if self._ip.dialect == "linuxcnc":
            self._ip.remark(fault, Severity.WARNING)
        self._ip.base.call("FINISH()")

    def _stands_alone(self, text: str) -> bool:
        """Tell whether a line holds % alone, or with the number of a program where LinuxCNC's interpreter is not the measure."""
        rest = text.strip()[1:].rstrip(";")
        return not rest or (rest.isdigit() and not self._ip.options.stand_alone)

    def _is_late(self, before: int) -> bool:
        """Tell whether a program has begun before the first %: a block was read, or a comment by LinuxCNC's interpreter."""
        if self._ip.options.stand_alone and self._ip.dialect == "linuxcnc":
            return self.seen or bool(self._source.data[:before].strip().strip(b"%").strip())
        return self.seen and bool(bare(self._blocks_of(before)).strip().partition(b"%")[0].strip())

    def _blocks_of(self, before: int) -> bytes:
        """Return what stands before the first %, without lines that are passed over, as those to a simulator are."""
        from cncgen.gcode.text.syntax_errors import is_passed

        lines = self._source.data[:before].partition(b"\n%")[0].split(b"\n")
        return b"\n".join(line for line in lines if not is_passed(line.decode("utf-8", "surrogateescape")))
