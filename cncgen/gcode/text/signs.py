"""Signs by which the control of a program is recognised: the name of each, the control that it speaks for, and how to find it.

`cncgen.gcode.text.dialects` weighs them.
"""

from __future__ import annotations

from cncgen.grammars.terminals import FANUC, HEIDENHAIN, LINUXCNC, SINUMERIK

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator

#: Evidence for dialects: its name, its weights, the pattern of its lines, and texts one of which stands in each such line.
#: Most programs have none, so that most patterns are never compiled. (Records of as many take twice as long to make.)
Sign = tuple[str, dict[str, float], bytes, tuple[bytes, ...]]


def _sign(reason: str, weights: dict[str, float], pattern: bytes, *texts: bytes) -> Sign:
    return reason, weights, pattern, texts


def _all(weight: float, *dialects: str) -> dict[str, float]:
    return dict.fromkeys(dialects, weight)


_L, _F, _T, _H, _S = "linuxcnc", "fanuc", "fanuc-lathe", "heidenhain", "sinumerik"
#: Systems B and C of G codes of FANUC's lathes: signs of lathes that only system A has count against them.
_B, _C = "fanuc-lathe-b", "fanuc-lathe-c"
READ = (_L, _F, _T, _B, _C, _H, _S)
#: Terminals of the grammar: a number, a comment with those within it, and a block's number as signs have it, in capitals.
_TERMINALS = {name.encode(): pattern.encode() for name, pattern in FANUC.items()}
_NUMBER, COMMENT = _TERMINALS[b"NUMBER"], _TERMINALS[b"COMMENT"]
#: A comment, or the rest of a line behind a parenthesis that nothing closes.
OUT_OF_CODE = COMMENT + rb"|\(.*"
BLOCK_NUMBER = _TERMINALS[b"LINE_NUMBER"].upper()
_BLOCK, _REMARK = HEIDENHAIN["BLOCK_NUMBER"].encode(), SINUMERIK["COMMENT"].encode()
#: How a value behind a letter begins, a number with its sign, one with a point, and what stands before a block or a word of its own.
_V = rb"[-+.\d#\[]"
SIGNED = rb"[-+]?(?:" + _NUMBER + rb")"
_WITH_POINT = rb"(?!\d+(?![\d.]))(?:" + _NUMBER + rb")"
_AT = rb"^[ \t]*(?:" + BLOCK_NUMBER + rb"[ \t]*)?"
_W = rb"(?<![A-Z_])"
OF_HAAS = rb"G154P|(?<![A-Z_])(?:M97P|G(?:103|187)[PE]|G(?:234|25[45])(?!\d))"
#: The text before a word outside comments, which begin with ``(`` or ``;`` in all languages.
_SAID = rb"^[^;(\n]*\b"
#: Controls that are recognised and not read, and how a diagnostic calls their language.
UNREAD = {
    "accutex": "AccuteX's and other wire EDM machines",
    "acramatic": "Cincinnati's Acramatic, or of a post that numbers blocks by a colon as NX's generic ones do",
    "amada": "Amada's punch presses",
    "anilam": "Anilam's conversational controls",
    "apt": "APT (CLDATA)",
    "boss": "Bridgeport's BOSS controls",
    "brother": "Brother's controls",
    "centroid": "Centroid's controls",
    "citizen": "Swiss lathes with a program for each path (Citizen, Star, Tsugami)",
    "cncjs": "CNCjs's macros",
    "ddcs": "DDCS controls (Digital Dream)",
    "dynapath": "Dynapath's Delta controls",
    "eding": "Eding CNC (USBCNC)",
    "emco": "EMCO's Compact 5 and TM02",
    "excellon": "Excellon's drills of printed boards",
    "fadal": "Fadal's controls",
    "fagor": "Fagor's controls (8035 to 8055)",
    "hnc": "Huazhong's HNC controls",
    "hpgl": "plotters (HP-GL)",
    "integrex": "Mazak's INTEGREX and other turning centres with milling",
    "isel": "isel's controls (NCP)",
    "isg": "Fagor's controls (8060 to 8070), or ISG's (Beckhoff)",
    "lnc": "LNC's controls (SYIL)",
    "maho": "Philips' controls (MAHO, Deckel)",
    "nccad": "nccad's controls",
    "num": "NUM's controls",
    "okuma": "Okuma's OSP controls",
    "osai": "OSAI's controls",
    "rexroth": "Bosch's and Rexroth's controls",
    "pal": "PAL (German examinations)",
    "pilot": "Heidenhain's lathe controls (CNC PILOT, MANUALplus)",
    "planetcnc": "PlanetCNC's macros",
    "printer": "3D printers (Marlin, RepRap)",
    "roland": "Roland's milling machines (RML-1)",
    "shopbot": "ShopBot's routers",
    "sinumerik-800": "SINUMERIK 810 to 880 (system 800)",
    "sodick": "Sodick's wire EDM machines",
    "syntec": "Syntec's macros",
    "tinyg": "TinyG and g2core (JSON)",
}
#: What else helps than another post, for some of them.
_COLONS = "where the rest is LinuxCNC's or FANUC's, write N for the colon of its block numbers"
CURES = {UNREAD["acramatic"]: _COLONS}


def _of(control: str, weight: float, reason: str, pattern: bytes, *texts: bytes) -> Sign:
    return reason, {control: weight}, pattern, texts


