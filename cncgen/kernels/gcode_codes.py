"""Numbers of what the tables of a grammar and the kernels that read and run G-code say to each other.

``grammars/lalr.py`` writes those of actions and literals into the tables, and all of `CONSTANTS` into ``gcode_codes.pxd``, as constants of
C; `gcode_parse` and `language_code` write operations.
"""


def _counted(names: str, first: int = 0) -> dict[str, int]:
    """Return names, apart by blanks, by their numbers from a first one on."""
    return {name: number for number, name in enumerate(names.split(), first)}


#: Work of the kernel where a rule (by its alias, else by its name) is reduced; 0 where rules leave the values of their parts.
ACTIONS = {
    **_counted(
        "number name parameter exists negative unary binary function arc_tangent slope power_of plain_word word word_of_function bspline "
        "setting comment message numbered_label named_label o_word program_number if_goto goto while_do end_do then output computed_label bracket",
        1,
    ),
    **dict.fromkeys(("start", "content", "flow", "if_then", "named_call"), 0),
}
ACTIONS["corner"] = ACTIONS["word"]
#: Names of the literals of terminals: operators, functions, keywords, letters of words of more than one.
LITERALS = {
    **_counted("and or xor eq ne gt ge lt le + - * / mod **", 1),
    **_counted("abs acos asin cos exp fix fup ln round sin sqrt tan bin bcd sqr rnd", 20),
    **_counted(
        "if while repeat do elseif else endif endwhile endrepeat break continue sub endsub return call", 40
    ),
    **_counted("program goto while-do end-do", 55),
    **_counted("pw= pl= sd= ,c ,r ,a ,k ,i ,j ,s", 128),
}
#: The local parameter that each letter beside G65 sets (FANUC's argument specification I, B-63324EN, 15.7.1).
MACRO_PARAMETERS = dict(
    zip("abcijkdefhmqrstuvwxyz", (1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, *range(17, 27)), strict=True)
)
LITERALS |= {"ifix[": LITERALS["fix"], "ifup[": LITERALS["fup"]}
#: Operations; the first ones leave a value.
OPERATIONS = _counted(
    "END NUMBER STORED BINARY NEGATIVE FUNCTION ARC_TANGENT NAME NAMED PARAMETER ELEMENT WORD SET SET_STORED SET_NAMED SET_VARIABLE SET_ELEMENT "
    "COMMENT FLOW THEN JUMP SLOPE EXISTS EXISTS_NAMED MESSAGE INCREMENTS OUTPUT"
)
#: The work of a rule of SINUMERIK or Heidenhain (`language_code`): its parts stand alone, a number, a parameter (with a sign or without), an
#: element R[…], a sign, an operator between values, a function before one, one with its arguments in brackets, a word as one token, a name
#: with a value behind it, the target of a setting, a setting, one of FN with its operator, the radius R0, the end of a line L, a traverse or
#: the feed of the tool, pi; jumps, from WORK_UNLESS on (`JUMPS`), and a label.
WORKS = _counted(
    "alone number parameter element sign operator function call arguments word named target setting operation radius motion fast pi unless "
    "goes when turns counts repeats label"
)
#: Jumps of SINUMERIK and Heidenhain: always, within branches and loops or to a label; where the condition does not hold, or holds; FOR,
#: which counts up to a value, its target behind the instruction; CALL LBL with REP, which counts rounds, and without; LBL 0.
JUMPS = ("TURNS", "GOES", "UNLESS", "WHEN", "COUNTS", "REPEATS", "CALLS", "LEAVES")
#: Operators and functions of SINUMERIK, Heidenhain and Macro B that G-code does not have; relations hold for reals that differ in more than
#: the last bits. Exactly equal are vacant
#: values too; JOIN is of texts.
OF_LANGUAGES = _counted(
    "WHOLE_QUOTIENT REMAINDER SAME OTHER_THAN ABOVE BELOW AT_LEAST AT_MOST LESSER GREATER ANGLE_OF NEAR APART LENGTH_OF TURN_OF BITS_AND "
    "BITS_OR BITS_XOR EQUAL UNEQUAL TRUNC SQUARE NEGATED FRACTION LOG_10 SIGN_OF ARC_OF TURN_OF_SINE MINUS CEILING BITS_NOT AWAY PLUS JOIN "
    "WHOLE_REMAINDER",
    60,
)
#: Numbers by themselves.
#: MAX_LINE: the longest line (`source.MAX_LINE`).
#: DELETED, NUMBERED, REFUSED, COMPUTED_LABEL: marks of a line, beside its code. SAYS: of a language, that it has instructions; from LETTERS
#: on stand the letters of its words, or the keyword of an O-word, jump or loop.
#: COMPUTED: bit of `gcode_names.named`, behind those of A to Z: a G or M number is computed.
#: CODE_NUMBERS: codes that it tells apart, in tenths: those of G, then those of M.
#: ARGUMENTS: of its `calls`: the words beside the program's number are arguments and name no axis.
#: ROW: columns of the row of a line that is kept.
#: MOST_VALUE: operations up to this leave a value.
#: CALLS_MACRO, CALLS_PROGRAM, ENDS_PROGRAM: G65, M98 and M99 by their number.
#: UNCERTAIN, PLAIN_LINE, NUMBERED_CALL, LANGUAGE_JUMP: kinds of lines (`gcode_instructions`), beside the numbers of keywords.
NUMBERS = {
    "MAX_LINE": 65_536, "DELETED": 1, "NUMBERED": 2, "REFUSED": 4, "COMPUTED_LABEL": 8, "SAYS": 16, "LETTERS": 8, "COMPUTED": 1 << 26,
    "CODE_NUMBERS": 4000, "ARGUMENTS": 128, "ROW": 8, "MOST_VALUE": OPERATIONS["ELEMENT"], "CALLS_MACRO": 65, "CALLS_PROGRAM": 98,
    "ENDS_PROGRAM": 99, "UNCERTAIN": -1, "PLAIN_LINE": 0, "NUMBERED_CALL": 999, "LANGUAGE_JUMP": 1000,
}  # fmt: skip
#: Columns of the row of a line that is kept (`gcode_lines.Lines`): offset and number of the line, where its code begins, offset of the next
#: line, the row of that (-1 for none yet), its marks, the number of its O-word (-1 for none yet), and where its constants begin.
LINE_COLUMNS = ("AT", "NUMBER_OF_LINE", "CODE", "AFTER", "FOLLOWING", "MARKS", "MARK", "FIRST_CONSTANT")
#: Kinds of bytes of a shape (`gcode_lines.Shapes`) beside those that stand for themselves: refused bytes, the end of the line, digits;
#: and the forms of numbers, 1, 1.5 and .5, which stand in shapes.
SHAPE_BYTES = (
    "SHAPE_UNKNOWN", "SHAPE_LINE_END", "SHAPE_DIGIT", "SHAPE_WHOLE", "SHAPE_DOTTED", "SHAPE_POINT_FIRST",
)  # fmt: skip
#: Columns of the row of a shape: its sum, where it stands in the store (-1: nowhere) with the signs of its numbers behind it, its length,
#: and common data of its lines: the begin of their code, and their marks.
SHAPE_COLUMNS = ("SHAPE_SUM", "SHAPE_PLACE", "SHAPE_LENGTH", "SHAPE_CODE", "SHAPE_MARKS", "SHAPE_NEXT", "SHAPE_ROW")  # fmt: skip
#: Columns of the row of a marked line (`gcode_marks.Marks`): its offset and number, the offset of the next line, its keyword, whether it is
#: certain where it leads (-1: not known yet), the marks below and above that it leads to (-1 for none), and how many columns there are.
MARK_COLUMNS = ("OFFSET", "LINE", "BEHIND", "KEYWORD", "LEADS", "MARK_BELOW", "MARK_ABOVE", "MARK_WIDTH")
#: Keywords that an O-word looks for in its subroutine, above it and below it: a branch the next one, the last of them its end; DO and WHILE
#: the other one of their loop, if there is one.
LOOKS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "if": ((), ("elseif", "else", "endif")),
    **dict.fromkeys(("elseif", "else"), (("if",), ("endif",))),
    "endif": (("if",), ()),
    "while": (("do",), ("endwhile",)),
    "endwhile": (("while",), ()),
    "do": ((), ("while",)),
    "repeat": ((), ("endrepeat",)),
    "endrepeat": (("repeat",), ()),
    **dict.fromkeys(("break", "continue"), ((), ("endwhile", "endrepeat", "while"))),
    "sub": ((), ("endsub",)),
}
#: Where an O-word of a branch or loop leads (`gcode_frames.Frame.lead`).
WAYS = ("STAY", "AT_NEXT", "PAST_NEXT", "AT_PREVIOUS", "PAST_PREVIOUS")
#: Places in the array `modes` of `gcode_motion`.
#: SILENT: the sink prints nothing, so comments, changes of mode and asides pass without a text.
#: FREE_SPINDLE: no feed hangs on the spindle. HOLES: the dialect has LinuxCNC's dwell, G80 and cycles. IN_CYCLE: G80 would end one.
#: DIRECTION, MIST, FLOOD: of spindle and coolant. OLD_LEVEL: G98. EXACT: G61.
#: TOOLS: any tool may be changed in. CYCLE, GIVEN: the cycle whose words are kept, and a bit for each (0: none; -1: with words that are
#: not taken here).
MODE_PLACES = (
    "MOTION", "ABSOLUTE", "ARC_ABSOLUTE", "PLANE", "INVERSE_TIME", "SKIP_SLASH", "SILENT", "FREE_SPINDLE", "HOLES", "IN_CYCLE",
    "DIRECTION", "MIST", "FLOOD", "OLD_LEVEL", "EXACT", "TOOLS", "CYCLE", "GIVEN", "MODES",
)  # fmt: skip
#: Places in its array `levels`; SYSTEM is the G code of the coordinate system in force, TOOL the one of T; from LEVEL on of the cycle:
#: where the row of holes began, the last dwell, R, P, Q and the bottom.
LEVEL_PLACES = (
    "FEED", "RADIUS_TOLERANCE", "CENTRE_TOLERANCE", "CENTRE_RELATIVE", "CENTRE_LIMIT", "LEAST_FEED", "MOST_FEED", "SPEED", "SYSTEM",
    "TOOL", "PECK_CLEARANCE", "LEVEL", "DWELL", "RETRACT", "PAUSE", "STEP", "BOTTOM", "LEVELS",
)  # fmt: skip
#: Words of a cycle as bits of `modes[GIVEN]`, in the order of `levels`.
WORDS_OF_CYCLES = {"GIVEN_R": 1, "GIVEN_P": 2, "GIVEN_Q": 4, "GIVEN_DEPTH": 8}
#: Its asides that are no M code by their number: S, G4, the wait of a cycle, exact path around a hole and its end, T.
ASIDES = {"ASIDE_SPEED": 1, "ASIDE_DWELL": 2, **_counted("ASIDE_PAUSE ASIDE_EXACT ASIDE_PATH ASIDE_TOOL", 10)}
#: Slots of the words of a block (`gcode_words`): axes, offsets, R, F, and behind those of plain motions S P Q L T; G and M have none.
SLOTS = "xyzabcuvwijkrfspqltgm"
#: Sets of slots, a bit each.
SETS_OF_WORDS = {
    "ANY_AXIS": "xyzabcuvw", "ANY_HOLE": "xyz", "ANY_ROTARY": "abc", "ANY_OFFSET": "ijk",
    **{f"WITH_{letter.upper()}": letter for letter in "rfspqlt"}, "RARE": "spqlt",
}  # fmt: skip
#: The keywords of O-words by their literals in the grammar; the first four begin something, and claim their label.
KEYWORDS = {name: number for name, number in LITERALS.items() if LITERALS["if"] <= number <= LITERALS["call"]}

