"""Warnings about text with another meaning on another control: one for each kind, at its first place.

The dialect's control reads these lines without a fault, and so does cncgen; but their author may have meant the other control.
"""

from __future__ import annotations

from collections.abc import Iterator

from cncgen.diagnostics import Severity
from cncgen.gcode.codes.table import BOTH, language_of
from cncgen.gcode.errors import BlockError, Reporter
from cncgen.gcode.source import MAX_LINE, Source
from cncgen.gcode.text import signs
from cncgen.gcode.text.built_patterns import compiled
from cncgen.gcode.text.dialects import Choice, different
from cncgen.gcode.text.labels import Cursor
from cncgen.gcode.text.signs import CURES, UNREAD
from cncgen.records import dataclass, replace
from cncgen.toolpath.reading import ReadOptions

TYPE_CHECKING = False
if TYPE_CHECKING:
    import mmap
    import re

#: Bytes that are searched for signs that occur early in a text, if at all.
_HEAD = 65_536
#: A line up to a word, without comments and names: that of a program may hold T12, ``<SHAFT_T12>``.
_NAMED = rb"<[^<>\n]*>"
_BEFORE = (
    rb"^(?P<before>(?:[^(;<\n]|(?>" + _NAMED + rb")|<(?!" + _NAMED[1:] + rb")|(?>" + signs.COMMENT + rb"))*?)"
)


@dataclass(frozen=True, slots=True)
class _Doubt:
    """A sign (its group ``word`` is the place), and the remark on it.

    One of `texts` stands in each such text in capitals, and `within` too; most have none, which is found sooner.
    """

    sign: bytes
    message: str
    hint: str
    texts: tuple[bytes, ...]
    within: bytes = b""

    def found(self, text: bytes, lines: bytes) -> re.Match[bytes] | None:
        """Return the first place in a text, whose different lines are given in capitals too."""
        if not any(literal in lines for literal in self.texts) or not (
            self.within == b"" or compiled(self.within).search(lines)
        ):
            return None
        import re

        return re.search(self.sign, text, re.MULTILINE | re.IGNORECASE)


