"""The usual intention where the grammar finds something else: one line of help for a syntax error."""

from __future__ import annotations

import re

from cncgen.kernels.gcode_codes import KEYWORDS, LITERALS

#: Patterns of the text before the place (matched at its end) and of the text there, and the help.
_HINTS = tuple(
    (re.compile(before + r"\Z"), re.compile(there), text)
    for before, there, text in (
        (r"[0-9.]", r",[0-9]", "the decimal sign is a point"),
        (r"", r",[rc]", "chamfers ,C and roundings ,R are FANUC's: --dialect fanuc reads them"),
        (r"c", r"r=", "CR= is a radius on Siemens' controls; here it is R"),
        (r"[0-9]\.[0-9]*", r"\.", "a number has one decimal point"),
        (r"[0-9.]", r"o", "is the letter O meant as a zero?"),
        (r"[0-9]", r"(?!if\[)[il]", "is the letter meant as a one?"),
        (r"[0-9]", r"['_`’][0-9]", "numbers have no separators"),
        (r"[o#]", r"<", "is the > of the name missing?"),
        (r"o[0-9]+", r"\.", "a label is a whole number or a name: o100, o<pocket>"),
        (r"call|return|endsub", r"[#0-9.+-]", "values stand in brackets: o100 call [#1] [2]"),
        (r"(?:[-+*/\[]|and|xor|or|eq|ne|gt|ge|lt|le|mod)", r"\]", "a value is missing before the ]"),
        (r"[a-mp-z]", r"=", "a word is a letter and its number (X5); = sets parameters (#5=3)"),
        (
            r"#",
            r"[a-z]",
            "the name of a parameter stands in < >: #<depth>; a comment stands in ( ) or behind ;",
        ),
        (r"#", r"[-+=]", "the number of a parameter is whole, or computed in [ ]: #5, #[#1+1]"),
        (r"=", r"[a-z]", "a parameter is set to a value, not to a word: #1=5"),
        (r"#(?:[0-9]+|<[^>]*>)(?:=|[0-9])?", r"\Z", "a parameter is set with = and a value: #1=5"),
        (r"[0-9.\]>]", r"[+*-]", "a sum stands in brackets: X[10-5]"),
        (r"(?:if|while|do|end)", r"[#0-9]", "the condition stands in brackets: IF[#1 EQ 2] GOTO 10"),
        (r"if\[.*\]", r"", "IF[…] is followed by GOTO and a line number, or by THEN"),
        (r"while\[.*\]", r"", "WHILE[…] is followed by DO and the number of its loop"),
        (r"[0-9\]]", r"if\[", "IF[…] begins a line of its own"),
        (r"do|end", r"\Z", "DO and END have the number of their loop: END 1"),
        (r"goto", r"", "GOTO is followed by the N word of a line: GOTO 10 goes to N10"),
        (r".", r"n[0-9]", "the line number N stands first in a block"),
        (r"", r"//|[{*]", "a comment stands in ( ) or behind ;"),
        (r"/", r"/", "a comment stands in ( ) or behind ;"),
        (r"", r"/", "/ stands first in a block (block delete), or divides within brackets"),
        (r"", r"[\u2010-\u2015\u2212]", "this is a dash, not the minus sign -"),
        (r"", r"[\u00a0\u2000-\u200f\u202f\u3000\ufeff]", "a blank that only documents have: type it anew"),
        (r"", r"[\x00-\x1f\x7f]", "a character that controls a line or a printer: delete it"),
        (r"", r"[\"'“”„‘’]", "there is no text in quotes; a comment stands in ( ) or behind ;"),
        (r"", r"[°º]", "angles are in degrees, without a sign for it"),
    )
)
#: The same within open brackets.
_IN_BRACKETS = tuple(
    (re.compile(there), text)
    for there, text in (
        (r"[<>=!]", "comparisons are words: EQ NE GT GE LT LE"),
        (r"eq|ne|g[te]|l[te]", "AND and OR bind before comparisons: [[#1 EQ 1] AND [#2 EQ 2]]"),
        (r"\^", "a power is **: [2**3]"),
        (r"%", "the remainder is MOD: [5 MOD 2]"),
        (r"[&|]", "logic is words: AND OR XOR"),
        (r"\(", "brackets of expressions are [ ]; ( ) is a comment"),
        (r",", "only ATAN has two values"),
        (r"\Z|[a-z]", "is a ] missing?"),
    )
)
#: Names that FANUC's controls have for variables and parameters, within brackets too.
_NAMES_OF_FANUC = tuple(
    (re.compile(before + r"\Z"), re.compile(there), text)
    for before, there, text in (
        (
            r"#\[?",
            r"_[a-z_]+\[",
            "the names of FANUC's system variables are not read, their numbers are: #5001 is #_ABSIO[1], #5021 #_ABSMT[1], #5041 #_ABSOT[1], #5061 #_ABSKP[1]",
        ),
        (r"#", r"_[a-z]", "the name of a parameter stands in < >: #<_depth>"),
        (r"#\[", r"[a-z]+\]", "names that SETVN gives to variables are not read: their numbers are, #500"),
        (r"", r"prm\[", "PRM[ ] reads a parameter of the control, which is not known here: write its value"),
    )
)
_KEYWORDS = tuple(KEYWORDS)
_FUNCTIONS = (
    "atan",
    "exists",
    *(n for n, k in LITERALS.items() if LITERALS["abs"] <= k <= LITERALS["tan"] and n[-1] != "["),
)
_STARTS_WITH_NUMBER = re.compile(r"\A[0-9]")
_PROGRAM_NUMBER = re.compile(r"\A0[0-9]{3,4}(?:\(|\Z)")
_WORDLESS = re.compile(r"(?:\A|[^a-z])([a-mp-z])[+-]?\Z")
_VALUE = re.compile(r"\Z|[a-z(;]")
_LETTERS = re.compile(r"[a-z]+")
_LABEL = re.compile(r"o(?:[0-9]+|<[^>]*>)\Z")
_FUNCTION = re.compile(rf"({'|'.join(_FUNCTIONS)})\Z")
_JOINED = re.compile(r"\A(?:if|while)\[.*\](?:\|and|a\|nd|\|x?or|x\|or)\[")
_BRANCH = re.compile(r"(?:n[0-9]+)?(?:else(?:if)?|endif)(?:[\[(;]|\Z)")
_UNIT = re.compile(r"[0-9.](?:m\Z|i\Z)")


