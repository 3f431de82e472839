"""Recognising the control of a program by signs in its text.

Signs are searched in blocks as controls read them: without comments, blanks and N words, so ``N01G50S600`` and ``N1 G50 S600`` are the
same. Each speaks for some dialects and against others with a weight; the weights of all are added.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from cncgen.gcode.source import Source
from cncgen.kernels.gcode_signs import different_lines
from cncgen.records import dataclass, replace

#: Bytes that are looked at, at the beginning and at the end of a text.
_HEAD = 65_536
_TAIL = 8_192
#: Leads over the next dialect: from the first on the choice is certain, from the second on it is likely and not a guess.
_CERTAIN, _LIKELY = 6.0, 3.0
#: Weight that a dialect needs to be chosen over plain G-code (a lathe, where X is a diameter), and below which the signs are weak.
_ENOUGH = dict.fromkeys(("fanuc-lathe", "fanuc-lathe-b", "fanuc-lathe-c"), 5.0)
_USUAL, _WEAK = 3.0, 6.0
#: Weight from which on a sign of lathes is of system A.
_SHARED = 10.0
#: Weight from which on a note says that a program is written for LinuxCNC.
_OWN = 20.0


@dataclass(frozen=True, slots=True)
class Choice:
    """A dialect, the signs that spoke for it (or ""), the line of the first, and the dialect that it might be as well (or "").

    `unread` names a control whose language the program is in, and which is not read; `dialect` is then only a substitute.
    """

    dialect: str
    reason: str
    line: int
    rival: str = ""
    unread: str = ""


@dataclass(frozen=True, slots=True)
class _Sign:
    """Evidence for dialects, with its weight.

    `texts`: one of them stands in each such line. Most programs have none, so that most patterns are never compiled.
    """

    reason: str
    weights: dict[str, float]
    pattern: bytes
    texts: tuple[bytes, ...]


def _sign(reason: str, weights: dict[str, float], pattern: bytes, *texts: bytes) -> _Sign:
    return _Sign(reason, weights, pattern, texts)


@dataclass(frozen=True, slots=True)
class _Lines:
    """The different lines of a text, and of each its first number and how often it stands there (`gcode_signs`)."""

    text: bytes
    numbers: list[int]
    counts: list[int]

    def search(self, pattern: bytes) -> re.Match[bytes] | None:
        """Return the first match of a pattern, which is compiled when it is looked for first."""
        return re.compile(pattern, re.MULTILINE).search(self.text)

    def number(self, match: re.Match[bytes]) -> int:
        """Return the number of the line that a match begins in, behind the end of the line before, which a sign may begin with."""
        ends = len(match[0]) - len(match[0].lstrip(b"\n"))
        return self.numbers[self.text.count(b"\n", 0, match.start() + ends)]


def _all(weight: float, *dialects: str) -> dict[str, float]:
    return dict.fromkeys(dialects, weight)


_L, _F, _T, _H, _S = "linuxcnc", "fanuc", "fanuc-lathe", "heidenhain", "sinumerik"
#: Systems B and C of G codes of FANUC's lathes: signs of lathes that only system A has count against them.
_B, _C = "fanuc-lathe-b", "fanuc-lathe-c"
#: Dialects that are read.
_READ = (_L, _F, _T, _B, _C, _H, _S)
#: Controls that are recognised and not read, and how a diagnostic calls their language.
_OKUMA, _DIN, _PRINTER, _FADAL = "okuma", "heidenhain-iso", "printer", "fadal"
_OLD_S, _MAHO, _FAGOR = "sinumerik-800", "maho", "fagor"
_NUM, _BROTHER, _EDING = "num", "brother", "eding"
UNREAD = {
    _OKUMA: "Okuma's OSP controls",
    _DIN: "Heidenhain's DIN/ISO",
    _PRINTER: "3D printers (Marlin, RepRap)",
    _FADAL: "Fadal's controls (format 1)",
    _OLD_S: "SINUMERIK 810 to 880 (system 800)",
    _MAHO: "Philips' controls (MAHO)",
    _FAGOR: "Fagor's controls (8035 to 8070)",
    _NUM: "NUM's controls",
    _BROTHER: "Brother's controls",
    _EDING: "Eding CNC",
}
#: A value behind a letter.
_V = rb"[-+.\d#\[]"
#: Signs in the original text of blocks: capitals, comments and blanks kept.
_WRITTEN = (
    _sign("the head of a file of Okuma", _all(30, _OKUMA), rb"^[ \t]*\$[\w-]+\.(?:MIN|SUB|SSB|LIB)%", b"$"),
    _sign("the head of a file of Fagor", _all(30, _FAGOR), rb"^%[^\n,]*,[ \t]*M?[ \t]*[MX][ \t]*[X-]*[ \t]*,", b",M"),
    _sign("a block of Fagor's language", _all(12, _FAGOR),
          rb"^[ \t]*(?:N\d+[ \t]*)?\((?:RET|CALL[ \t]+\d+|PCALL[ \t]+\d+[^)\n]*|RPT[ \t]+N?\d[^)\n]*|IF[ \t]+P\d+[^)\n]*)\)", b"(RET", b"CALL", b"(RPT", b"(IF"),
    _sign("the head of a file of a slicer", _all(20, _PRINTER),
          rb"^;[ \t]*(?:FLAVOR:|LAYER:|LAYER_CHANGE|GENERATED (?:WITH CURA|BY (?:PRUSA|SUPER)?SLIC3?E?R))", b";"),
    _sign("plain language", _all(30, _H), rb"^[ \t]*(?:\d+[ \t]+)?(?:BEGIN[ \t]+PGM\b|SPL[ \t]+I?[XYZ])", b"PGM", b"SPL"),
    _sign("a tool call of plain language", _all(15, _H), rb"^[ \t]*\d+[ \t]+(?:TOOL[ \t]+CALL|CYCL[ \t]+DEF|BLK[ \t]+FORM)\b", b"CALL", b"CYCL", b"FORM"),
    _sign("a line of plain language", _all(12, _H), rb"^[ \t]*\d+[ \t]+(?:L[ \t]+|CC?[ \t]+|LP?[ \t]+|FN[ \t]*\d)[^\n=]*(?:\bR[0LR]\b|F[ \t]*MAX|DR[-+]|Q\d)", b"R0", b"RL", b"RR", b"MAX", b"DR", b"Q"),
    _sign("a traverse of plain language", _all(12, _H), rb"^[ \t]*L[ \t]+[^\n=(;]*\bF[ \t]*MAX\b", b"MAX"),
    _sign("a message or print of LinuxCNC", _all(6, _L), rb"\([ \t]*(?:DEBUG|PRINT|LOGOPEN|LOGAPPEND|PROBEOPEN|AXIS)[ \t]*,", b","),
    _sign("a comment within a comment", _all(3, _F, _T), rb"\([^()\n]*\([^()\n]*\)[^()\n]*\)", b"("),
    _sign("an O-word", _all(30, _L),
          rb"^[ \t]*/?[ \t]*(?:N[ \t]*\d+[ \t]*)?O[ \t]*(?:\d+|<[^>\n]*>|\[[^\n]*?\]|#\S+?)[ \t]*(?:SUB|CALL|IF|WHILE|DO|REPEAT|RETURN|ENDSUB)\b", b"SUB", b"CALL", b"IF", b"WHILE", b"DO", b"REPEAT", b"RETURN"),
    _sign("the head of a file of SINUMERIK", _all(30, _S), rb"^[ \t]*(?:%_N_\w+_(?:MPF|SPF)\b|;\$PATH=)", b"%_N", b";$PATH"),
    _sign("a message of SINUMERIK", _all(12, _S), rb"\bMSG[ \t]*\([ \t]*[\")]", b"MSG"),
    _sign("a cycle of SINUMERIK", _all(20, _S), rb"\b(?:CYCLE\d+|POCKET\d|SLOT\d|HOLES\d|LONGHOLE|WORKPIECE|CONTPRON)[ \t]*\(", b"CYCLE", b"POCKET", b"SLOT", b"HOLE", b"WORKPIECE", b"CONTPRON"),
    _sign("a call with arguments", _all(8, _S), rb"^[ \t]*(?:N\d+[ \t]+)?[A-Z_]{3}\w*[ \t]*\((?:[-+.\w$\"]*,)+[-+.\w$\"]*\)[ \t]*(?:;[^\n]*)?$", b","),
    _sign("a step of ShopMill", _all(20, _S), rb"^[ \t]*(?:N\d+[ \t]*)?[EF]_[A-Z_]+\d*[ \t]*\(", b"E_", b"F_"),
    _sign("a definition of SINUMERIK", _all(20, _S), rb"^[ \t]*(?:N\d+[ \t]*)?(?:DEF[ \t]+(?:REAL|INT|BOOL|CHAR|STRING|AXIS|FRAME)\b|PROC[ \t]+[A-Z_]|EXTERN[ \t]+[A-Z_])", b"DEF", b"PROC", b"EXTERN"),
    _sign("a tool by its name", _all(12, _S), rb"\bT[ \t]*=[ \t]*\"", b'"'),
    _sign("a value of SINUMERIK", _all(12, _S), rb"=[ \t]*(?:AC|IC|DC|ACP|ACN)[ \t]*\(", b"="),
)  # fmt: skip
_COMMANDS = (
    b"TRAORI TRAFOOF TRANSMIT TRACYL MCALL STOPRE SUPA CFTCP CFC CFIN FFWON FFWOF SOFT BRISK COMPON COMPCAD COMPCURV COMPOF ORIWKS ORIMKS ORIAXES UPATH FIFOCTRL DIAMON DIAMOF DIAM90 CSPLINE ASPLINE RTLIOF RTLION WAITM"
).split()
#: Words of the language, which comments have as well: they are looked for beside comments alone.
_SPOKEN = (
    _sign("a jump of SINUMERIK", _all(15, _S), rb"\bGOTO[FBC]?[ \t]+[A-Z_]{2}", b"GOTO"),
    _sign("a loop or condition of SINUMERIK", _all(12, _S),
          rb"^[ \t]*(?:N\d+[ \t]*)?(?:ENDIF|ENDWHILE|ENDFOR|ENDLOOP|LOOP|REPEAT(?:[ \t]+[A-Z_]\w+)?|UNTIL[ \t(][^\n]*|FOR[ \t]+[^\n]*\bTO\b[^\n]*|(?:IF|WHILE)[ \t]*[\(A-Z$][^\[\n]*(?:==|<>|[<>])[^\n]*)[ \t]*(?:;[^\n]*)?$", b"IF", b"WHILE", b"FOR", b"LOOP", b"REPEAT", b"UNTIL"),
    _sign("a frame of SINUMERIK", _all(10, _S),
          rb"^[ \t]*(?:N\d+[ \t]*)?A?(?:TRANS|ROT|SCALE|MIRROR)(?:[ \t]+(?:[XYZ]|RPL)[ \t]*[-=.\d][^\n]*|[ \t]*(?:;[^\n]*)?)$", b"TRANS", b"ROT", b"SCALE", b"MIRROR"),
    _sign("a command of SINUMERIK", _all(10, _S),
          rb"\b(?:" + b"|".join(_COMMANDS) + rb")\b", *_COMMANDS),
)  # fmt: skip
#: Signs in bare blocks: capitals without comments, blanks, N words and the slash of blocks that may be left out.
_BARE = (
    _sign("a named parameter", _all(20, _L), rb"#<", b"#<"),
    _sign("a parameter R", _all(10, _S), rb"(?:^|[\d.)])R\d{1,3}=", b"="),
    _sign("a spindle or tool with =", _all(10, _S), rb"(?:^|[^A-Z#<])(?:LIMS|[STM]\d)=", b"="),
    _sign("tool and edge T D", _all(4, _S), rb"^T\d{1,2}D\d$", b"D"),
    _sign("an arc or axis with =", _all(8, _S), rb"(?:CR|TURN|AR|AP|RP|RND|CHF|CHR|[XYZABC]\d?|[IJK]1)=[-+.\dR(]", b"="),
    _sign("a code of SINUMERIK", _all(8, _S), rb"(?<![A-Z_])G(?:500|50[5-9]|5[1-9]\d|64[1-5]|60[1-3]|45[01]|291)(?![\d.])", b"G5", b"G6", b"G45", b"G29"),
    _sign("a turning cycle of LinuxCNC", _all(12, _L), rb"^[^\n]*G7[012](?:\.[12])?(?=[^\n]*Q\d)(?!P\d+Q)(?![^\nQ]*P\d)[^\n]*[DIQRXZ]", b"G7"),
    _sign("a threading cycle of LinuxCNC", _all(12, _L), rb"G76(?=[^\n]*I)(?=[^\n]*J)(?=[^\n]*K)", b"G76"),
    _sign("G7 or G8 alone", _all(6, _L), rb"G0?[78](?![\d.PX-Z])", b"G7", b"G8", b"G07", b"G08"),
    _sign("G96 D S", _all(8, _L), rb"G96(?:S[.\d]+)?D", b"G96"),
    _sign("a tolerance G64 P", _all(6, _L), rb"G64P", b"G64P"),
    _sign("a code of LinuxCNC alone", _all(8, _L), rb"G(?:0?5\.[23]|33\.1|38\.[2-5]|43\.2|92\.[23]|59\.[123]|41\.1|42\.1)(?!\d)", b"5.2", b"5.3", b"33.1", b"38.", b"43.2", b"92.", b"59.", b"41.1", b"42.1"),
    _sign("exact path G61.1", _all(4, _L), rb"G61\.1(?!\d)", b"G61.1"),
    _sign("a centre mode", _all(4, _L), rb"G9[01]\.1(?!\d)", b".1"),
    _sign("an output code", _all(3, _L), rb"(?<![A-Z_])M6[2-8][PE]", *(b"M%d" % number for number in range(62, 69))),
    _sign("a thread by G33 K", _all(4, _L), rb"G33[^\n]*K" + _V, b"G33"),
    _sign("a dwell with a decimal point", _all(3, _L), rb"G0?4P\d*\.\d", b"P"),
    # Of controls that are not read.
    _sign("a coordinate system by G15 H or G16 H", _all(20, _OKUMA), rb"(?<![A-Z_])G1[56]H\d", b"G15H", b"G16H"),
    _sign("a variable of Okuma", _all(15, _OKUMA), rb"(?<![A-Z])V(?:C\d+|S\d+|ZOF[XYZC]|ETF|TOFH|TLN)(?:\[\d+\])?=", b"="),
    _sign("a tool length by G56 H", _all(6, _OKUMA), rb"(?<![A-Z_])G56(?![\d.])(?:[XYZ][-+.\d]+)?H\d", b"G56"),
    _sign("a word of Okuma", _all(15, _OKUMA), rb"^(?:NOEX|MODIN|MODOUT|CALLO[A-Z0-9]+|N(?:LAP|CYL|AT)\d*(?=[GX-Z]))",
          b"NOEX", b"MOD", b"CALLO", b"NLAP", b"NCYL", b"NAT"),
    _sign("a contour of LAP", _all(20, _OKUMA), rb"(?<![A-Z_])G8[567]N[A-Z]", b"G85N", b"G86N", b"G87N"),
    _sign("a tool of six digits", _all(4, _OKUMA), rb"(?:^|[^A-Z#<])T\d{6}(?!\d)", b"T"),
    _sign("a block that ends in *", _all(20, _DIN), rb"^[^\n]*[A-Z][-+]?[.\d]+\*$", b"*"),
    _sign("a head with G70 or G71", _all(12, _DIN), rb"^%\w+?G7[01]\*?$", b"G70", b"G71"),
    _sign("an extruder", _all(8, _PRINTER), rb"^G0?[01](?=[XYZF])[^\n]*E-?[.\d]", b"E"),
    _sign("an extruder set to 0", _all(12, _PRINTER), rb"^G92E0", b"G92E"),
    _sign("a value in braces", _all(12, _PRINTER), rb"(?<![A-Z_])[EFXYZ]\{[^\n]*\}", b"{"),
    _sign("a temperature", _all(10, _PRINTER), rb"^M(?:104|109|140|190)S\d", b"M1"),
    _sign("a fixture offset E", {_FADAL: 12}, rb"^(?:G\d+(?:\.\d)?)*X[-+.\d]+Y[-+.\d]+E\d{1,2}(?:[MZ][-+.\d]+)*$", b"E"),
    _sign("a tool length by H alone", {_FADAL: 6}, rb"^(?:G90)?H\d{1,2}Z[-+.\d]+$|^(?:G90)?E0X", b"H", b"E0"),
    _sign("a command @ of SINUMERIK's system 800", {_OLD_S: 12}, rb"(?:^|\d)@\d{3}(?:[RKP]|$)", b"@"),
    _sign("the head of a file of SINUMERIK's system 800", {_OLD_S: 12}, rb"^%(?:MPF|SPF)\d+$", b"%MPF", b"%SPF"),
    _sign("the head of a file of Philips' controls", {_MAHO: 30}, rb"^%PM\d*$", b"%PM"),
    _sign("a call of NUM by G77", {_NUM: 20}, rb"(?<![A-Z_])G77(?:H\d|N\d+(?:N\d|S\d|$))", b"G77"),
    _sign("a jump of NUM by G79", {_NUM: 15}, rb"(?<![A-Z_])G79(?:[LE]\d+[=<>][^N\n]*)?N\d", b"G79"),
    _sign("a parameter of NUM", {_NUM: 12}, rb"^(?:L\d{1,3}|E[1-9]\d{4})=", b"="),
    _sign("a tool axis of NUM", {_NUM: 15}, rb"(?<![A-Z_])G16[PQR][-+](?=[A-Z]|$)", b"G16"),
    _sign("a cycle's approach by ER", {_NUM: 12}, rb"(?<![A-Z_])G8[1-9](?![\d.])[^\n]*E[RH][-+.\d]", b"G8"),
    _sign("tool and edge T D before M6", {_NUM: 3}, rb"^T\d+D\d+M0?6(?!\d)", b"M6", b"M06"),
    _sign("machine coordinates of NUM by G52", {_NUM: 6}, rb"(?<![A-Z_])(?:G0?[01]G52|G52G0?[01](?![\d.])|G52Z[-+.\d]+(?:[MD]\d+)*$)", b"G52"),
    _sign("a program number behind % alone", {_NUM: 4}, rb"^%\d{1,5}$", *(b"%%%d" % digit for digit in range(10))),
    _sign("a tool change of Brother by G100", {_BROTHER: 20}, rb"(?<![A-Z_])G100T\d", b"G100T"),
    _sign("a loop or condition of Eding CNC", {_EDING: 20}, rb"^(?:WHILE|IF)\[[^\n]*\]$", b"ENDWHILE", b"ENDIF"),
    # Of FANUC, mill or lathe.
    _sign("two tools before M6", _all(8, _F), rb"T\d+T\d+M0?6(?!\d)", b"M6", b"M06"),
    _sign("a program number", _all(8, _F, _T), rb"^%?[O:]\d{1,8}$", b"O", b":"),
    _sign("a program number behind %", _all(4, _F, _T), rb"^%\d{1,8}$", *(b"%%%d" % digit for digit in range(10))),
    _sign("a program name", _all(8, _F, _T), rb"^O?<[^>\n]*>$", b"<"),
    _sign("a jump of a macro", _all(12, _F, _T), rb"GOTO[\d#\[]", b"GOTO"),
    _sign("a loop of a macro", _all(12, _F, _T), rb"^(?:WHILE\[[^\n]*\]DO|DO[123]$|END[123]$)", b"WHILE", b"DO", b"END"),
    _sign("a condition of a macro", _all(12, _F, _T), rb"^IF\[[^\n]*\](?:THEN|GOTO)", b"IF["),
    _sign("a sum without brackets", _all(8, _F, _T), rb"#\d+=[#\d.][#\d.]*[-+*/][#\d\[]", b"="),
    _sign("a function without brackets", _all(6, _F, _T), rb"#\d+=-?(?:SQRT|SIN|COS|TAN|ABS|ROUND|FIX|FUP)\[[^\n]*\][-+*/]", b"["),
    _sign("an output command of a macro", _all(12, _F, _T), rb"^(?:POPEN|PCLOS|[BD]PRNT)", b"POPEN", b"PCLOS", b"PRNT"),
    _sign("an alarm of a macro", _all(6, _F, _T), rb"#300[06]=", b"#300"),
    _sign("a macro call", _all(10, _F, _T), rb"(?<![A-Z_])G6[56]P", b"P"),
    _sign("a look-ahead code", _all(8, _F, _T), rb"(?<![A-Z_])G0?(?:5\.1Q|5P(?:10000|0|1|2)$|8P)|G(?:103|187)[PE]", b"5.1Q", b"5P", b"8P", b"G103", b"G187"),
    _sign("a dwell of X", _all(8, _F, _T), rb"(?<![A-Z_])G0?4X\.?\d", b"4X"),
    _sign("a dwell in milliseconds", _all(4, _F, _T), rb"(?<![A-Z_])G0?4P[1-9]\d\d+$", b"4P"),
    _sign("a code of Haas", _all(8, _F, _T), rb"G154P|(?<![A-Z_])M97P", b"G154P", b"M97P"),
    _sign("rigid tapping by M29", _all(4, _F, _T), rb"(?<![A-Z_])M29(?!\d)", b"M29"),
    _sign("a chamfer or rounding", _all(8, _F, _T), rb",[CR]" + _V, b","),
    _sign("a reference point beside a motion code", _all(4, _F, _T),
          rb"^[^\n]*(?<![A-Z_])G0?[0-3](?![\d.])[^\n]*G(?:28|30)(?![\d.])", b"G28", b"G30"),
    _sign("a call of M98", _all(3, _F, _T), rb"M98P\d", b"M98P"),
    _sign("calls of M98 with their count", _all(3, _F, _T), rb"M98P\d{5,8}(?![\d.])", b"M98"),
    _sign("a block left out by a numbered switch", _all(4, _F, _T), rb"^\x00[2-9]", b"\x00"),
    # Of FANUC's mills.
    _sign("a mirror, rotation, scaling or polar code", {_F: 10, _T: 2},
          rb"(?<![A-Z_])G(?:51\.1|68(?:\.2)?|51|16)(?![\d.])|^G(?:50\.1|69|15)(?![\d.])", b"G50.1", b"G51", b"G68", b"G69", b"G15", b"G16"),
    _sign("a code of FANUC's mills", {_F: 10, _T: 4}, rb"G(?:43\.4(?!\d)|54\.1P|54P\d|10L1[23](?!\d))", b"G43.4", b"G54", b"G10L1"),
    _sign("a spindle's bound by G92 S", {_F: 4, _B: 8}, rb"(?<![A-Z_])G92S", b"G92S"),
    _sign("tool lengths G43 H", {_F: 1, _L: 1, _T: -12}, rb"G43(?![\d.])[^\n]*H\d", b"G43"),
    _sign("words of Y", {_T: -5}, rb"Y" + _V, b"Y"),
    _sign("a cycle of mills", {_T: -4}, rb"(?<![A-Z_])G8[1-9](?![\d.])[^\n]*[XYZ]" + _V, b"G8"),
    _sign("a tool change M6", {_T: -4}, rb"(?<![A-Z_])M0?6(?!\d)", b"M6", b"M06"),
    # Of FANUC's lathes, systems B and C.
    _sign("a turning pass by G77 or G79", {_B: 12}, rb"^G7[79][XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GYPQ\n]*$", b"G7"),
    _sign("a threading pass by G78", {_B: 12}, rb"^G78[XU]" + _V + rb"[^GYPQ\n]*F", b"G78"),
    _sign("a turning pass by G20 or G24", {_C: 10}, rb"^G2[04][XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GY\n]*F[^GY\n]*$", b"G20X", b"G20U", b"G24X", b"G24U"),
    _sign("a threading pass by G21", {_C: 10}, rb"^G21[XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GY\n]*F[^GY\n]*$", b"G21X", b"G21U"),
    _sign("a thread of a lathe by G78", {_C: 20}, rb"(?<![A-Z_])G78P\d{5,6}(?![\d.])", b"G78P"),
    _sign("finishing by G72 P Q", {_C: 14, _T: -12}, rb"^G72P\d+Q\d+$", b"G72P"),
    # Of FANUC's lathes, system A.
    _sign("a bound of the spindle's speed by G50", {_T: 20}, rb"(?<![A-Z_])G50S[\d#\[]", b"G50S"),
    _sign("a turning cycle of lines P to Q", {_T: 20}, rb"(?<![A-Z_])G7[0-3]P\d+Q\d+(?![\d.])", b"P"),
    _sign("a turning cycle in two blocks", {_T: 12}, rb"^G7[12][UW][.\d]+R[.\d]+(?:[FST][.\d]+)*$", b"G7"),
    _sign("a thread of a lathe", {_T: 20}, rb"(?<![A-Z_])G76P\d{5,6}(?![\d.])", b"G76P"),
    _sign("a reference point by distances U W", {_T: 20}, rb"G(?:28|30)(?:G[\d.]+)?U0?\.?0*W0?\.?0*(?![\d.])", b"W"),
    _sign("a reference point by a distance U", {_T: 6}, rb"G(?:28|30)U0?\.?0*(?![\d.])", b"U"),
    _sign("a dwell of U", {_T: 8, _F: 2}, rb"(?<![A-Z_])G0?4U\.?\d", b"4U"),
    _sign("a threading pass by G92 with F", {_T: 8}, rb"^(?![^\n]*Y)[^\n]*(?<![A-Z_])G92[XUZW][^\n]*F", b"G92"),
    _sign("a thread by G32", {_T: 6}, rb"(?<![A-Z_])G32[^\nY]*[XZUW][^\n]*F", b"G32"),
    _sign("a turning pass by G90 or G94", {_T: 4}, rb"^G9[04][XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GY\n]*$", b"G90X", b"G90U", b"G94X", b"G94U"),
    _sign("tool and offset in four digits of T", {_T: 5}, rb"(?:^|[^A-Z#<])T(?:0[1-9]|[1-9]\d)(?:0[1-9]|[1-9]\d)(?!\d)", b"T"),
    _sign("tool and offset in three digits of T", {_T: 3}, rb"(?:^|[^A-Z#<])T([1-9])0\1(?!\d)", b"T"),
    _sign("polar coordinate interpolation of lathes", {_T: 12, _F: 4}, rb"(?<![A-Z_])G1(?:12|2\.1)(?!\d)", b"G112", b"G12.1"),
    _sign("cylindrical interpolation", {_T: 8, _F: 6}, rb"(?<![A-Z_])G(?:107|0?7\.1)[AC]", b"G107", b"7.1"),
    _sign("distances U W beside X Z", {_T: 5},
          rb"^(?![^\n]*[YVPQ])(?![^\n]*G(?:0?4|10|28|30|50|92|7\d)(?!\d))(?:[^\n]*[XZ]" + _V + rb"[^\nXZUW]*[UW]|[^\n]*[UW]"
          + _V + rb"[^\nXZUW]*[XZ])" + _V, b"U", b"W"),
    _sign("surface speed by G96", {_T: 3, _L: 1}, rb"(?<![A-Z_])G96S", b"G96"),
)  # fmt: skip
_CYCLES = rb"(?<![A-Z_])G(?:8[1-9]|7[346])(?!\d)"
_HOLES = rb"(?<![A-Z_])G8[1-9](?!\d)"
_A_TURN = rb"(?<![A-Z_])G95(?![\d.])"
_RETRACTS = rb"(?<![A-Z_])G99(?![\d.])"
_ARC_IN_XZ = rb"^[^\n]*G0?[23](?![\d.])[^\nK]*[XZUW]" + _V + rb"[^\nK]*K" + _V
_PLANE = rb"G1[789](?![\d.])"
_FEEDS = rb"F(\d*\.?\d+)"
_OTHER_FEEDS = rb"(?<![A-Z_])G(?:20|70|93|95|9[45]|32|33|84|74)(?![\d.])"
_X_AND_Z = rb"[XU]" + _V + rb"[^\n]*[ZW]" + _V + rb"|[XZ]" + _V
_COMMENTS = rb"\((?:[^()\n]|\([^()\n]*\))*\)|;[^\n]*"
#: A comment, no arguments of a name: ``( ... )`` behind a blank or at the beginning, and what follows ``;``.
_REMARKS = rb"(?m:^|(?<=[ \t]))\([^)\n]*\)|;[^\n]*"
_BLANKS = b" \t\r"
_NUMBERS = rb"(?m:^)(?=[/N])(?:/([1-9]?))?(?:N\d+(?:\.\d*)?)?(?:/([1-9]?))?"


def chosen(source: Source, dialect: str) -> Choice:
    """Return the requested dialect, or with ``auto`` that of the text."""
    return choose(source) if dialect == "auto" else Choice(dialect, "", 1)


def bare(text: bytes) -> bytes:
    """Return a text in capitals, line by line, without comments, blanks and N words.

    A slash with a number, ``/2``, is a NUL and the number.
    """
    blocks = re.sub(_COMMENTS, b"", text.upper()).translate(None, _BLANKS)
    return re.sub(_NUMBERS, lambda m: b"\x00" + (m[1] or m[2]) if m[1] or m[2] else b"", blocks)


def choose(source: Source) -> Choice:
    """Return the dialect that the signs in a text speak for; without any sign, LinuxCNC's."""
    head = source.data[:_HEAD]
    if len(source.data) > _HEAD:
        head += source.data[max(_HEAD, len(source.data) - _TAIL) :]
    written = _Lines(*different_lines(head))
    blocks = _blocks(written)
    found = [
        *_found(_WRITTEN, written),
        *_found(_SPOKEN, replace(written, text=re.sub(_REMARKS, b"", written.text))),
        *_found(_BARE, blocks),
        *_of_feeds(blocks),
        *_of_name(source.name),
    ]
    totals = dict.fromkeys((*_READ, *UNREAD), 0.0)
    for _, weights, _ in found:
        for dialect, weight in weights.items():
            totals[dialect] += weight
    return _decided(found, totals)