_FANUC = (
    _Doubt(
        _BEFORE + rb"(?P<word>G50)[ \t]*S\d",
        "G50 ends scaling and S is the speed of the spindle; on lathes G50 S bounds the speed of G96",
        "--dialect fanuc-lathe reads lathes; on a mill G92 S bounds it",
        (b"G50",),
    ),
    _Doubt(
        _BEFORE + rb"G(?:0?[0-3]|28|30)(?![\d.])[^(;\nG]*?(?P<word>[UW])[ \t]*[-+.\d#\[]",
        "U and W are axes of their own; on lathes they are distances along X and Z",
        "--dialect fanuc-lathe reads lathes; on a mill G91 makes X and Z distances",
        (b"U", b"W"),
        rb"[UW][ \t]*[-+.\d#\[]",
    ),
)
#: On lathes: T of a tool alone.
_SHORT_T = _Doubt(
    _BEFORE + rb"(?<![A-Z])(?P<word>T[ \t]*(?:0?[1-9]|[1-9]\d)(?![\d.]))",
    "T of one or two digits is an offset alone, and the turret does not turn; controls whose T has two digits read a tool in it",
    "four digits are beyond doubt: T0101 is tool 1 with offset 1",
    (b"T",),
    rb"(?<![A-Z])T[ \t]*(?:0?[1-9]|[1-9]\d)(?![\d.])",
)
#: On lathes: a word B beside a motion, which on the controls of machines with two spindles or a tailstock is their slide's (a program of
#: a shop: ``G00 G28 B0. (SUB)``); arguments of macros are none.
_B_SLIDE = _Doubt(
    rb"^(?:(?!G6[56](?![\d.]))[^(;\n]|(?>" + signs.COMMENT + rb"))*?(?<![A-Z#<])(?P<word>B[ \t]*[-+.\d#\[])",
    "B is read as a rotary axis, in degrees; on lathes with a second spindle or a tailstock it is the slide of that, in lengths",
    "leave its words out where it is a slide: none turns then",
    (b"B",),
    rb"(?<![A-Z#<])B[ \t]*[-+.\d#\[]",
)
#: Places at most that are looked at, one by one, for a slash or a semicolon that hides words.
_LOOKED = 10_000
#: Lines with a slash after which one search of the text takes less time than a look at each: where all divide, that took half of the reading.
_MANY = 200
_LEFT_OUT = "blocks that begin with / are left out, as where the switch of block skip is on"
#: A slash that is not the first of its block, whose rest is lost.
_SLASH = _Doubt(
    rb"(?P<word>/)",
    "the rest of a block behind a slash within it is passed over; newer controls run it unless the switch of block skip is on",
    "/ stands first in a block that may be left out; a quotient stands in brackets",
    (b"/",),
)
#: A condition with words behind it, which parts of conditions, jumps and THEN are not.
_NO_THEN = _Doubt(
    _BEFORE + rb"IF[ \t]*\[[^\n]*\][ \t]*(?P<word>(?!THEN|GO|AND|OR|XOR|EQ|NE|GT|GE|LT|LE|MOD)[A-Z])",
    "words behind a condition without THEN run where it holds, as on Haas's controls; those of FANUC refuse them",
    "IF[#1 EQ 2] THEN #3=4, or IF[#1 NE 2] GOTO 10 around the block, is read by both",
    (b"IF",),
)
#: A condition with nothing behind THEN.
_THEN_ALONE = _Doubt(
    _BEFORE + rb"IF[ \t]*\[[^\n]*\][ \t]*(?P<word>THEN)[ \t]*(?:(?:" + signs.COMMENT + rb")[ \t]*)*\r?$",
    "nothing stands behind THEN: the lines below run whether the condition holds or not",
    "THEN takes one statement in its line; IF[…] GOTO 10 leads past lines where the condition holds",
    (b"THEN",),
)
#: A word T of a mill that names a tool, and what may change to it.
_TOOL = rb"(?<![A-Z#<_])T[ \t]*0*([1-9]\d{0,7})(?![\d.])"
_CHANGES = rb"M[ \t]*0*(?:6|61|9[78]|198)(?!\d)|G[ \t]*6[56](?![\d.])|CALL"
_NO_CHANGE = _Doubt(
    _TOOL,
    "T selects tools, and no M6 changes to one: the tool in the spindle stays; on machines whose T changes the tool it does not",
    "M6 behind T changes the tool",
    (b"T",),
)
_OKUMA = _Doubt(
    _BEFORE + rb"(?P<word>G1[56])[ \t]*H[ \t]*\d",
    "G15 H chooses a coordinate system on Okuma's controls, whose language is not read; here it ends polar coordinates",
    "post the program for FANUC: G54 in place of G15 H1, G43 H1 in place of G56 H1",
    (b"G15", b"G16"),
)
_LINUXCNC = (
    _Doubt(
        _BEFORE + rb"G(?:0?4|74|8[24689])(?![\d.])(?:[^(;\nG]|G9[89])*?(?P<word>P)[ \t]*\d{3,}(?![\d.])",
        "P is a dwell in seconds; FANUC's controls count it in milliseconds",
        "--dialect fanuc reads milliseconds; P0.5 waits half a second here",
        (b"P",),
        signs.LONG_WAIT,
    ),
)
#: Lines that no dialect reads; each is an error, and this remark names their language.
_SIEMENS = _Doubt(
    _BEFORE + rb"(?P<word>" + signs.WORDS_OF_SIEMENS + rb")",
    "this is of SINUMERIK's own language, of which this dialect has BSPLINE alone",
    "--dialect sinumerik reads it",
    (b"CYCLE", b"=", b"GOTO", b"MCALL", b"TRA", b"DEF"),
    signs.WORDS_OF_SIEMENS,
)
#: Lines of other controls and programs, which are passed over.
_OF_OTHERS = (
    _SIEMENS,
    _Doubt(_BEFORE + rb"[A-Z][ \t]*" + signs.SIGNED + rb"[ \t]*(?P<word>\*)[ \t]*\r?$", "blocks that end in * are of Heidenhain's DIN/ISO",
        "--dialect heidenhain reads it", (b"*",), signs.LAST_STAR),
    _Doubt(signs.TO_GRBL, "commands to grbl ($$, $H, ?, settings) are passed over: they are no blocks, and the machine is not homed here",
        "leave them out of the program", (b"$", b"?", b"~", b"!")),
    _Doubt(signs.TO_SIMULATOR, "lines to CNCSimulator ($AddRegPart, $Mill) are passed over: they lay out its picture, and no control has them",
        "the stock stands in the machine file, the tools in a tool table", (b"$",)),
    _Doubt(signs.TO_DENFORD, "lines to the simulator of Denford and Boxford ([BILLET, [TOOLDEF) are passed over",
        "the stock stands in the machine file, the tools in a tool table", (b"[BILLET", b"[EDGEMOVE", b"[TOOLDEF")),
    _Doubt(signs.OF_EDING, "messages of Eding CNC are passed over", "a message is a comment here: (MSG, change the tool)", (b'MSG "',)),
    _Doubt(signs.OF_MARLIN, "texts of M117 and M118 for the display of Marlin and its kin are passed over",
        "a message is a comment here: (MSG, job ends)", (b"M117", b"M118")),
    _Doubt(signs.WITHOUT_NUMBER, "lines of : without a number are passed over", ":1000 is the number of a program", (b"\n:", b":(", b": (")),
)  # fmt: skip
#: Lengths beyond any machine, where the text may leave out the point of thousandths.
_INCREMENTS = _Doubt(
    _BEFORE + rb"(?P<word>[XYZ][ \t]*[-+]?\d{5,9})(?![\d.])",
    "a length of five digits without a point is read as it stands; controls that count least increments take it in thousandths",
    "least_increment_mm = 0.001 under [interpreter] of the machine file reads it so; with a point it is beyond doubt",
    (b"X", b"Y", b"Z"),
    signs.LONG_LENGTHS[5],
)
#: Shorter ones, in a text of FANUC's in which no length has a point.
_NO_POINTS = replace(
    _INCREMENTS,
    sign=_BEFORE + rb"(?P<word>[XYZ][ \t]*[-+]?\d{4,9})(?![\d.])",
    message="no length has a decimal point: they are read as they stand; controls that count least increments take them in thousandths",
    within=signs.LONG_LENGTHS[4],
)
#: Those without a point beside whole numbers that end in one, which their author wrote for such controls: places, and on mills in blocks
#: of holes, rotations and arcs Q, R, I J K. X of G4 is no length, and has a warning of its own.
_NO_DWELL = rb"^(?![^(;\n]*G0?4(?![\d.]))"
_ONE_WITHOUT_POINT = replace(
    _INCREMENTS,
    sign=_NO_DWELL + _BEFORE[1:] + rb"(?P<word>[XYZ]" + signs.WHOLE + rb")",
    message="this length has no decimal point, and others end in one: it is read as it stands; controls that count least increments take it in thousandths",
    within=signs.WHOLE_WORD,
)
_ONE_OF_MILLS = replace(
    _ONE_WITHOUT_POINT,
    sign=_NO_DWELL
    + rb"(?=(?P<hole>[^(;\n]*G(?:68|7[346]|8[1-9])(?![\d.]))?)(?=(?P<arc>[^(;\n]*G0?[23](?![\d.]))?)"
    + _BEFORE[1:]
    + rb"(?P<word>[XYZ]%(whole)b|(?(hole)(?:(?<!,)R%(whole)b|Q(?=[ \t]*\d{1,2}(?!\d))%(whole)b)|(?!))|(?(arc)[IJKR]%(whole)b|(?!)))"
    % {b"whole": signs.WHOLE},
)
#: Blocks that ``;`` hides, where it stands for the end of a block as in FANUC's manuals.
_BEHIND_SEMICOLON = _Doubt(
    rb"(?P<word>;)[ \t]*(?:" + signs.BLOCK_NUMBER + rb"[ \t]*)?(?=[GMXYZFST][ \t]*[-+.\d#\[])"
    rb"(?:[A-Z][ \t]*(?>[-+.\d#]+|\[[^\n;(]*\])[ \t]*)+(?![^;(\r\n])",
    "what follows ; is a comment, and here it looks like a block",
    "each block stands in a line of its own",
    (b";",),
)