_ELSEWHERE = (
    _of("accutex", 45, "a condition of discharge", rb"^[ \t]*E\d{3}[ \t]*=[ \t]*\d+[ \t]+\d", b"="),
    _of("acramatic", 20, "a block that begins with :", rb"^:[ \t]*(?:" + BLOCK_NUMBER + rb"|\d+)?[ \t]*[GTMXYZ][ \t]*\d", b":"),
    _of("cncjs", 20, "a line of CNCjs", rb"^[ \t]*%(?:WAIT\b|[A-Z_]\w*[ \t]*=[^=])", b"%WAIT", b"%"),
    _of("acramatic", 15, "the name of a program of Acramatic", rb"^\(ID,[ \t]*PROG", b"(ID,"),
    _of("anilam", 20, "a line of Anilam", rb"^[ \t]*(?:(?:RAPID|LINE|ARC)[ \t]+(?:CC?W[ \t]+)?[XYZ][ \t]*[-+.\d]|DIM[ \t]+(?:ABS|INCR)|TOOL#)", b"RAPID", b"LINE", b"ARC", b"DIM", b"TOOL#"),
    _of("apt", 20, "a statement of APT", rb"^[ \t]*(?:PARTNO|GOTO|GODLTA|LOADTL|FEDRAT|SPINDL|UNITS|MULTAX)[ \t]*/", b"/"),
    _of("centroid", 20, "a command of Centroid", _AT + rb"(?:M(?:94|95|100|101|115|116|125|126)[ \t]*/[XYZ\d]|M22[345][ \t]+#\d+[ \t]+\")", b"/", b'"'),
    _of("centroid", 12, "conditions joined by || or &&", _AT + rb"IF[ \t][^\n]*(?:\|\||&&)[^\n]*THEN", b"||", b"&&"),
    _of("centroid", 20, "the name of FreeCAD's post", rb"^[ \t]*[;(][ \t]*POST PROCESSOR:[ \t]*CENTROID_POST", b"CENTROID_POST"),
    _of("ddcs", 45, "a condition of DDCS", _AT + rb"(?:IF|WHILE)[ \t]*#[^\n;(]*[=<>][^\n;(]*(?:GOTO|DO)[ \t]*\d", b"IF", b"WHILE"),
    # A text to the operator (#1503, #1505), and a number that he is asked for, which goes to the variable #50 to #499 that is named.
    _of("ddcs", 30, "a dialog of DDCS", _AT + rb"#(?:150[35][ \t]*=[ \t]*-?\d+|2070[ \t]*=[ \t]*(?:[5-9]\d|[1-4]\d\d))[ \t]*\(", b"#150", b"#2070"),
    _of("dynapath", 20, "a block of Dynapath", rb"^" + BLOCK_NUMBER + rb"\([\dA-Z]\)[^\n]*\$[ \t\r]*$", b"$"),
    _of("eding", 30, "a macro of Eding CNC", rb"^[ \t]*(?:(?:GOSUB|SUB)[ \t]+[A-Z_]|ENDSUB|(?:DLGMSG|ERRMSG)[ \t]+\")", b"GOSUB", b"SUB", b"MSG"),
    _of("emco", 20, "columns N G X Z", rb"^[ \t]+N[ \t]+G[ \t]+X[ \t]+(?:Y[ \t]+)?Z[ \t]+F", b"N G", b"N  ", b"N \t", b"N\t"),
    _of("excellon", 20, "the unit of a drill file", rb"^(?:METRIC|INCH)(?:,[LT]Z)?(?:,0+\.0+)?[ \t\r]*$|^FMAT,[12]", b"METRIC", b"INCH", b"FMAT"),
    _of("fadal", 20, "a line of Fadal's macros", rb"^[ \t]*#(?:V\d+[ \t]*=|R\d[ \t]*=|IF[ \t]*\(|(?:WAIT|S?PRINT|INPUT|GOTO)\b|:[A-Z])",
        b"#V", b"#R", b"#IF", b"#WAIT", b"#PRINT", b"#SPRINT", b"#INPUT", b"#GOTO", b"#:"),
    _of("fagor", 30, "the head of a file of Fagor", rb"^%[^\n,]*,[ \t]*M?[ \t]*[MX][ \t]*[X-]*[ \t]*,", b"%"),
    _of("fagor", 12, "a block of Fagor's language", _AT + rb"\((?:RET|GOTO[ \t]+" + BLOCK_NUMBER + rb"|CALL[ \t]+\d+|PCALL[ \t]+\d+[^)\n]*|RPT[ \t]+(?:" + BLOCK_NUMBER + rb"|\d)[^)\n]*|IF[ \t]+P\d+[^)\n]*)\)", b"(RET", b"GOTO", b"CALL", b"(RPT", b"(IF"),
    _of("fagor", 8, "an assignment of P in parentheses", _AT + rb"\(P\d+[ \t]*=[ \t]*[-+P]?(?:" + _NUMBER + rb")(?:[ \t]*[-+*/][ \t]*P?(?:" + _NUMBER + rb"))*\)[ \t\r]*$", b"(P"),
    _of("hpgl", 20, "a command of HP-GL", rb"^(?:IN;|[^\n]*;P[UD][-\d;])", b"IN;", b";PU", b";PD"),
    _of("isel", 20, "a command of isel", rb"^[ \t]*(?:IMF_PBL|(?:FAST|MOVE)(?:ABS|REL)[ \t]+[XYZ])", b"IMF_PBL", b"ABS", b"REL"),
    _of("isg", 20, "a statement with $", _AT + rb"\$(?:IF|ELSE|ELSEIF|ENDIF|FOR|ENDFOR|WHILE|ENDWHILE|SWITCH|ENDSWITCH|CASE|GOTO|DO|ENDDO)\b", b"$"),
    _of("isg", 20, "a command with #", _AT + rb"#[A-Z]{2,}(?:[ \t]+[A-Z]+)*[ \t]+(?:ON|OFF|DEF|SELECT)\b", b"#"),
    _of("isg", 20, "a variable V", rb"(?<![A-Z_.])V\.[APLGESICB]{1,3}\.", b"V."),
    _of("lnc", 45, "a command of LNC", rb"^[ \t]*(?:MSG_OK|MENU(?:_ADD)?|ALARM)\[\"|=[ \t]*(?:INPUT\[\"|R_[A-Z_]+\[)|\[R_[A-Z_]+\[|\bG65[ \t]*\"(?![^\"\n]*\.CNC\")",
        b"MSG_OK[", b"MENU", b"ALARM[", b"INPUT[", b"R_", b'"'),
    _of("nccad", 20, "the name of FreeCAD's post", rb"^[ \t]*[;(][ \t]*POST PROCESSOR:[ \t]*NCCAD_POST", b"NCCAD_POST"),
    _of("nccad", 12, "a switch of a port", rb"^M10[ \t]+O\d\.[01]\b", b"M10"),
    _of("okuma", 30, "the head of a file of Okuma", rb"^[ \t]*\$[\w-]+\.(?:MIN|SUB|SSB|LIB)%", b"$"),
    _of("osai", 20, "a command of three letters", _AT + rb"\((?:UAO|UOT|UIO|URT|UGS|RPT|CLS|EPP|SCF|MIR|ROT|GTO|DLY)[ \t]*,[^)\n]*\)[ \t\r]*$", b"(U", b"(RPT", b"(CLS", b"(EPP", b"(SCF", b"(MIR", b"(ROT", b"(GTO", b"(DLY"),
    _of("planetcnc", 75, "a dialogue of PlanetCNC", rb"^[ \t]*\((?:DLG[ \t]*,|DLGNAME\b|DLGSHOW\b)", b"(DLG"),
    _of("planetcnc", 75, "a parameter of an axis or pin of PlanetCNC", rb"#<_[A-Z]\w*\|", b"|"),
    _of("printer", 20, "the head of a file of a slicer", rb"^;[ \t]*(?:FLAVOR:|LAYER:|LAYER_CHANGE|GENERATED (?:WITH CURA|BY (?:PRUSA|SUPER)?SLIC3?E?R))", b";"),
    _of("printer", 20, "the head of a file for Marlin", rb"^;[ \t]*MARLIN DEVICE PROFILE", b"MARLIN"),
    _of("printer", 20, "a command of Klipper", rb"^[ \t]*(?:SET_VELOCITY_LIMIT|SET_PRESSURE_ADVANCE|EXCLUDE_OBJECT_\w+|BED_MESH_\w+)\b", b"_"),
    _of("printer", 15, "a word of RepRapFirmware", rb"^[ \t]*(?:M98[ \t]*P(?:\"|\d:/)|(?:VAR|SET|GLOBAL|ECHO)[ \t]+\S[^\n]*[={]|IF[ \t][^\n]*\b(?:MOVE|STATE|SENSORS|GLOBAL|VAR)\.)", b'P"', b":/", b"VAR", b"SET", b"GLOBAL", b"ECHO", b"IF"),
    _of("roland", 20, "a command of RML-1", rb"^!(?:MC|VZ|ZM|PZ|RC)", b"!"),
    _of("shopbot", 20, "a command of ShopBot", rb"^[ \t]*(?:[MJ][2-6XYZAB]|[MJ]S|VS|SO|CN|CG),[ \t]*[-.\d(&]", b","),
    _of("sodick", 20, "a condition of discharge", rb"^[ \t]*C\d{3}[ \t]*=[ \t]*[-+\d]\d{3}", b"="),
    _of("syntec", 20, "an assignment by :=", rb"^%@MACRO|" + _AT + rb"[@#]\d+[ \t]*:=", b"@MACRO", b":="),
    _of("tinyg", 20, "a line of JSON", rb"^[ \t]*\{[ \t]*\"?\w+\"?[ \t]*:", b"{"),
)  # fmt: skip
_ELSEWHERE_BARE = (
    _of("amada", 20, "a sheet by G06 A B", rb"^G0?6A" + SIGNED + rb"B", b"6A"),
    _of("amada", 15, "a row of holes of a punch press", rb"^G(?:26I" + _V + rb"[^\n]*K|3[67]I" + _V + rb"[^\n]*J)", b"G26I", b"G36I", b"G37I"),
    _of("boss", 20, "a macro of BOSS", rb"^=#\d", b"=#"),
    _of("brother", 20, "a tool change by G100", _W + rb"G100T\d", b"G100T"),
    _of("brother", 20, "a tap by G77 or G78 with a pitch I or J", _W + rb"G7[78][XYZR]" + _V + rb"[^\nPQ]*[IJ][.\d][^\nPQ]*S\d", b"G77", b"G78"),
    _of("citizen", 30, "the beginning of a path by $", rb"^\$[0-9]$", b"$"),
    _of("centroid", 20, "a variable by a letter", rb"#\[[A-Z]\]", b"#["),
    _of("centroid", 15, "a condition with == or !=", rb"^IF\[[^\n]*[=!]=[^\n]*(?:THEN|GOTO)", b"==", b"!="),
    _of("centroid", 12, "the head of a program of Centroid", rb"^M25G49$", b"M25G49"),
    _of("eding", 20, "a loop or condition of Eding CNC", rb"^(?:WHILE|IF)\[[^\n]*\]$", b"WHILE[", b"IF["),
    _of("fadal", 12, "a fixture offset E", rb"^(?:[GMS]" + SIGNED + rb")*X" + SIGNED + rb"Y" + SIGNED + rb"(?:[MS]" + SIGNED + rb")*E\d{1,2}(?:[HMZ]" + SIGNED + rb")*$", b"E"),
    _of("fadal", 20, "no tool and no fixture by H0 E0", rb"(?:H0E0|E0H0)(?![.\d])", b"H0E0", b"E0H0"),
    _of("fadal", 6, "a tool length by H alone", rb"^(?:G90)?H\d{1,2}Z" + SIGNED + rb"(?:M\d+)*$|^(?:G90)?E0X", b"H", b"E0"),
    _of("fadal", 20, "a subprogram by L and M17", rb"^L\d+00\n(?:[GXYZ][^\n]*\n)+M17$", b"M17"),
    _of("fagor", 12, "a depth I of a cycle", _W + rb"G(?:69|8[1-9])(?![\d.])(?![^\n]*[JR])[^\n]*Z" + _V + rb"[^\nI]*I-[.\d]", b"G69", *(b"G8%d" % digit for digit in range(1, 10))),
    _of("fagor", 12, "a corner by G36 to G39 with R", _W + rb"G3[6-9]R[.\d]", *(b"G3%dR" % digit for digit in range(6, 10))),
    ("tool and offset T1.1", {"fagor": 6.0, "osai": 6.0}, rb"^T(?=\d{1,2}(?!\d))" + _WITH_POINT + rb"(?<=\d)(?<!\d{3})(?:M0?6)?$", (b"T",)),
    _of("fagor", 6, "a parameter P as a value", rb"(?<![A-Z])[XYZIJKFS]P\d+", *(b"%cP" % letter for letter in b"XYZIJKFS")),
    _of("hnc", 20, "a turning cycle in one block with X and Z", _W + rb"G7[1-3](?=[^\n]*P\d)(?=[^\n]*Q\d)(?=[^\n]*[XZ]-?[.\d])(?=[^\n]*[UW][.\d])[^\nY]*$", b"G71", b"G72", b"G73"),
    _of("hnc", 12, "a thread by G82", rb"^G82(?![\d.])(?=[^\n]*[XU])(?=[^\n]*[ZW])[^\nRYLKQ]*F(?=\d)(?:" + _NUMBER + rb")[^\nRYLKQ]*$", b"G82"),
    _of("hnc", 12, "a turning pass by G80", rb"^G80[XU]" + _V + rb"[^\nRYLQK]*[ZW]" + _V + rb"[^\nRYLQK]*F", b"G80X", b"G80U"),
    _of("hnc", 15, "radius or diameter by G36 or G37", rb"^(?:G\d+)*G3[67](?:G\d+)*(?![XYZUWIJKRHQP\d.])", b"G36", b"G37"),
    _of("hnc", 15, "a mirror image by G24 or G25", rb"^(?:G\d+)*G2[45][XYZ]" + SIGNED + rb"$", b"G24", b"G25"),
    _of("hnc", 20, "a rotation by G68 P", _W + rb"G68[XYZ](?=[^\n]*P\d)[^\nRIJKQ]*$", b"G68"),
    _of("hnc", 20, "a loop without brackets", rb"^(?:ENDW|WHILE\[?#\d+\]?(?:LT|LE|GT|GE|EQ|NE)(?![^\n]*DO)[^\n]*)$", b"ENDW", b"WHILE#", b"WHILE["),
    _of("integrex", 20, "a tool of six digits, the next tool and M6", rb"(?<![A-Z])T\d{6}T\d{3}(?:\d{3})?M0?6(?!\d)", b"M6", b"M06"),
    _of("maho", 30, "the head of a file of Philips' controls", rb"^%PM\d*$", b"%PM"),
    _of("maho", 20, "a repeat or call by N=", _W + rb"G(?:14[^\n]*N1=|2[29][^\n]*N=)", b"G14", b"N="),
    _of("maho", 15, "a blank by G98 or G99", _W + rb"G9[89]X" + _V + rb"[^R\n]*Z" + _V + rb"[^R\n]*I" + _V + rb"[^R\n]*J" + _V + rb"[^R\n]*K(?![^\n]*R)", b"G98X", b"G99X"),
    _of("maho", 15, "a point by G78 P", _W + rb"G78P\d+[XYZ]", b"G78P"),
    _of("maho", 12, "a cycle with clearance Y and return B", rb"^G8[1-9]Y" + SIGNED + rb"Z-" + SIGNED + rb"B" + SIGNED + rb"[^\nR]*$", b"G8"),
    _of("maho", 8, "a cycle by G79", rb"^G79(?:[XYZ]" + _V + rb"[^\nR]*Y|P\d+)[^\nR]*$", b"G79"),
    _of("num", 20, "a call by G77", _W + rb"G77(?:H\d|" + BLOCK_NUMBER + rb"(?:" + BLOCK_NUMBER + rb"|S\d|$))", b"G77"),
    _of("num", 20, "a jump by G79", _W + rb"G79(?:[LE]\d[^N\n]*)?" + BLOCK_NUMBER, b"G79"),
    _of("num", 20, "a turning cycle of lines N N", _W + rb"G6[3-6]" + BLOCK_NUMBER + BLOCK_NUMBER, b"G6"),
    _of("num", 6, "machine coordinates by G52",
        _W + rb"(?:G0?[01](?:G[49]0)*G52[XYZ]|G52G0?[01](?![\d.])|G52Z" + SIGNED + rb"(?:[MD]" + SIGNED + rb")*$)", b"G52"),
    _sign("a program number behind % alone", {"num": 4.0, "fagor": 4.0}, rb"^%\d{1,5}$", *(b"%%%d" % digit for digit in range(10))),
    _of("num", 12, "a parameter of NUM", rb"(?:^|[\d.])(?:L\d{1,3}|E[1-9]\d{4})=", b"="),
    _of("num", 15, "a tool's axis by G16", _W + rb"G16[PQR][-+](?=[A-Z]|$)", b"G16"),
    _of("num", 3, "tool and edge T D before M6", rb"^T\d+D\d+M0?6(?!\d)", b"M6", b"M06"),
    _of("okuma", 20, "a coordinate system by G15 H or G16 H", _W + rb"G1[56]H\d", b"G15H", b"G16H"),
    _of("okuma", 15, "a variable of Okuma", rb"(?<![A-Z])V(?:C\d+|S\d+|ZOF[XYZC]|ETF|TOFH|TLN)(?:\[\d+\])?=", b"="),
    _of("okuma", 6, "a tool length by G56 H", _W + rb"G56(?![\d.])(?:[XYZ]" + SIGNED + rb")?H\d", b"G56"),
    _of("okuma", 15, "a word of Okuma", rb"^(?:NOEX|MODIN|MODOUT|CALLO[A-Z0-9]+|N(?:LAP|CYL|AT)\d*(?=[GX-Z]))",
        b"NOEX", b"MOD", b"CALLO", b"NLAP", b"NCYL", b"NAT"),
    _of("okuma", 15, "a line's name of Okuma", rb"^N(?:STRT|BAR|AT\d+|LAP\d*|END)$", b"NSTRT", b"NBAR", b"NAT", b"NLAP", b"NEND"),
    _of("okuma", 30, "a spindle of Okuma's lathes by G140 or G141", rb"^G14[01]$", b"G140", b"G141"),
    _of("okuma", 20, "a condition with the name of a line", rb"^IF\[[^\n]*\]N[A-Z\d]", b"IF["),
    _of("okuma", 20, "a contour of LAP", _W + rb"G8[567]N[A-Z]", b"G85N", b"G86N", b"G87N"),
    _of("okuma", 20, "the speed of a driven tool by SB=", _W + rb"SB=[.\d]", b"SB="),
    _of("okuma", 15, "a block that goes on behind $", rb"^\$(?!N\d)[A-Z]{1,4}=?-?[.\d]", b"$"),
    _of("okuma", 4, "a tool of six digits", rb"(?:^|[^A-Z#<])T\d{6}(?!\d)", b"T"),
    _of("emco", 15, "a word P0= or D3= of TM02", rb"(?<![A-Z])[PD]\d=-?[.\d]", b"="),
    _of("pal", 9, "a coordinate XA or XI of PAL", rb"(?<![A-Z_<#=+*/(\[,$-])(?:[XYZ][AI]|[IJK]A)" + SIGNED + rb"(?![=_.\d])", b"XA", b"YA", b"ZA", b"XI", b"YI", b"ZI", b"IA", b"JA", b"KA"),
    _of("pal", 9, "a rounding RN, or an allowance AX and AZ, of PAL", rb"(?<![A-Z_<#=+*/(\[,$-])(?:RN|A[XZ])" + SIGNED + rb"(?![=_.\d])", b"RN", b"AX", b"AZ"),
    _of("pal", 20, "a repeat of lines by G23 N N", rb"^G23" + BLOCK_NUMBER + BLOCK_NUMBER, b"G23"),
    _of("pal", 9, "the tool change point by G14", rb"^G14(?:H[0-2])?(?:M0?9)?$", b"G14"),
    _of("pilot", 30, "a part of a program of CNC PILOT", rb"^(?:PROGRAMMKOPF|PROGRAMHEAD|FERTIGTEIL|FINISHEDPART|BEARBEITUNG)$", b"PROGRAM", b"FERTIGTEIL", b"FINISHED", b"BEARBEITUNG"),
    _of("rexroth", 20, "a variable @ of Bosch", rb"(?:^|\d|IF|=)@\d{1,3}=|BRANCH[A-Z]", b"@", b"BRANCH"),
    _of("printer", 8, "an extruder", rb"^G0?[01](?=[XYZF])[^\n]*E-?[.\d]", b"E"),
    _of("printer", 12, "an extruder set to 0", rb"^G92E0", b"G92E"),
    _of("printer", 10, "a temperature", rb"^M(?:104|109|140|190)S\d", b"M1"),
    _of("printer", 12, "a value in braces", _W + rb"[EFXYZ]\{[^\n]*\}", b"{"),
    _of("printer", 8, "homing of axes without a value", rb"^G28(?=[XYZ])X?Y?Z?$", b"G28"),
    _of("printer", 6, "a fan", rb"^M106(?:[PS]" + SIGNED + rb")*$", b"M106"),
    _of("printer", 8, "a sound or a servo", rb"^M(?:280|300)(?=[PS]" + SIGNED + rb")(?:[PS]" + SIGNED + rb")*$", b"M280", b"M300"),
    _of("printer", 6, "motors switched off, or moves waited for", rb"^M(?:84|400)$", b"M84", b"M400"),
    _of("printer", 12, "a tool or drive of RepRapFirmware", rb"^M(?:563|569|584|950)[PSXYZE]", b"M563", b"M569", b"M584", b"M950"),
    _of("sinumerik-800", 12, "a command @ of SINUMERIK's system 800", rb"(?:^|\d)@\d{3}(?:[RKP]|$)", b"@"),
    _of("sinumerik-800", 12, "the head of a file of SINUMERIK's system 800", rb"^%(?:MPF|SPF)\d+$", b"%MPF", b"%SPF"),
)  # fmt: skip
#: Signs in the original text of blocks: capitals, comments and blanks kept.
WRITTEN = (
    *_ELSEWHERE,
    _sign("plain language", _all(30, _H), rb"^[ \t]*(?:" + _BLOCK + rb"[ \t]+)?(?:BEGIN[ \t]+PGM\b|SPL[ \t]+I?[XYZ])", b"PGM", b"SPL"),
    _sign("a tool call of plain language", _all(15, _H), rb"^[ \t]*\d+[ \t]+(?:TOOL[ \t]+CALL|CYCL[ \t]+DEF|BLK[ \t]+FORM)\b", b"CALL", b"CYCL", b"FORM"),
    _sign("a line of plain language", _all(12, _H), rb"^[ \t]*\d+[ \t]+(?:L[ \t]+|CC?[ \t]+|LP?[ \t]+|FN[ \t]*\d)[^\n=]*(?:\bR[0LR]\b|F[ \t]*MAX|DR[-+]|Q\d)", b"R0", b"RL", b"RR", b"MAX", b"DR", b"Q"),
    _sign("a traverse of plain language", _all(12, _H), rb"^[ \t]*L[ \t]+[^\n=(;]*\bF[ \t]*MAX\b", b"MAX"),
    _sign("a message or print of LinuxCNC", _all(6, _L), rb"\([ \t]*(?:DEBUG|PRINT|LOGOPEN|LOGAPPEND|PROBEOPEN|AXIS)[ \t]*,", b","),
    # Of bounded length: an end that is missing is not looked for anew from each parenthesis of a long line.
    _sign("a comment within a comment", _all(3, _F, _T), rb"(?=\(.{0,255}\))(?!" + LINUXCNC["COMMENT"].encode() + rb")(?:" + COMMENT + rb")", b"("),
    _sign("an O-word", _all(30, _L),
          rb"^[ \t]*/?[ \t]*(?:N[ \t]*(?:" + _NUMBER + rb")[ \t]*)?O[ \t]*(?:\d+|" + _TERMINALS[b"NAME"] + rb"|\[[^\n]*?\]|#\S+?)[ \t]*(?:SUB|CALL|IF|WHILE|DO|REPEAT|RETURN|ENDSUB)\b", b"SUB", b"CALL", b"IF", b"WHILE", b"DO", b"REPEAT", b"RETURN"),
    _sign("the head of a file of SINUMERIK", _all(30, _S), rb"^[ \t]*(?:%\w+_(?:MPF|SPF)\b|;\$PATH=)", b"_MPF", b"_SPF", b";$PATH"),
    _sign("a message of SINUMERIK", _all(12, _S), _SAID + rb"MSG[ \t]*\([ \t]*[\")]", b"MSG"),
    _sign("a cycle of SINUMERIK", _all(20, _S), _SAID + rb"(?:CYCLE\d+|POCKET\d|SLOT\d|HOLES\d|LONGHOLE|WORKPIECE|CONTPRON)[ \t]*\(", b"CYCLE", b"POCKET", b"SLOT", b"HOLE", b"WORKPIECE", b"CONTPRON"),
    _sign("a call with arguments", _all(8, _S), _AT + rb"[A-Z_]{3}\w*[ \t]*\((?:[-+.\w$\"]*,)+[-+.\w$\"]*\)[ \t]*(?:" + _REMARK + rb")?$", b","),
    _sign("a step of ShopMill", _all(20, _S), _AT + rb"[EF]_[A-Z_]+\d*[ \t]*\(", b"E_", b"F_"),
    _sign("a definition of SINUMERIK", _all(20, _S), _AT + rb"(?:DEF[ \t]+(?:REAL|INT|BOOL|CHAR|STRING|AXIS|FRAME)\b|PROC[ \t]+[A-Z_]|EXTERN[ \t]+[A-Z_])", b"DEF", b"PROC", b"EXTERN"),
    _sign("a tool by its name", _all(12, _S), _SAID + rb"T[ \t]*=[ \t]*\"", b'"'),
    _sign("a value of SINUMERIK", _all(12, _S), rb"^[^;(\n]*=[ \t]*(?:AC|IC|DC|ACP|ACN)[ \t]*\(", b"="),
)  # fmt: skip
_COMMANDS = (
    b"TRAORI TRAFOOF TRANSMIT TRACYL MCALL STOPRE SUPA CFTCP CFC CFIN FFWON FFWOF SOFT BRISK COMPON COMPCAD COMPCURV COMPOF ORIWKS ORIMKS ORIAXES UPATH FIFOCTRL DIAMON DIAMOF DIAM90 CSPLINE ASPLINE RTLIOF RTLION WAITM"
).split()
#: Words of the language, which comments have as well: they are looked for beside comments alone.
SPOKEN = (
    # With their blanks: in ``X1E F100`` a number is spoilt. Not enough alone: comments have such words as well (ER20).
    _of("num", 9, "a word EA to ET", _W + rb"E[ABFGHRST][-+]?[.\d]", b"E"),
    _sign("a jump of SINUMERIK", _all(15, _S), rb"\bGOTO[FBC]?[ \t]+[A-Z_]{2}", b"GOTO"),
    _sign("a loop or condition of SINUMERIK", _all(12, _S),
          _AT + rb"(?:ENDIF|ENDWHILE|ENDFOR|ENDLOOP|LOOP|REPEAT(?:[ \t]+[A-Z_]\w+)?|UNTIL[ \t(][^\n]*|FOR[ \t]+[^\n]*\bTO\b[^\n]*|(?:IF|WHILE)[ \t]*[\(A-Z$][^\[\n]*(?:==|<>|[<>])[^\n]*)[ \t]*(?:" + _REMARK + rb")?$", b"IF", b"WHILE", b"FOR", b"LOOP", b"REPEAT", b"UNTIL"),
    _sign("a frame of SINUMERIK", _all(10, _S),
          _AT + rb"A?(?:TRANS|ROT|SCALE|MIRROR)(?:[ \t]+(?:[XYZ]|RPL)[ \t]*[-=.\d][^\n]*|[ \t]*(?:" + _REMARK + rb")?)$", b"TRANS", b"ROT", b"SCALE", b"MIRROR"),
    _sign("a command of SINUMERIK", _all(10, _S),
          rb"\b(?:" + b"|".join(_COMMANDS) + rb")\b", *_COMMANDS),
)  # fmt: skip
#: Signs in bare blocks: capitals without comments, blanks, N words and the slash of blocks that may be left out.
BARE = (
    *_ELSEWHERE_BARE,
    _sign("a named parameter", _all(20, _L), rb"#<", b"#<"),
    _sign("a parameter R", _all(10, _S), rb"(?:^|[\d.)])R\d{1,3}=", b"="),
    _sign("a spindle or tool with =", _all(10, _S), rb"(?:^|[^A-Z#<])(?:LIMS|[STM]\d)=", b"="),
    _sign("tool and edge T D", _all(4, _S), rb"^T\d{1,2}D\d(?:M0?6)?$", b"D"),
    # Heidenhain's DIN/ISO.
    _sign("a head with G70 or G71", _all(30, _H), rb"^%\w+?G7[01]\*?$", b"G70", b"G71"),
    _sign("blocks that end in *", _all(5, _H), rb"^[^\n]*[A-Z]" + SIGNED + rb"\*$", b"*"),
    _sign("a label or its call", _all(12, _H), rb"^(?:G98L\d+|L\d+,\d+)\*?$", b"G98L", b","),
    _sign("a tool of DIN/ISO", _all(10, _H), rb"^(?:T\d+G1[789]S\d|G99T\d+L)", b"G17S", b"G18S", b"G19S", b"G99T"),
    _sign("a function of Q", _all(20, _H), rb"^D[01]\dQ\d+P0?1", b"D0", b"D1"),
    _sign("a cycle of DIN/ISO", _all(20, _H), rb"^G2\d\d(?![\d.])[^\n]*Q\d+=", b"="),
    _sign("an arc or axis with =", _all(8, _S), rb"(?:CR|TURN|AR|AP|RP|RND|CHF|CHR|(?<![A-Z_])[XYZABC]\d?|[IJK]1)=[-+.\dR(]", b"="),
    _sign("a code of SINUMERIK", _all(8, _S), _W + rb"G(?:500|50[5-9]|5[1-9]\d|64[1-5]|60[1-3]|45[01])(?![\d.])", b"G5", b"G6", b"G45"),
    _sign("SINUMERIK's switch to the ISO dialect", _all(12, _F, _T), _W + rb"G291(?![\d.])", b"G291"),
    _sign("a turning cycle of LinuxCNC", _all(12, _L), rb"^[^\n]*G7[012](?:\.[12])?(?=[^\n]*Q\d)(?!P\d+Q)(?![^\nQ]*P\d)[^\n]*[DIQRXZ]", b"G7"),
    _sign("a threading cycle of LinuxCNC", _all(12, _L), rb"G76(?=[^\n]*I)(?=[^\n]*J)(?=[^\n]*K)", b"G76"),
    _sign("G7 or G8 alone", _all(6, _L), rb"G0?[78](?![\d.PX-Z])", b"G7", b"G8", b"G07", b"G08"),
    _sign("G96 D S", _all(8, _L), rb"G96(?:S" + SIGNED + rb")?D", b"G96"),
    _sign("a tolerance G64 P", _all(6, _L), rb"G64P", b"G64P"),
    _sign("a code of LinuxCNC alone", _all(8, _L), rb"G(?:0?5\.2|0?5\.3(?!P)|33\.1|38\.[2-5]|43\.2|92\.[23]|59\.[123]|41\.1|42\.1)(?!\d)", b"5.2", b"5.3", b"33.1", b"38.", b"43.2", b"92.", b"59.", b"41.1", b"42.1"),
    _sign("exact path G61.1", _all(4, _L), rb"G61\.1(?!\d)", b"G61.1"),
    _sign("a centre mode", _all(4, _L), rb"G9[01]\.1(?!\d)", b".1"),
    _sign("an output code", _all(3, _L), _W + rb"M6[2-8][PE]", *(b"M%d" % number for number in range(62, 69))),
    _sign("a thread by G33 K", _all(4, _L), rb"G33[^\n]*K" + _V, b"G33"),
    _sign("a dwell with a decimal point", _all(3, _L), rb"G0?4P" + _WITH_POINT + rb"(?<=\d)(?!\.)", b"P"),
    # Of FANUC, mill or lathe.
    _sign("two tools before M6", _all(8, _F), rb"T\d+T\d+M0?6(?!\d)", b"M6", b"M06"),
    _sign("a program number", _all(8, _F, _T), rb"^%?[O:]\d{1,8}(?:[GMSTXYZ]\d[^\n]*)?$", b"O", b":"),
    _sign("a program number behind %", _all(4, _F, _T), rb"^%\d{1,8}$", *(b"%%%d" % digit for digit in range(10))),
    _sign("a name behind %", _all(3, _F, _T), rb"^%[A-Z]{2}\w*$", b"%"),
    _sign("a program name", _all(8, _F, _T), rb"^O?<[^>\n]*>$", b"<"),
    _sign("a jump of a macro", _all(12, _F, _T), rb"GOTO[\d#\[]", b"GOTO"),
    _sign("a loop of a macro", _all(12, _F, _T), rb"^(?:WHILE\[[^\n]*\]DO|DO[123]$|END[123]$)", b"WHILE", b"DO", b"END"),
    _sign("a condition of a macro", _all(12, _F, _T), rb"^IF\[[^\n]*\](?:THEN|GOTO|#)", b"IF["),
    _sign("a sum without brackets", _all(8, _F, _T), rb"#\d+=[#\d.][#\d.]*[-+*/][#\d\[]", b"="),
    _sign("a function without brackets", _all(6, _F, _T), rb"#\d+=-?(?:SQRT|SIN|COS|TAN|ABS|ROUND|FIX|FUP)\[[^\n]*\][-+*/]", b"["),
    _sign("an output command of a macro", _all(12, _F, _T), rb"^(?:POPEN|PCLOS|[BD]PRNT)", b"POPEN", b"PCLOS", b"PRNT"),
    _sign("an alarm of a macro", _all(6, _F, _T), rb"#300[06]=", b"#300"),
    _sign("a macro call", _all(10, _F, _T), _W + rb"G6[56]P", b"P"),
    _sign("a look-ahead code", _all(8, _F, _T), _W + rb"G0?(?:5\.1Q|5\.3P|5P(?:10000|0|1|2)$|8P)", b"5.1Q", b"5.3P", b"5P", b"8P"),
    _sign("a dwell of X", _all(8, _F, _T), _W + rb"G0?4X\.?\d", b"4X"),
    _sign("a dwell in milliseconds", _all(4, _F, _T), _W + rb"G0?4P[1-9]\d\d+$", b"4P"),
    _sign("a code of Haas", _all(8, _F, _T), OF_HAAS, b"G103", b"G154P", b"G187", b"M97P", b"G234", b"G254", b"G255"),
    _sign("a circular pocket of Haas", _all(8, _F), _W + rb"G1[23](?![\d.])(?=[^\n]*I[.\d])(?=[^\n]*D\d)", b"G12", b"G13"),
    _sign("a dwell P of a drilling cycle", _all(8, _F, _T), _W + rb"G(?:73|8[135])(?![\d.])(?=[^\n]*Z)(?=[^\n]*R)[^\n]*P\d", b"G73", b"G81", b"G83", b"G85"),
    _sign("rigid tapping by M29", _all(4, _F, _T), _W + rb"M29(?!\d)", b"M29"),
    _sign("a chamfer or rounding", _all(8, _F, _T), rb",[CR]" + _V, b","),
    _sign("a reference point beside a motion code", _all(4, _F, _T),
          _W + rb"G(?:0?[0-3](?![\d.])[^\n]*G(?:28|30)|(?:28|30)(?![\d.])[^\n]*G0?[0-3])(?![\d.])", b"G28", b"G30"),
    _sign("the words of a cycle kept by L0 or K0", {_F: 8, _T: 3}, _W + rb"G(?:7[34]|8[1-69])(?![\d.])[^\n]*[LK]0(?![\d.])", b"L0", b"K0"),
    _sign("a skip by G31", {_F: 9, _T: 5}, _W + rb"G31(?![\d.])", b"G31"),
    _sign("a call of M98", _all(3, _F, _T), rb"M98P\d", b"M98P"),
    _sign("calls of M98 with their count", _all(3, _F, _T), rb"M98P\d{5,8}(?![\d.])", b"M98"),
    _sign("a block left out by a numbered switch", _all(4, _F, _T), rb"^\x00[2-9]", b"\x00"),
    # Of FANUC's mills.
    _sign("a mirror, rotation, scaling or polar code", {_F: 10, _T: 2},
          _W + rb"G(?:51\.1|68(?:\.2)?|51(?=[PXYZIJK])|16)(?![\d.])|^G50\.1(?![\d.])", b"G50.1", b"G51", b"G68", b"G16"),
    # They end modes that other mills never have on: as lines of its header a program of RS274/NGC's time has them too.
    _sign("the end of a rotation or of polar coordinates", {_F: 4, _T: 1}, rb"^G(?:69|15)(?![\d.])(?![^\n]*I-?[.\d])", b"G69", b"G15"),
    _sign("a code of FANUC's mills", {_F: 10, _T: 4}, rb"G(?:43\.4(?!\d)|54\.1P|54P\d|10L1[23](?!\d))", b"G43.4", b"G54.1P", b"G54P", b"G10L1"),
    _sign("a spindle's bound by G92 S", {_F: 4, _B: 8}, _W + rb"G92S", b"G92S"),
    _sign("tool lengths G43 H", {_F: 1, _L: 1, _T: -12}, rb"G43(?![\d.])[^\n]*H\d", b"G43"),
    _sign("a tool length and radius by G43 H D", {_F: 4}, rb"G43(?![\d.])(?=[^\n]*H\d)[^\n]*D\d", b"G43"),
    _sign("words of Y", {_T: -5}, rb"Y" + _V, b"Y"),
    _sign("X and Y in a block", {_T: -3}, rb"X" + _V + rb"[^\nXYZ]*Y" + _V, b"Y"),
    # Modes there are in systems B and C of lathes too, which this says nothing of; in A they are passes.
    _sign("a mode G90 or G91 beside G0 or G1", {_T: -6, _B: -0.1, _C: -0.1},
          rb"(?<![A-Z_])(?:G9[01](?:G\d{1,3}){0,6}G0?[01]|G0?[01](?:G\d{1,3}){0,6}G9[01])(?![\d.])", b"G90", b"G91"),
    # Lathes drill and tap along Z alone.
    _sign("a cycle of mills", {_T: -4}, _W + rb"G8[1-9](?![\d.])[^\n]*[XY]" + _V, b"G8"),
    _sign("a tool change M6", {_T: -4}, _W + rb"M0?6(?!\d)", b"M6", b"M06"),
    # Of FANUC's lathes, systems B and C.
    _sign("a turning pass by G77 or G79", {_B: 12}, rb"^G7[79][XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GYPQ\n]*$", b"G7"),
    _sign("a threading pass by G78", {_B: 12}, rb"^G78[XU]" + _V + rb"[^GYPQ\n]*F", b"G78"),
    _sign("a turning pass by G20 or G24", {_C: 10}, rb"^G2[04][XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GY\n]*F[^GY\n]*$", b"G20X", b"G20U", b"G24X", b"G24U"),
    _sign("a threading pass by G21", {_C: 10}, rb"^G21[XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GY\n]*F[^GY\n]*$", b"G21X", b"G21U"),
    _sign("a thread of a lathe by G78", {_C: 20}, _W + rb"G78P\d{5,6}(?![\d.])", b"G78P"),
    _sign("finishing by G72 P Q", {_C: 14, _T: -12}, rb"^G72P\d+Q\d+$", b"G72P"),
    # Of FANUC's lathes, system A.
    _sign("a bound of the spindle's speed by G50", {_T: 20}, _W + rb"G50S[\d#\[]", b"G50S"),
    _sign("a turning cycle of lines P to Q", {_T: 20, _B: 0}, _W + rb"G7[0-3]P\d+Q\d+(?![\d.])", b"P"),
    _sign("a turning cycle in two blocks", {_T: 12, _B: 0}, rb"^G7[12][UW]" + SIGNED + rb"R" + SIGNED + rb"(?:[FST]" + SIGNED + rb")*$", b"G7"),
    _sign("a thread of a lathe", {_T: 20, _B: 0}, _W + rb"G76P\d{5,6}(?![\d.])", b"G76P"),
    _sign("a reference point by distances U W", {_T: 20, _B: 0, _C: 0}, rb"G(?:28|30)(?:G" + SIGNED + rb")?U0?\.?0*W0?\.?0*(?![\d.])", b"W"),
    _sign("a reference point by a distance U", {_T: 6}, rb"G(?:28|30)U0?\.?0*(?![\d.])", b"U"),
    _sign("a dwell of U", {_T: 8, _F: 2}, _W + rb"G0?4U\.?\d", b"4U"),
    _sign("a threading pass by G92 with F", {_T: 8, _B: -4, _C: -4}, rb"^(?![^\n]*Y)[^\n]*(?<![A-Z_])G92[XUZW][^\n]*F", b"G92"),
    _sign("a thread by G32", {_T: 6, _B: -4, _C: -4}, _W + rb"G32[^\nY]*[XZUW][^\n]*F", b"G32"),
    _sign("a turning pass by G90 or G94", {_T: 4}, rb"^G9[04][XU]" + _V + rb"[^GY\n]*[ZW]" + _V + rb"[^GY\n]*$", b"G90X", b"G90U", b"G94X", b"G94U"),
    _sign("tool and offset in four digits of T", {_T: 5}, rb"(?:^|[^A-Z#<])T(?:0[1-9]|[1-9]\d)(?:0[1-9]|[1-9]\d)(?!\d)", b"T"),
    _sign("tool and offset in three digits of T", {_T: 3}, rb"(?:^|[^A-Z#<])T([1-9])0\1(?!\d)", b"T"),
    _sign("polar coordinate interpolation of lathes", {_T: 10, _F: 6}, _W + rb"G1(?:12|2\.1)(?!\d)", b"G112", b"G12.1"),
    _sign("cylindrical interpolation", {_T: 8, _F: 6}, _W + rb"G(?:107|0?7\.1)[AC]", b"G107", b"7.1"),
    _sign("distances U W beside X Z", {_T: 5},
          rb"^(?![^\n]*[YVPQ])(?![^\n]*G(?:0?4|10|28|30|50|92|7\d)(?!\d))(?:[^\n]*[XZ]" + _V + rb"[^\nXZUW]*[UW]|[^\n]*[UW]"
          + _V + rb"[^\nXZUW]*[XZ])" + _V, b"U", b"W"),
    _sign("a distance H of the axis C", {_T: 8, _B: 0, _C: 0},
          rb"^(?:G0?[01](?!\d))?(?:G9[89](?!\d))?(?:[XZUW]" + SIGNED + rb")*H(?:-|" + _WITH_POINT + rb")", b"H"),
    _sign("surface speed by G96", {_T: 3, _L: 1}, _W + rb"G96S", b"G96"),
)  # fmt: skip
#: What feeds and their modes say, in bare blocks.
CYCLES = _W + rb"G(?:8[1-9]|7[346])(?!\d)"
HOLES = _W + rb"G8[1-9](?!\d)"
A_TURN = _W + rb"G95(?![\d.])"
RETRACTS = _W + rb"G99(?![\d.])"
ARC_IN_XZ = rb"^[^\n]*G0?[23](?![\d.])[^\nK]*[XZUW]" + _V + rb"[^\nK]*K" + _V
PLANE = rb"G1[789](?![\d.])"
FEEDS = rb"F(" + _NUMBER + rb")"
OTHER_FEEDS = _W + rb"G(?:20|70|93|95|9[45]|32|33|84|74)(?![\d.])"
X_AND_Z = rb"[XU]" + _V + rb"[^\n]*[ZW]" + _V + rb"|[XZ]" + _V
#: Comments that are no arguments of a name: ``( ... )`` behind a blank or at the beginning, and what follows ``;``; and what stands
#: before a bare block.
REMARKS = rb"(?m:^|(?<=[ \t])|(?=;))(?:" + COMMENT + rb")"
NUMBERS = rb"(?m:^)(?=[/N])(?P<before>%(DELETE)b)?(?i:%(LINE_NUMBER)b)?(?P<behind>%(DELETE)b)?" % _TERMINALS
#: Patterns of words that other dialects read otherwise, in the different lines of a text (`cncgen.gcode.doubts`).
LONG_WAIT = rb"P[ \t]*\d{3}"
LONG_LENGTHS = {digits: rb"[XYZ][ \t]*[-+]?\d{%d}" % digits for digits in (4, 5)}
LENGTH_WITH_POINT = rb"[XYZ][ \t]*[-+]?" + _WITH_POINT
WHOLE = rb"[ \t]*[-+]?0*[1-9]\d*(?![\d.])"
WHOLE_WORD = rb"[XYZIJKQR]" + WHOLE
#: A rotary axis with its angle, and words beside which it is none, or no place.
ROTARY = rb"(?<![A-Z,#])(?P<word>(?P<axis>[ABC])[ \t]*(?P<angle>" + SIGNED + rb"))"
#: Such an axis with any value.
ANGLE = rb"(?<![A-Za-z,#])[ABCabc][ \t]*" + _V
NO_PLACE = rb"G[ \t]*0*(?:7\.1|10|28|30|5[0-3]|6[5-8]|9[2-3]|107)(?![\d])"
#: A whole one that ends in a point.
WHOLE_WITH_POINT = rb"(?i)[XYZ][ \t]*[-+]?(?=0*[1-9])" + _WITH_POINT + rb"(?<=\.)(?!\d)"
LAST_STAR = rb"(?m)\*[ \t]*\r?$"
WORDS_OF_SIEMENS = (
    rb"CYCLE\d+[ \t]*\(|\bR\d+[ \t]*=|=[ \t]*[AI]C[ \t]*\(|\bGOTO[FBC]\b|\bMCALL\b|\bTRA(?:ORI|NS|FOOF)\b"
    rb"|\bT[ \t]*=[ \t]*\"|\bDEF[ \t]+(?:REAL|INT|BOOL|STRING)\b|\bCR[ \t]*="
)
#: Lines that are no blocks, and passed over: commands to grbl (``$H``, ``$110=500``, those of one character), to the simulators of
#: CNCSimulator (``$AddRegPart 1 X0``, ``$Mill``) and Denford,
#: messages of Eding CNC, and of Marlin to the operator, the sign of a program without its number. The place of each is its group ``word``.
TO_GRBL = rb"^[ \t]*(?P<word>\$(?:[$#GINCHX][ \t]*(?:;|\r?$)|\d+[ \t]*=)|[?~!][ \t]*(?:;|\r?$))"
TO_SIMULATOR = rb"^[ \t]*(?P<word>\$(?!SLP|RST|JOG|HOM|BYE)[A-Z]{3,})(?![A-Z/=])"
TO_DENFORD = rb"^[ \t]*(?P<word>\[(?:BILLET|EDGEMOVE|TOOLDEF|STEP|CLEAR)\b)"
OF_EDING = rb"^[ \t]*(?P<word>(?:WARN|LOG)?MSG[ \t]+\"[^\"\n]*\"[ \t]*(?:;|\r?$))"
OF_MARLIN = _AT + rb"(?P<word>M11[78])[ \t][^;(\n]*[A-Z][A-Z]"
WITHOUT_NUMBER = rb"^[ \t]*(?P<word>:)[ \t]*(?:[(;]|\r?$)"
PASSED = (TO_GRBL, TO_SIMULATOR, TO_DENFORD, OF_EDING, OF_MARLIN, WITHOUT_NUMBER)
#: What stands before the slash of a block that may be left out.
BEFORE_SLASH = rb"[ \t]*(?:" + BLOCK_NUMBER + rb"[ \t]*)?"
#: A line that begins so, behind the end of the line before; most lines differ in their first character, which takes half the time.
LEFT_OUT = rb"\n(?=[ \t/" + BLOCK_NUMBER[:1] + rb"])" + BEFORE_SLASH + rb"/"
#: Units, by the tens of their codes, a computed code that may choose one, or G70 and G71 with codes alone behind them, as Mach and
#: Hurco have them; a length and a feed; a lathe's surface speed and what bounds its spindle (`cncgen.gcode.assumed_units`).
UNITS = {
    tens: rb"[Gg][ \t]*(?:0*%d[ \t]*[01](?![\d.])|[\[#]|7[01](?:[ \t]*[GMgm][ \t]*" % tens
    + _NUMBER
    + rb")*[ \t]*[\r\n])"
    for tens in (2, 7)
}
LENGTH = rb"[XYZxyz](?<![A-Za-z#<].)[ \t]*[-+]?(?P<number>" + _NUMBER + rb")"
FEED = rb"[Ff](?<![A-Za-z#<].)[ \t]*(?P<number>" + _NUMBER + rb")"
#: A size in inches, and one in mm, in a comment, as those of tools.
SIZE_IN_INCHES, SIZE_IN_MM = (
    rb"[(;][^)\n]*?(?P<size>[\d./]*\d(?:[Ii][Nn]|[ -]?[Ii][Nn][Cc][Hh](?:[Ee][Ss])?|\"))(?![A-Za-z])",
    rb"[(;][^)\n]*\d ?[Mm][Mm](?![A-Za-z])",
)
SURFACE_SPEED, SPEED_BOUND = (
    rb"[Gg][ \t]*" + code + rb"(?![\d.])[^\n]*?[Ss][ \t]*(?P<number>" + _NUMBER + rb")"
    for code in (rb"96", rb"(?:50|92)")
)


def by_line(pattern: bytes) -> bytes:
    """Return a pattern whose ``^`` and ``$`` are the borders of any line."""
    return b"(?m)" + pattern


def patterns() -> Iterator[bytes]:
    """Yield the patterns that are compiled when the package is built."""
    yield from (by_line(sign[2]) for sign in (*WRITTEN, *SPOKEN, *BARE))
    yield from map(by_line, (CYCLES, HOLES, A_TURN, RETRACTS, ARC_IN_XZ, PLANE, FEEDS, OTHER_FEEDS, X_AND_Z))
    yield from (FEEDS, OUT_OF_CODE, REMARKS, NUMBERS, LENGTH_WITH_POINT, WHOLE_WORD, LAST_STAR, LONG_WAIT)
    yield from (
        WORDS_OF_SIEMENS,
        ROTARY,
        ANGLE,
        NO_PLACE,
        *LONG_LENGTHS.values(),
        *UNITS.values(),
        LENGTH,
        FEED,
        SURFACE_SPEED,
        SPEED_BOUND,
        SIZE_IN_INCHES,
        SIZE_IN_MM,
        BEFORE_SLASH,
        LEFT_OUT,
    )
