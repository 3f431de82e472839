"""The packages: sdist to wheel to an installation that runs outside the checkout, here without a compiler."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

#: An expression and a variable go down the grammar's lane, so the grammar has to be in the package.
PROGRAM = b"G21 G90 G61 F1200\n#1=[2+3]\nG1 X#1 Y2\nG1 X[#1*2]\nG2 X20 Y2 I5 J0\nM2\n"


def run(command: list[str], cwd: Path, **variables: str) -> subprocess.CompletedProcess[bytes]:
    """Run a command with more variables in its environment."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | variables
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, timeout=280, check=False)


@pytest.fixture(scope="module")
def packages(root: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Build the sdist from what git has of the tree (and what it would add), and the uncompiled wheel from the sdist."""
    pytest.importorskip("build")
    folder = tmp_path_factory.mktemp("packages")
    source = folder / "source"
    names = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    if names.returncode:
        pytest.skip("not a git checkout")
    for name in names.stdout.splitlines():
        if (root / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, source / name)
    build = [
        sys.executable,
        "-m",
        "build",
        "--no-isolation",
        "--skip-dependency-check",
        "--outdir",
        str(folder),
    ]
    made = run([*build, "--sdist", str(source)], folder, CNCGEN_NO_COMPILE="1")
    assert made.returncode == 0, made.stderr.decode()[-3000:]
    sdist = next(folder.glob("*.tar.gz"))
    with tarfile.open(sdist) as archive:
        archive.extractall(folder / "unpacked", filter="data")
    unpacked = next((folder / "unpacked").iterdir())
    made = run([*build, "--wheel", str(unpacked)], folder, CNCGEN_NO_COMPILE="1")
    assert made.returncode == 0, made.stderr.decode()[-3000:]
    return sdist, next(folder.glob("*.whl"))


def test_contents(packages: tuple[Path, Path], root: Path) -> None:
    sdist, wheel = packages
    with tarfile.open(sdist) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    assert {
        "README.md",
        "LICENSE",
        "Makefile",
        "setup.py",
        "programs/butterfly.nc",
        "tests/conftest.py",
    } <= inside
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    shipped = (
        ("grammars/*.lark", "cncgen/"),
        ("cncgen/machine/profiles/*.toml", ""),
        ("programs/*.nc", "cncgen/"),
    )
    for pattern, prefix in shipped:
        for path in root.glob(pattern):
            assert prefix + path.relative_to(root).as_posix() in names
    assert "cncgen/py.typed" in names
    with zipfile.ZipFile(wheel) as archive:
        about = next(name for name in names if name.endswith("METADATA"))
        needed = [
            line for line in archive.read(about).decode().splitlines() if line.startswith("Requires-Dist")
        ]
    assert not [line for line in needed if "cython" in line.lower() and "extra ==" not in line]
    assert not {name for name in names if name.startswith(("tests/", "benchmarks/", "trials/", "programs/"))}


def test_a_compiler_that_fails_leaves_kernels_uncompiled(root: Path, tmp_path: Path) -> None:
    """Cython's own extensions were not optional, so that an installation without a compiler ended with an error."""
    pytest.importorskip("Cython")
    kernels = tmp_path / "cncgen" / "kernels"
    kernels.mkdir(parents=True)
    (tmp_path / "cncgen" / "__init__.py").touch()
    (kernels / "__init__.py").touch()
    (kernels / "one.py").write_text("def twice(x: float) -> float:\n    return 2 * x\n")
    script = "import runpy\nfrom setuptools import setup\nfound = runpy.run_path('setup.py')['kernel_extensions']()\n"
    (tmp_path / "made.py").write_text(script + "setup(name='made', packages=[], ext_modules=found)\n")
    shutil.copy2(root / "setup.py", tmp_path)
    made = run([sys.executable, "made.py", "build_ext", "--inplace"], tmp_path, CC="/bin/false")
    assert made.returncode == 0, made.stderr.decode()[-3000:]
    assert b"failed" in made.stdout + made.stderr
    assert not [*kernels.glob("*.so")]


def test_the_wheel_runs_outside_the_checkout_without_a_compiler(
    packages: tuple[Path, Path], tmp_path: Path
) -> None:
    _, wheel = packages
    site = tmp_path / "site"
    install = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--no-index",
        "--target",
        str(site),
    ]
    made = run([*install, str(wheel)], tmp_path)
    assert made.returncode == 0, made.stderr.decode()[-3000:]
    assert not list(site.glob("cncgen/kernels/*.so"))
    (tmp_path / "part.nc").write_bytes(PROGRAM)
    command = [sys.executable, "-m", "cncgen", "plan", "part.nc", "--feedrate", "ild"]
    plain = run(command, tmp_path, PYTHONPATH=str(site))
    assert plain.returncode == 0, plain.stderr.decode()
    assert plain.stderr.count(b"kernels run uncompiled") == 1
    papers = run([sys.executable, "-m", "cncgen", "reproduce", "000"], tmp_path, PYTHONPATH=str(site))
    assert papers.returncode == 0, papers.stderr.decode()
    where = [sys.executable, "-c", "import cncgen; print(cncgen.__file__)"]
    assert run(where, tmp_path, PYTHONPATH=str(site)).stdout.decode().startswith(str(site))
    compiled = run(command, tmp_path)
    assert compiled.returncode == 0, compiled.stderr.decode()
    ours, other = (out.decode().splitlines() for out in (compiled.stdout, plain.stdout))
    assert ours[0] == other[0] == "t_s,x_mm,y_mm"
    assert len(ours) == len(other)
    for a, b in zip(ours[1:], other[1:], strict=True):
        for x, y in zip(a.split(","), b.split(","), strict=True):
            assert float(x) == pytest.approx(float(y), abs=2e-9)


