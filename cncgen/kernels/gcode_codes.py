"""Numbers of what the tables of a grammar and the kernels that read and run G-code say to each other.

``grammars/lalr.py`` writes those of actions and literals into the tables, and all of `CONSTANTS` into ``gcode_codes.pxd``, as constants of
C; `gcode_parse` writes operations.
"""

#: Work of the kernel where a rule (by its alias, else by its name) is reduced.
ACTIONS = {
    "number": 1,
    "name": 2,
    "parameter": 3,
    "exists": 4,
    "negative": 5,
    "unary": 6,
    "binary": 7,
    "function": 8,
    "arc_tangent": 9,
    "slope": 10,
    "power_of": 11,
    "plain_word": 12,
    "word": 13,
    "word_of_function": 14,
    "bspline": 15,
    "corner": 13,
    "setting": 16,
    "comment": 17,
    "message": 18,
    "numbered_label": 19,
    "named_label": 20,
    "o_word": 21,
    "program_number": 22,
    "if_goto": 23,
    "goto": 24,
    "while_do": 25,
    "end_do": 26,
    "then": 27,
    "output": 28,
    "computed_label": 29,
    # Rules that leave the values of their parts.
    "start": 0,
    "content": 0,
    "flow": 0,
    "if_then": 0,
    "named_call": 0,
    "bracket": 0,
}
#: Names of the literals of terminals: operators, functions, keywords, letters of words of more than one.
LITERALS = {
    "and": 1,
    "or": 2,
    "xor": 3,
    "eq": 4,
    "ne": 5,
    "gt": 6,
    "ge": 7,
    "lt": 8,
    "le": 9,
    "+": 10,
    "-": 11,
    "*": 12,
    "/": 13,
    "mod": 14,
    "**": 15,
    "abs": 20,
    "acos": 21,
    "asin": 22,
    "cos": 23,
    "exp": 24,
    "fix": 25,
    "fup": 26,
    "ln": 27,
    "round": 28,
    "sin": 29,
    "sqrt": 30,
    "tan": 31,
    "bin": 32,
    "bcd": 33,
    "sqr": 34,
    "rnd": 35,
    "ifix[": 25,
    "ifup[": 26,
    "if": 40,
    "while": 41,
    "repeat": 42,
    "do": 43,
    "elseif": 44,
    "else": 45,
    "endif": 46,
    "endwhile": 47,
    "endrepeat": 48,
    "break": 49,
    "continue": 50,
    "sub": 51,
    "endsub": 52,
    "return": 53,
    "call": 54,
    "program": 55,
    "goto": 56,
    "while-do": 57,
    "end-do": 58,
    "pw=": 128,
    "pl=": 129,
    "sd=": 130,
    ",c": 131,
    ",r": 132,
    ",a": 133,
}
#: Operations.
OPERATIONS = {
    "END": 0,
    "NUMBER": 1,
    "WORD": 2,
    "STORED": 3,
    "BINARY": 4,
    "SET": 5,
    "PARAMETER": 6,
    "NAMED": 7,
    "NAME": 8,
    "SET_NAMED": 9,
    "NEGATIVE": 10,
    "FUNCTION": 11,
    "ARC_TANGENT": 12,
    "SLOPE": 13,
    "EXISTS": 14,
    "EXISTS_NAMED": 15,
    "COMMENT": 16,
    "MESSAGE": 17,
    "FLOW": 18,
    "THEN": 19,
    "INCREMENTS": 20,
    "OUTPUT": 21,
    "SET_STORED": 22,
    "SET_VARIABLE": 23,
    "JUMP": 24,
    "ELEMENT": 25,
    "SET_ELEMENT": 26,
}
#: Jumps of SINUMERIK and Heidenhain: always, within branches and loops or to a label; where the condition does not hold, or holds; FOR,
#: which counts up to a value, its target behind the instruction; CALL LBL with REP, which counts rounds, and without; LBL 0.
JUMPS = ("TURNS", "GOES", "UNLESS", "WHEN", "COUNTS", "REPEATS", "CALLS", "LEAVES")
#: Operators and functions of SINUMERIK, Heidenhain and Macro B that G-code does not have; relations hold for reals that differ in more than
#: the last bits. Exactly equal are vacant
#: values too; JOIN is of texts.
OF_LANGUAGES = {
    "WHOLE_QUOTIENT": 60,
    "REMAINDER": 61,
    "SAME": 62,
    "OTHER_THAN": 63,
    "ABOVE": 64,
    "BELOW": 65,
    "AT_LEAST": 66,
    "AT_MOST": 67,
    "LESSER": 68,
    "GREATER": 69,
    "ANGLE_OF": 70,
    "NEAR": 71,
    "APART": 72,
    "LENGTH_OF": 73,
    "TURN_OF": 74,
    "BITS_AND": 75,
    "BITS_OR": 76,
    "BITS_XOR": 77,
    "EQUAL": 78,
    "UNEQUAL": 79,
    "TRUNC": 80,
    "SQUARE": 81,
    "NEGATED": 82,
    "FRACTION": 83,
    "LOG_10": 84,
    "SIGN_OF": 85,
    "ARC_OF": 86,
    "MINUS": 87,
    "CEILING": 88,
    "BITS_NOT": 89,
    "AWAY": 90,
    "PLUS": 91,
    "JOIN": 95,
}
#: Numbers of each table, at most: they stand in the parser itself, where each is found in one step.
MOST = {
    "action": 16_384,
    "goto": 8_192,
    "lead": 32_768,
    "again": 16_384,
    "move": 32_768,
    "token": 32_768,
    "to": 512,
    "length": 256,
    "origin": 256,
    "made": 256,
    "classes": 256,
    "mode": 256,
    "literal": 512,
}
#: Numbers by themselves.
#: MAX_LINE: the longest line (`source.MAX_LINE`).
#: DELETED, NUMBERED, REFUSED, COMPUTED_LABEL: marks of a line, beside its code. SAYS: of a language, that it has instructions; from LETTERS
#: on stand the letters of its words.
#: COMPUTED: bit of `gcode_names.named`, behind those of A to Z: a G or M number is computed.
#: CODE_NUMBERS: codes that it tells apart, in tenths: those of G, then those of M.
#: ARGUMENTS: of its `calls`: the words beside the program's number are arguments and name no axis.
#: ROW: columns of the row of a line that is kept.
NUMBERS = {
    "MAX_LINE": 65_536,
    "DELETED": 1,
    "NUMBERED": 2,
    "REFUSED": 4,
    "COMPUTED_LABEL": 8,
    "SAYS": 16,
    "LETTERS": 8,
    "COMPUTED": 1 << 26,
    "CODE_NUMBERS": 4000,
    "ARGUMENTS": 128,
    "ROW": 8,
}
#: Columns of the row of a line that is kept (`gcode_lines.Lines`): offset and number of the line, where its code begins, offset of the next
#: line, the row of that (-1 for none yet), its marks, the row of its O-word (-1 for none yet), and where its constants begin.
LINE_COLUMNS = ("AT", "NUMBER_OF_LINE", "CODE", "AFTER", "FOLLOWING", "MARKS", "MARK", "FIRST_CONSTANT")
#: Kinds of bytes of a shape (`gcode_lines.Shapes`) beside those that stand for themselves: refused bytes, the end of the line, digits;
#: and the forms of numbers, 1, 1.5 and .5, which stand in shapes.
SHAPE_BYTES = (
    "SHAPE_UNKNOWN", "SHAPE_LINE_END", "SHAPE_DIGIT", "SHAPE_WHOLE", "SHAPE_DOTTED", "SHAPE_POINT_FIRST",
)  # fmt: skip
#: Columns of the row of a shape: its sum, where it stands in the store (-1: nowhere) with the signs of its numbers behind it, its length,
#: and common data of its lines: the begin of their code, and their marks.
SHAPE_COLUMNS = (
    "SHAPE_SUM",
    "SHAPE_PLACE",
    "SHAPE_LENGTH",
    "SHAPE_CODE",
    "SHAPE_MARKS",
    "SHAPE_NEXT",
    "SHAPE_ROW",
)
#: Columns of the row of an O-word (`gcode_marks.Marks`): byte offset and number of its line, the rows of the line and of the next one (-1
#: for none yet), keyword, label, and the O-words that it leads to (-1 where it leads nowhere for certain).
MARK_COLUMNS = ("OFFSET", "LINE", "HERE", "BEHIND", "KEYWORD", "LABEL", "TARGET", "OTHER")
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
ASIDES = {
    "ASIDE_SPEED": 1,
    "ASIDE_DWELL": 2,
    "ASIDE_PAUSE": 10,
    "ASIDE_EXACT": 11,
    "ASIDE_PATH": 12,
    "ASIDE_TOOL": 13,
}
#: Slots of the words of a block (`gcode_words`): axes, offsets, R, F, and behind those of plain motions S P Q L T; G and M have none.
SLOTS = "xyzabcuvwijkrfspqltgm"
#: Sets of slots, a bit each.
SETS_OF_WORDS = {
    "ANY_AXIS": "xyzabcuvw",
    "ANY_HOLE": "xyz",
    "ANY_OFFSET": "ijk",
    "WITH_R": "r",
    "WITH_F": "f",
    "WITH_S": "s",
    "WITH_P": "p",
    "WITH_Q": "q",
    "WITH_L": "l",
    "WITH_T": "t",
    "RARE": "spqlt",
}
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