def tell(reporter: Reporter, source: Source, choice: Choice, options: ReadOptions) -> None:
    """Report the choice of the dialect, doubts about a text in it, and that some of its blocks are left out."""
    for error, severity in _remarks_on(choice):
        offset = 0
        for _ in range(choice.line - 1):
            offset = source.line_end(offset) + 1
        reporter.report(source, choice.line, offset, error, severity)
    if source.filled >= 0:
        begin = source.line_begin(source.filled)
        message = "bytes NUL or DEL amid a line are passed over, as readers of tapes do"
        hint = "where a file was damaged, they stand in place of characters: look at the numbers beside them"
        error = BlockError("tape-fillers", message, column=source.filled - begin + 1, hint=hint)
        reporter.report(source, source.data[:begin].count(b"\n") + 1, begin, error, Severity.WARNING)
    if not choice.unread:
        for here, doubt in _doubts(source, choice.dialect, options):
            reporter.report(source, here.line, here.offset, doubt, Severity.WARNING)
        if options.block_delete and (at := _left_out(source)) is not None:
            begin, hint = source.data.rfind(b"\n", 0, at) + 1, "--no-block-delete runs them"
            error = BlockError("blocks-left-out", _LEFT_OUT, column=at - begin + 1, hint=hint)
            reporter.report(source, source.data[:begin].count(b"\n") + 1, begin, error, Severity.NOTE)