def hint_for(before: str, there: str) -> str:
    """Return a line of help for a place in a normalised block, by the text before it and from it on."""
    if not before and _PROGRAM_NUMBER.match(there):
        return "is the zero meant as the letter O of a program number: O1000?"
    if not before and _STARTS_WITH_NUMBER.match(there):
        return "a block begins with a letter: is N missing before the number?"
    if _LABEL.search(before) and _LETTERS.match(there):
        return (
            _meant(there, _KEYWORDS)
            or "an O-word is SUB, CALL, IF, WHILE …; a program number stands alone on its line"
        )
    name = _FUNCTION.search(before)
    if name and not there.startswith("["):
        return _meant(name[1] + there, _FUNCTIONS) or "the argument of a function stands in brackets: SIN[30]"
    for left, right, text in _NAMES_OF_FANUC:
        if right.match(there) and left.search(before):
            return text
    meant = _meant(there, _FUNCTIONS) if re.match(r"[a-z]+\[", there) else ""
    if meant:
        return meant
    if before.count("[") > before.count("]") and not there.startswith("]"):
        return next((text for pattern, text in _IN_BRACKETS if pattern.match(there)), "")
    for left, right, text in _HINTS:
        # The text there decides sooner, and a search through the text before it takes longer.
        if right.match(there) and left.search(before):
            return text
    return ""


def _meant(there: str, known: tuple[str, ...]) -> str:
    """Return a guess which of the known words was meant by the letters that stand there, or ""."""
    import difflib

    letters = _LETTERS.match(there)
    if letters is None or letters[0] in known:
        return ""
    near = difflib.get_close_matches(letters[0], known, 1)
    return f"is {near[0].upper()} meant?" if near else ""


def number_hint(letter: str, before: str, there: str) -> str:
    """Return the help for a letter without its number."""
    if _UNIT.search(before) and re.match(r"m|n(?![0-9])", there):
        return "numbers have no units: G21 says that they are mm, G20 inches"
    if there.startswith("o"):
        return f"is the letter O meant as a zero: {letter}0…?"
    return f"write {letter} with its value"


def branch_fault(before: str, there: str) -> tuple[str, str] | None:
    """Return message and help for a branch as other languages write it: conditions without brackets around them, ELSE, ENDIF."""
    if _JOINED.search(before + "|" + there):
        return (
            "conditions are joined outside of brackets",
            "one pair holds them all: IF[[#1 EQ 1] AND [#2 EQ 2]]",
        )
    if _BRANCH.match(before + there):
        hint = "IF[…] GOTO 10 leads past lines, IF[…] THEN takes one statement in its line; LinuxCNC's o1 else has a label"
        return "ELSE, ELSEIF and ENDIF do not stand alone", hint
    return None


def missing_number(before: str, there: str) -> str:
    """Return the letter that stands without its number before a place, or ""."""
    match = _WORDLESS.search(before)
    return match[1].upper() if match and _VALUE.match(there) else ""
