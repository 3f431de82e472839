"""Numbers of what the tables of a grammar and the kernels `gcode_parse`, `gcode_marks`, `gcode_run` and `gcode_arithmetic` say to each other.

``grammars/lalr.py`` writes those of actions and literals into the tables; `gcode_parse` writes operations.
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
}
#: Bit of `Parser.named`, behind those of A to Z: a G or M number is computed.
COMPUTED = 1 << 26
#: Codes that `Parser.named` tells apart, in tenths: those of G, then those of M.
CODE_NUMBERS = 4000
#: Of its `calls`: the words beside the program's number are arguments and name no axis.
ARGUMENTS = 128
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
#: Longest line (`source.MAX_LINE`).
MAX_LINE = 65_536
#: Marks of a line, beside its code, and columns of the row of one that is kept.
DELETED = 1
NUMBERED = 2
REFUSED = 4
COMPUTED_LABEL = 8
ROW = 8
