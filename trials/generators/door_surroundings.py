"""What surrounds a command as inputs of doors: its environment, the words that a shell completes, names that notebooks show.

A case of the first is lines of the environment, `door_commands.MARK`, and the words of a command, separated by NUL bytes.
"""

from __future__ import annotations

import random

from trials.generators import door_inputs, door_options
from trials.generators.door_commands import MARK

#: Variables that libraries, shells or commands look at.
VARIABLES = (
    "HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_RUNTIME_DIR", "MPLCONFIGDIR", "MPLBACKEND", "TMPDIR", "TEMP", "NO_COLOR", "FORCE_COLOR", "CLICOLOR", "COLUMNS", "LINES",
    "LANG", "LC_ALL", "LC_NUMERIC", "LANGUAGE", "TERM", "TZ", "PATH", "CC", "CFLAGS", "BROWSER", "DISPLAY", "PAGER", "SHELL", "USER", "PWD", "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS", "ARROW_DEFAULT_MEMORY_POOL", "HDF5_USE_FILE_LOCKING", "CNCGEN_TRACEBACK",
)  # fmt: skip
SETTINGS = (
    "", " ", "0", "-1", "1", "9" * 400, "nan", "C", "POSIX", "en_US.UTF-8", "de_DE", "x" * 5000, "/", ".", "/dev/null", "/dev/full", "/proc", "/no/such/folder", "p.nc",
    "dumb", "Agg", "nonsense", "'", '"', "cc '", "true", "cat", "/etc/passwd", "$(x)", "%s", "\x1b[31m", "\u202e", "\udcff", "a:b", "*",
)  # fmt: skip
#: Words of a completion.
_PARTS = ("cncgen", "plan", "-", "--", "--m", "-m", "sweep", "run", "machines", "", " ", "'", '"', "\\", "$(x)", "\x1b[31m", "\udcff", "x" * 3000, "p.n", "--format", "a=b", "explain", "9" * 400)  # fmt: skip


def seeds() -> list[bytes]:
    """Return commands in an environment that sets nothing."""
    compiled = b"\0".join([b"simulate", b"--axis-params", b"m.toml", b"--fmu", b"o.fmu"])
    return [MARK + words for words in (*door_options.seeds(), *[compiled] * 4)]


def change(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Set one to four variables."""
    words = rng.choice(sources).partition(MARK)[2]
    lines = [f"{rng.choice(VARIABLES)}={rng.choice(SETTINGS)}\n" for _ in range(rng.randint(1, 4))]
    return "".join(lines).encode("utf-8", "surrogateescape") + MARK + words


def parts_of(data: bytes) -> tuple[dict[str, str], list[str]]:
    """Return the variables that a case sets, and the words of its command."""
    lines, _, words = data.decode("utf-8", "surrogateescape").partition(MARK.decode())
    pairs = (line.partition("=")[::2] for line in lines.replace("\0", "").split("\n"))
    return {name: value for name, value in pairs if name}, words.split("\0")


def completion(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Return a line that a shell completes, and the word that the cursor is at."""
    line = " ".join(rng.choice(_PARTS) for _ in range(rng.randint(1, 6)))
    at = rng.choice(["0", "1", "2", "3", "-1", "99", "x", "", "9" * 5000])
    shell = rng.choice(["bash", "zsh", "fish", "nonsense"])
    return "\n".join([shell, at, line]).encode("utf-8", "surrogateescape")


def name(rng: random.Random, data: bytes, sources: list[bytes]) -> bytes:
    """Return a name: of a program, a machine, a message."""
    pieces = [
        "<script>",
        "</td>",
        "&",
        '"',
        "'",
        "\0",
        "\n",
        "\x1b[31m",
        "\u202e",
        "{0}",
        "%s",
        "x" * 3000,
        "a",
        "\\",
        "$",
        "`",
        "]]>",
        "<!--",
    ]
    if rng.random() < 0.3:
        return door_inputs.change(rng, data, sources)
    return "".join(rng.choice(pieces) for _ in range(rng.randint(1, 5))).encode()
