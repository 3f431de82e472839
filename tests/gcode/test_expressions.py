"""Expressions and parameters: values against plain Python, faults against the manuals' rules."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cncgen.gcode.errors import BlockError
from cncgen.gcode.text import grammar


def value(text: str, dialect: str = "linuxcnc") -> float:
    """Return the value of a constant expression."""
    ((_, found),) = grammar.parse(f"X[{text}]", dialect).words
    return found if isinstance(found, float) else found(None)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3", 7),
        ("[1 + 2] * 3", 9),
        ("2 ** 3 ** 2", 64),  # from the left
        ("-2 ** 2", 4),  # the sign belongs to the number
        ("10 - 4 - 3", 3),
        ("7 MOD 4", 3),
        ("-7 MOD 4", 1),
        ("1 LT 2 AND 3 GT 4", 0),
        ("0 OR 5", 1),
        ("1 XOR 1", 0),
        ("1 EQ 1.00001", 1),
        ("ABS[-3.5]", 3.5),
        ("ATAN[1]/[-1]", 135),
        ("ROUND[-2.5]", -3),
        ("FIX[-2.2]", -3),
        ("FUP[2.2]", 3),
        ("SIN[30]", 0.5),
        ("LN[EXP[2]]", 2),
        ("SQRT[2]", math.sqrt(2)),
        ("ACOS[0]", 90),
    ],
)
def test_values_of_linuxcnc(text: str, expected: float) -> None:
    assert value(text) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("FIX[-2.2]", -2), ("FUP[-2.2]", -3), ("6 AND 3", 2), ("6 OR 1", 7), ("6 XOR 3", 5), ("BIN[21]", 15)],
)
def test_values_of_fanuc(text: str, expected: float) -> None:
    """B-63324EN, table 15.3: FIX and FUP by magnitude, logic by bits, BIN takes decimal digits packed four bits each."""
    assert value(text, "fanuc") == expected


@given(st.integers(0, 9999))
def test_bcd_and_bin_undo_each_other(number: int) -> None:
    packed = value(f"BCD[{number}]", "fanuc")
    assert packed == int(str(number), 16)
    assert value(f"BIN[{packed:.0f}]", "fanuc") == number


@st.composite
def sums(draw: st.DrawFn) -> tuple[str, str]:
    """An expression of + - * and brackets, for us and for Python."""
    if draw(st.integers(0, 2)) == 0:
        number = f"{draw(st.integers(0, 99))}.{draw(st.integers(0, 9))}"
        return number, number
    left, right = draw(sums()), draw(sums())
    sign = draw(st.sampled_from("+-*"))
    return f"[{left[0]} {sign} {right[0]}]", f"({left[1]} {sign} {right[1]})"


@given(sums())
def test_arithmetic_is_pythons(pair: tuple[str, str]) -> None:
    assert value(pair[0]) == eval(pair[1])


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("1/0", "division-by-zero"),
        ("1 MOD 0", "division-by-zero"),
        ("SQRT[-1]", "domain"),
        ("LN[0]", "domain"),
        ("ACOS[2]", "domain"),
        ("[-8] ** 0.5", "domain"),
        ("10 ** 999", "number-range"),
        ("EXP[1000]", "domain"),
    ],
)
def test_faults_of_values(text: str, code: str) -> None:
    with pytest.raises(BlockError) as caught:
        value(text)
    assert caught.value.code == code


def ends(out: Any) -> list[list[float]]:
    """Return the end points of the motions."""
    assert out.errors == []
    return [row.tolist() for row, kind in zip(out.path.end[:, :3], out.path.kind, strict=True) if kind != 3]


def test_parameters_change_after_their_block(run: Any) -> None:
    out = run("#1=5\n#1=[#1+1] G0 X#1\nG0 X#1\n#<a b>=2 #<_G>=3\nG0 X#<ab> Y#<_g>\n##1=9 #2=1\nG0 Z#6\nM2")
    assert ends(out) == [[5, 0, 0], [6, 0, 0], [2, 3, 0], [2, 3, 9]]


def test_parameters_tell_the_state(run: Any) -> None:
    out = run(
        "G20 G0 X1 Y2\nG0 Z[#5420 + #<_y>]\nG21\nG0 Z#5420\nG0 X[#<_metric>] Y[EXISTS[#<_x>] + EXISTS[#<no>]]\nM2"
    )
    assert ends(out)[1][2] == pytest.approx(3 * 25.4)
    np.testing.assert_allclose(ends(out)[2:], [[25.4, 50.8, 25.4], [1, 1, 25.4]])


def test_parameter_file_is_read_and_written(run: Any, tmp_path: Any) -> None:
    table = tmp_path / "in.var"
    table.write_text("5221 10.5\n5222\t-2\n31 4\n")
    kept = tmp_path / "out.var"
    out = run("G0 X#31 Y0\nG10 L2 P2 Z7\nM2", parameters=table, save_parameters=kept)
    assert ends(out) == [[14.5, -2, 0]]
    again = dict(line.split() for line in kept.read_text().splitlines())
    assert (float(again["5221"]), float(again["5243"]), float(again["31"])) == (10.5, 7.0, 4.0)
    assert table.read_text() == "5221 10.5\n5222\t-2\n31 4\n"


def test_parameters_that_the_file_lists_are_kept(run: Any, tmp_path: Any) -> None:
    """A line in LinuxCNC's file makes a parameter persistent; FANUC keeps #500 to #999, where they have a value."""
    table, kept = tmp_path / "in.var", tmp_path / "out.var"
    table.write_text("500 7.5\n")
    run("#500=9 #501=4\nM2", parameters=table, save_parameters=kept)
    again = dict(line.split() for line in kept.read_text().splitlines())
    assert (float(again["500"]), "501" in again, "31" in again) == (9.0, False, False)
    run("O1\n#501=4\nM30", parameters=kept, save_parameters=kept, dialect="fanuc")
    again = dict(line.split() for line in kept.read_text().splitlines())
    assert (float(again["500"]), float(again["501"]), "502" in again) == (9.0, 4.0, False)