def _remarks_on(choice: Choice) -> Iterator[tuple[BlockError, Severity]]:
    """Yield remarks on a dialect that signs in the text have chosen: which, why, how sure, and its rival."""
    dialect, why, rival, unread = choice.dialect, choice.reason, choice.rival, choice.unread
    if unread:
        hint = CURES.get(unread, "--dialect reads it as that of another control")
        hint = f"post the program for FANUC or LinuxCNC; {hint}"
        message = f"this is a program of {unread}, whose language is not read: {why}"
        yield (BlockError("control-unread", message, hint=hint), Severity.ERROR)
    elif why:
        yield BlockError("dialect", f"read as {dialect}: {why}", hint="--dialect overrides"), Severity.NOTE
    if rival:
        message = f"read as {dialect}, but it may as well be of {rival}, where it moves otherwise"
        hint = f"--dialect {dialect} or --dialect {rival} says which"
        if rival in UNREAD.values():
            message = f"read as {dialect}, but it may as well be of {rival}, whose language is not read, and where it moves otherwise"
            hint = f"--dialect {dialect} says that it is not"
        yield BlockError("dialect-doubtful", message, hint=hint), Severity.WARNING


def _slashes(data: mmap.mmap | bytes) -> Iterator[tuple[int, int, int]]:
    """Yield where each line with a slash begins, where its first slash stands, and where the line ends."""
    at = data.find(b"/")
    while at >= 0:
        end = data.find(b"\n", at)
        end = end if end >= 0 else len(data)
        yield data.rfind(b"\n", 0, at) + 1, at, end
        at = data.find(b"/", end)


def _left_out(source: Source) -> int | None:
    """Return the place of the first slash that begins a block, be it behind the block's number."""
    for number, (begin, at, _) in enumerate(_slashes(source.data)):
        if number == _MANY:
            found = compiled(signs.LEFT_OUT).search(source.data, begin - 1)
            return found.end() - 1 if found else None
        if compiled(signs.BEFORE_SLASH).fullmatch(source.data, begin, at):
            return at
    return None