def _blocks(written: _Lines) -> _Lines:
    """Return the different lines of a text as bare blocks; without N words, more lines are the same."""
    text, numbers, counts = different_lines(bare(written.text), written.counts)
    return _Lines(text, [written.numbers[number - 1] for number in numbers], counts)


_Found = tuple[str, dict[str, float], int]


def _found(signs: Iterable[_Sign], lines: _Lines) -> Iterable[_Found]:
    """Yield the signs that a text has: reason, weights, line."""
    for sign in signs:
        if sign.texts and not any(literal in lines.text for literal in sign.texts):
            continue
        match = lines.search(sign.pattern)
        if match:
            yield sign.reason, sign.weights, lines.number(match)


def _of_name(name: str) -> Iterable[_Found]:
    """Yield the signs of a file's suffix: SINUMERIK's programs are .mpf and .spf."""
    if name.lower().endswith((".mpf", ".spf")):
        yield "the suffix of SINUMERIK's programs", {_S: 4.0}, 1


def _of_feeds(blocks: _Lines) -> Iterable[_Found]:
    """Yield the signs of feeds and their modes: below 1 they are a revolution's, G99 without cycles says so too."""
    mode = blocks.search(_RETRACTS) if b"G99" in blocks.text else None
    if mode and not blocks.search(_CYCLES):
        yield "G99 without cycles of mills", {_T: 3.0}, blocks.number(mode)
    if b"Y" in blocks.text:
        return
    feed = blocks.search(_A_TURN) if b"G95" in blocks.text else None
    if feed and not blocks.search(_HOLES):
        yield "feeds a revolution by G95", {_B: 4.0, _C: 4.0, _L: 2.0}, blocks.number(feed)
    arc = blocks.search(_ARC_IN_XZ) if b"K" in blocks.text and b"J" not in blocks.text else None
    if arc and not blocks.search(_PLANE):
        yield "an arc in X and Z without a plane", {_T: 8.0}, blocks.number(arc)
    if b"F" not in blocks.text:
        return
    first = blocks.search(_FEEDS)
    if first is None or blocks.search(_OTHER_FEEDS) or not blocks.search(_X_AND_Z):
        return
    feeds = sorted(
        float(feed)
        for line, count in zip(blocks.text.split(b"\n"), blocks.counts, strict=True)
        for feed in count * re.findall(_FEEDS, line)
    )
    if 0.0 < feeds[len(feeds) // 2] < 1.0:
        yield "feeds below 1", {_T: 4.0}, blocks.number(first)


def _decided(found: list[_Found], totals: dict[str, float]) -> Choice:
    """Return the dialect of the greatest weight, its signs, and the next dialect if it is close."""
    own = {dialect for _, weights, _ in found for dialect in (_B, _C) if weights.get(dialect, 0.0) > 0.0}
    for dialect in own:
        # The signs of all lathes, which are less than those that system A alone has.
        shared = (w[_T] for _, w, _ in found if w.get(_T, math.inf) < _SHARED and dialect not in w)
        totals[dialect] += sum(shared)
    for dialect in {_B, _C} - own:
        totals[dialect] = -math.inf
    # At the same weight: LinuxCNC before FANUC, mills before lathes.
    order = sorted(totals, key=lambda dialect: -totals[dialect])
    best, second = order[0], order[1]
    if best in UNREAD and totals[best] >= _OWN / 2.0:
        reasons = _reasons(found, best)
        text = ", ".join(reason for reason, _ in reasons[:3])
        return Choice(_F, text, reasons[0][1], unread=UNREAD[best])
    order = [dialect for dialect in order if dialect in _READ]
    best, second = order[0], order[1]
    if best in (_L, _F) and totals[best] <= 0.0:
        return Choice(_L, "", 1)
    if totals[best] < _ENOUGH.get(best, _USUAL):
        reasons = _reasons(found, best)
        return Choice(_L, "", reasons[0][1] if reasons else 1, best if best != _L else "")
    lead = totals[best] - totals[second]
    if {best, second} == {_F, _T} and not any(w.get(second, 0.0) > w.get(best, 0.0) for _, w, _ in found):
        # Nothing speaks for the other of FANUC's two that does not speak for this one.
        rest = max(totals[dialect] for dialect in order[2:])
        lead = totals[best] - rest
    sure = "certain" if lead >= _CERTAIN else "likely" if lead >= _LIKELY else "a guess"
    reasons = _reasons(found, best)
    more = f" and {len(reasons) - 3} more" if len(reasons) > 3 else ""
    text = ", ".join(reason for reason, _ in reasons[:3]) + f"{more} ({sure})"
    rival = second if lead < _LIKELY and totals[second] > 0.0 else ""
    if best == _T and totals[best] < _WEAK and not rival:
        rival = _L
    if best == _L and not rival and totals[best] < _OWN:
        # A text without signs is read as LinuxCNC's without a note.
        text = ""
    return Choice(best, text, reasons[0][1] if reasons else 1, rival)


def _reasons(found: list[_Found], dialect: str) -> list[tuple[str, int]]:
    """Return the signs that speak for a dialect and their lines, the heaviest first."""
    own = [
        (reason, weights[dialect], line) for reason, weights, line in found if weights.get(dialect, 0.0) > 0.0
    ]
    return [(reason, line) for reason, _, line in sorted(own, key=lambda sign: -sign[1])]
