"""The text of lines beside their times."""

from __future__ import annotations

from pathlib import Path

from cncgen.report.source_lines import source_lines


def test_lines_of_several_files(tmp_path: Path) -> None:
    main, sub = str(tmp_path / "main.nc"), str(tmp_path / "sub.nc")
    Path(main).write_bytes(b"%\r\n  N10 G1\tX1 (caf\xc3\xa9)\r\nM98 P2\x07\n")
    Path(sub).write_bytes(b"G1 X" + b"1" * 500)
    found = source_lines([(main, 3), (main, 2), (sub, 1)])
    assert found == {
        (main, 2): "N10 G1 X1 (café)",
        (main, 3): "M98 P2␇",
        (sub, 1): "G1 X" + "1" * 55 + "…",
    }


def test_lines_of_wide_text(tmp_path: Path) -> None:
    name = str(tmp_path / "wide.nc")
    Path(name).write_bytes("%\r\nG1 X1 (caf\u00e9)\r\n".encode("utf-16"))
    assert source_lines([(name, 2)]) == {(name, 2): "G1 X1 (caf\u00e9)"}


def test_what_cannot_be_read_has_no_text(tmp_path: Path) -> None:
    (tmp_path / "short.nc").write_text("M2\n")
    missing = [str(tmp_path / "none.nc"), str(tmp_path), "-", "\x00", str(tmp_path / "short.nc")]
    assert source_lines((name, 2) for name in missing) == {}
    assert source_lines([]) == {}