def _cut(source: Source) -> int | None:
    """Return the place of the first slash that ends what is read of its block, looked for in the first lines that may have one."""
    data, left = source.data, _LOOKED
    for begin, at, end in _slashes(data):
        if not left:
            return None
        if end - begin <= MAX_LINE and (data[begin:at].strip() or data.find(b"/", at + 1, end) >= 0):
            from cncgen.gcode.text.grammar import cut_of

            left -= 1
            if cut := cut_of(data[begin:end]):
                return begin + cut
    return None


def _hidden(source: Source) -> int | None:
    """Return the place of the first semicolon with a block behind it that is not in a remark, looked for among the first ones."""
    import re
    from itertools import islice

    found = re.finditer(_BEHIND_SEMICOLON.sign, source.data, re.IGNORECASE)
    for at in (one.start() for one in islice(found, _LOOKED)):
        before = source.data[source.data.rfind(b"\n", max(at - MAX_LINE, 0), at) + 1 : at]
        if before.count(b"(") <= before.count(b")"):
            return at
    return None


def _unchanged(source: Source, lines: bytes) -> int | None:
    """Return the place of the second tool of a text that has no M6, and calls no other text that may have one."""
    # Most texts tell without a search.
    named = any(b"T%d" % digit in lines for digit in range(10))
    if not named or b"M6" in lines or b"M06" in lines or len(source.data) > _HEAD:
        return None
    import re

    code = compiled(signs.OUT_OF_CODE).sub(lambda match: b" " * len(match[0]), bytes(source.data).upper())
    if re.search(_CHANGES, code):
        return None
    tools = list(re.finditer(_TOOL, code))
    return next((tool.start() for tool in tools if int(tool[1]) != int(tools[0][1])), None)


def _lengths(head: bytes, lines: bytes, mill: bool) -> _Doubt:
    """Return the doubt about lengths without a point in a text of FANUC's."""
    if not compiled(signs.LENGTH_WITH_POINT).search(lines):
        return _NO_POINTS
    if not compiled(signs.WHOLE_WORD).search(lines):
        return _INCREMENTS
    if not compiled(signs.WHOLE_WITH_POINT).search(head):
        return _INCREMENTS
    return _ONE_OF_MILLS if mill else _ONE_WITHOUT_POINT


def _doubts(source: Source, dialect: str, options: ReadOptions) -> Iterator[tuple[Cursor, BlockError]]:
    head, least_increment = source.data[:_HEAD], options.least_increment
    lines, of_fanuc = different(source)[0], language_of(dialect) == "fanuc"
    asked = [*_OF_OTHERS] if language_of(dialect) in BOTH else []
    if of_fanuc and dialect != "fanuc":
        asked += [_SHORT_T] if options.kinematics is not None else [_SHORT_T, _B_SLIDE]
    asked += {"fanuc": (*_FANUC, _OKUMA), "linuxcnc": (*_LINUXCNC, _OKUMA)}.get(dialect, ())
    if language_of(dialect) in BOTH and least_increment is None:
        asked.append(_lengths(head, lines, dialect == "fanuc") if of_fanuc else _INCREMENTS)
    asked += [_NO_THEN, _THEN_ALONE] if of_fanuc else []
    unchanged = _unchanged(source, lines) if dialect in ("fanuc", "linuxcnc") else None
    found = [(doubt, match.start("word") if (match := doubt.found(head, lines)) else None) for doubt in asked]
    found.append((_NO_CHANGE, unchanged))
    if of_fanuc:
        found += [(_SLASH, _cut(source)), (_BEHIND_SEMICOLON, _hidden(source))]
        from cncgen.gcode.main_program import main_behind

        main = main_behind(source)
        if main is not None:
            yield main
    for doubt, at in found:
        if at is not None:
            begin = source.data.rfind(b"\n", 0, at) + 1
            line = source.data[:begin].count(b"\n") + 1
            column = len(source.data[begin:at].decode("utf-8", "replace")) + 1
            error = BlockError("other-control", doubt.message, column=column, hint=doubt.hint)
            yield Cursor(0, begin, line), error