#: Names of operators and keywords of O-words in kernels; other literals have their own in capitals.
_NAMES = {
    "+": "ADD",
    "-": "SUBTRACT",
    "*": "MULTIPLY",
    "/": "DIVIDE",
    "**": "POWER",
    **{name: f"O_{name}" for name in KEYWORDS},
}
#: All of them by the names that kernels have for them.
CONSTANTS = {
    **NUMBERS,
    **OPERATIONS,
    **OF_LANGUAGES,
    **{f"RULE_{name.upper()}": number for name, number in ACTIONS.items() if number},
    **{f"WORK_{name.upper()}": number for name, number in WORKS.items()},
    **{
        _NAMES.get(name, name).upper().replace("-", "_"): number
        for name, number in LITERALS.items()
        if number < 128 and "[" not in name
    },
    **{
        name: number
        for names in (
            JUMPS,
            LINE_COLUMNS,
            SHAPE_BYTES,
            SHAPE_COLUMNS,
            MARK_COLUMNS,
            WAYS,
            MODE_PLACES,
            LEVEL_PLACES,
        )
        for number, name in enumerate(names)
    },
    **WORDS_OF_CYCLES,
    **ASIDES,
    **{f"SLOT_{letter.upper()}": slot for slot, letter in enumerate(SLOTS)},
    **{name: sum(1 << SLOTS.index(letter) for letter in letters) for name, letters in SETS_OF_WORDS.items()},
}
# Python finds them here, and so do kernels that run uncompiled.
globals().update(CONSTANTS)