#: Refuses to import Cython, or its module `cython`.
_NO_CYTHON = """
import sys
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0].lower() == "cython":
            raise ImportError(name)
sys.meta_path.insert(0, Refused())
"""


def test_compiled_kernels_need_no_cython(root: Path) -> None:
    code = f"""{_NO_CYTHON}
import importlib
from pathlib import Path
import cncgen.kernels
assert not cncgen.kernels.uncompiled()
for path in Path(cncgen.kernels.__file__).parent.glob("*.py"):
    importlib.import_module(f"cncgen.kernels.{{path.stem}}")
assert "cncgen.kernels.plain" not in sys.modules
"""
    made = run([sys.executable, "-c", code], root)
    assert made.returncode == 0, made.stderr.decode()[-2000:]


def test_uncompiled_kernels_need_no_cython(packages: tuple[Path, Path], tmp_path: Path) -> None:
    """Every kernel loads; a plan by `optimal` is that of the compiled ones."""
    with zipfile.ZipFile(packages[1]) as archive:
        archive.extractall(tmp_path / "site")
    (tmp_path / "part.nc").write_bytes(PROGRAM)
    code = f"""{_NO_CYTHON}
import importlib
from cncgen.kernels import uncompiled
sys.meta_path.remove(sys.meta_path[0])  # the module `cython` that kernels find now is not Cython's
for name in uncompiled():
    importlib.import_module(f"cncgen.kernels.{{name}}")
assert "Cython" not in sys.modules
from cncgen.cli.app import run
sys.exit(run(["plan", "part.nc", "-o", "plain.csv"]))
"""
    made = run([sys.executable, "-c", code], tmp_path, PYTHONPATH=str(tmp_path / "site"))
    assert made.returncode == 0, made.stderr.decode()[-2000:]
    compiled = run([sys.executable, "-m", "cncgen", "plan", "part.nc", "-o", "compiled.csv"], tmp_path)
    assert compiled.returncode == 0
    ours, other = ((tmp_path / name).read_text().splitlines() for name in ("compiled.csv", "plain.csv"))
    assert len(ours) == len(other)
    for a, b in zip(ours[1:], other[1:], strict=True):
        for x, y in zip(a.split(","), b.split(","), strict=True):
            assert float(x) == pytest.approx(float(y), abs=2e-9)


def test_what_make_installs_is_the_checkout_itself(root: Path) -> None:
    """The README's example runs in its top folder, where Python finds the folder cncgen before a copy in site-packages."""
    text = (root / "Makefile").read_text(encoding="utf-8")
    assert len(re.findall(r"pip install .*--editable ", text)) == text.count("pip install") == 2


def test_wheels_are_tried_by_the_steps_of_make_demo(root: Path) -> None:
    with (root / "pyproject.toml").open("rb") as file:
        tried = tomllib.load(file)["tool"]["cibuildwheel"]["test-command"]
    demo = re.findall(r"^\t\$\(BIN\)/(cncgen .*)$", (root / "Makefile").read_text(encoding="utf-8"), re.M)
    steps = [line.replace("{project}/", "") for line in tried if line.startswith("cncgen ")]
    assert steps == [line.replace("out/", "") for line in demo]
