"""Mutants of G-code programs: bytes flipped, tokens swapped in, lines doubled, cut or taken from another program."""

from __future__ import annotations

import random
from pathlib import Path

from trials.peer_cases import peer_cases

ROOT = Path(__file__).resolve().parents[2]
#: Inputs are cut to this length.
MAX_BYTES = 20_000

TOKENS = [
    *"GMTFSXYZABCUVWIJKPQRLHDEON@^$#%/*[]()<>;=+-.,!&\\ \t\r\n\0",
    *(f"G{n}" for n in ["0", "1", "2", "3", "4", "5", "5.1", "5.2", "5.3", "6.2", "7", "8", "10", "17", "18", "19", "20", "21", "28", "30", "33", "38.2", "40", "41.1", "42.1", "43.1", "49"]),
    *(f"G{n}" for n in ["50", "51", "52", "53", "54", "61", "64", "65", "66", "67", "68", "70", "71", "73", "76", "80", "81", "83", "84", "87", "90", "91", "92", "93", "95", "96", "98", "99"]),
    *(f"M{n}" for n in ["0", "2", "3", "5", "6", "19", "30", "48", "50", "61", "62", "66", "67", "70", "72", "73", "98", "99", "100"]),
    "o1 sub\n", "o1 endsub\n", "o1 call [1]\n", "o2 while [1]\n", "o2 endwhile\n", "o3 if [#1 GT 0]\n", "o3 else\n",
    "o3 endif\n", "o4 repeat [999999999]\n", "o4 endrepeat\n", "o2 break\n", "o1 return [2]\n", "o5 do\n", "O9000\n",
    "#1=", "#<a>", "#<_x>", "##1", "[#1 + 1]", "ATAN[1]/[0]", "SQRT[-1]", "EXP[999]", "1e9", "99999999999999999999",
    "-0", "0.0000000001", "[[[[[[[[", "WHILE [1 EQ 1] DO1\n", "END1\n", "IF [#1 LT 3] GOTO 10\n", "GOTO 99\n", "N10 ",
    "DO2\n", "END2\n", "DPRNT[X#1[53]]\n", "POPEN\n", ":12\n", "/3", "POW[2,3]", "#3000=1(A)\n", "#3001", "#5041", "#2001=", "#5221=", "G10 L50\n", "G11\n",
    "G16", "G53", "G54 P2", "G29 X1\n", "G33 Z1 F2\n", "G92 S100\n", "M29", "M31", "M198 P2\n", "G66 P12\n",
    "G50 S2000\n", "G71 U2. R1.\n", "G71 P1 Q2 U.4 W.1\n", "G70 P1 Q2\n", "G73 U4. W1. R3\n", "N1 G0 X20.\n", "N2 X50.\n",
    "G76 P021060 Q80\n", "G76 X18. Z-20. P900 Q200 F1.5\n", "G75 X10. Z-9. P2000 Q1500\n", "G92 X20. Z-9. F1.\n", "U-4.", "W1.",
    "T0101\n", "G32 Z-9. F1.\n", ",R2.", ",C1.", "M97 P1\n", "G154 P3\n",
    "(MSG,", "(debug, #1)", "(START, X1)", "\u00e9", "\ufeff", "%\n", "M98 P1 L99999\n", "G65 P9000 A1\n",
]  # fmt: skip


def corpus() -> list[bytes]:
    """Return the programs that mutants are made of."""
    folders = [ROOT / "programs", ROOT / "programs" / "bad"]
    files = sorted(f for folder in folders for f in folder.glob("*") if f.suffix in {".nc", ".ngc", ".gcode"})
    texts = [f.read_bytes() for f in files] + [case.program.encode() for case in peer_cases()]
    return [text[:MAX_BYTES] for text in texts]


def mutated(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Return a program with up to twenty things changed; one of ten is of tokens alone."""
    out = bytearray(data)
    if rng.random() < 0.1:
        out = bytearray(
            "".join(rng.choices(TOKENS, k=rng.choice([1, 2, 5, 10, 20, 20, 200]))).encode("utf-8", "replace")
        )
    for _ in range(rng.choice([1, 1, 2, 2, 3, 3, 5, 20])):
        _mutate(rng, out, sources)
    return bytes(out[:MAX_BYTES])


def _mutate(rng: random.Random, data: bytearray, sources: list[bytes]) -> None:
    """Change one thing."""
    at = rng.randint(0, len(data))
    kind = rng.randrange(7)
    if kind == 0 and at < len(data):
        data[at] = rng.randrange(256)
    elif kind == 1:
        data[at:at] = rng.choice(TOKENS).encode("utf-8", "replace")
    elif kind == 2:
        del data[at : at + rng.randint(1, 30)]
    elif kind == 3:
        lines = bytes(data).split(b"\n")
        where = rng.randrange(len(lines))
        lines[where:where] = [lines[rng.randrange(len(lines))]] * rng.choice([1] * 15 + [2] * 8 + [300])
        data[:] = b"\n".join(lines)
    elif kind == 4:
        other = rng.choice(sources).split(b"\n")
        begin = rng.randrange(len(other))
        data[at:at] = b"\n" + b"\n".join(other[begin : begin + rng.randint(1, 8)]) + b"\n"
    elif kind == 5:
        data[at:at] = str(rng.choice([0, 1, -1, 1e6, 2**31, 0.1, 1e-9, rng.uniform(-100, 100)])).encode()
    else:
        data[at:at] = bytes([rng.randrange(32, 127)]) * rng.choice([1, 3, 1000])