def test_parameters_do_not_replace_a_device(run: Any, tmp_path: Any) -> None:
    import os

    from cncgen.diagnostics import UsageError

    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    run("M2", save_parameters=tmp_path / "pipe")
    assert os.read(reader, 100_000).startswith(b"5161\t0.000000\n")
    os.close(reader)
    with pytest.raises(UsageError, match="it is a directory"):
        run("M2", save_parameters=tmp_path)


def test_a_wrong_parameter_file_names_every_fault(run: Any, tmp_path: Any) -> None:
    from cncgen.diagnostics import UsageError

    table = tmp_path / "in.var"
    table.write_text("5221 x\n\n99999 1\n; fine\n5161 1\n5161 2\n")
    with pytest.raises(UsageError) as caught:
        run("M2", parameters=table)
    assert [(d.code, d.span.line) for d in caught.value.diagnostics if d.span] == [
        ("parameter-file", 1),
        ("parameter-file", 3),
        ("parameter-file", 6),
    ]


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("%\nO1\n#1=[-7. MOD 0]\nM30\n%\n", "fanuc"),
        ("BEGIN PGM A MM\nQ1 = -7 % 0\nEND PGM A MM\n", "heidenhain"),
        ("R1=-7 MOD 0\nM30\n", "sinumerik"),
    ],
)
def test_a_remainder_without_value_shows_what_is_divided(run: Any, text: str, dialect: str) -> None:
    """With its sign, which was left out."""
    assert "-7 MOD 0 has no value" in [d.message for d in run(text, dialect=dialect).diagnostics]


@pytest.mark.parametrize(
    ("formula", "value", "said"),
    [
        ("7 MOD 4", 3.0, []),
        ("-7 MOD 4", -3.0, []),
        ("#0 MOD 4", 0.0, []),
        # 8 MOD 3, half being rounded up; that of the numbers is 0.1.
        ("#1 MOD 2.5", 2.0, ["7.6 MOD 2.5 is 2"]),
        ("7.6 MOD 2.5", 2.0, ["7.6 MOD 2.5 is 2"]),
        ("-7.6 MOD 2.5", -2.0, ["-7.6 MOD 2.5 is -2"]),
    ],
)
def test_mod_of_macro_b_is_of_whole_numbers(run: Any, formula: str, value: float, said: list[str]) -> None:
    """FANUC's series 30i rounds both operands to whole numbers first (from memory of its table of operations, hence the warning)."""
    out = run(f"%\nO1\nG21 G90\n#1=7.6\n#2={formula}\nG0 X[#2+10]\nM30\n%\n", dialect="fanuc")
    assert out.path.end[-1, 0] == value + 10.0
    assert [d.message.partition(":")[0] for d in out.diagnostics if d.code == "other-control"] == said
