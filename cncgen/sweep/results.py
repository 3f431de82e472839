"""The folder of results: Parquet parts that only the driver writes, each renamed into place when it is complete.

``part-*.parquet`` together are the table, a row a job; other readers can open the folder directly. ``_sweep.toml`` is the sweep that
made it, ``_points.arrow`` says which row is the job of which point, ``_lock`` keeps a second driver out. Names that begin with ``_`` are not data to pyarrow, pandas and polars.
"""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from cncgen.diagnostics import Diagnostic, UsageError
from cncgen.files import OutputFile, file_fault
from cncgen.sweep.jobs import JobOutcome, Place
from cncgen.sweep.quantities import Value

if TYPE_CHECKING:
    import pyarrow

#: Columns that stand before those of the quantities and figures, and after them.
FIRST, LAST = ("key", "program", "machine", "point"), ("code", "error")
_SWEEP, _POINTS, _LOCK = "_sweep.toml", "_points.arrow", "_lock"


@dataclass(frozen=True, slots=True)
class DrawnDesign:
    """The design of a sweep, as its results remember it.

    Attributes:
        design, points, seed, shares: Arguments of `designs.unit_points`.
        columns: Names of the dimensions.
        levels: Of each dimension, how many levels its list has; 0 of a range or a distribution.
        figures: Names.
        groups: Names of program and machine of each group of jobs, and the keys of its points, shape (points,).
    """

    design: str
    points: int
    seed: int
    shares: tuple[tuple[float, ...], ...]
    columns: tuple[str, ...]
    levels: tuple[int, ...]
    figures: tuple[str, ...]
    groups: Mapping[tuple[str, str], Sequence[str]]


def needed_pyarrow() -> ModuleType:
    """Import pyarrow with its Parquet module.

    Raises:
        UsageError: It is missing.
    """
    try:
        import pyarrow
        import pyarrow.compute
        import pyarrow.csv
        import pyarrow.feather
        import pyarrow.parquet
    except ImportError as error:
        hint = "pip install 'cncgen[sweep]'"
        raise UsageError(
            Diagnostic("missing-package", "results of a sweep need pyarrow", hint=hint)
        ) from error
    module: ModuleType = pyarrow
    return module


class ResultsFolder:
    """A folder of results.

    Args:
        path: The folder; `prepare` makes it.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._next = 0

    def prepare(self) -> None:
        """Make the folder.

        Raises:
            UsageError: It cannot be made, or holds other files than results.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            names = sorted(entry.name for entry in self.path.iterdir())
        except OSError as error:
            raise file_fault(self.path, "write", error) from error
        foreign = [name for name in names if not _is_ours(name)]
        if foreign and not (self.path / _SWEEP).exists():
            text = f"{self.path} holds other files than results of a sweep: {', '.join(foreign[:3])}"
            raise UsageError(Diagnostic("sweep-folder", text, hint="give -o a folder of its own"))
        for name in names:
            if name.startswith(".part-"):  # of a driver that was killed while it wrote
                (self.path / name).unlink(missing_ok=True)

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other drivers out of the folder during a with block; the lock ends with the process, however that ends.

        Raises:
            UsageError: Another driver writes to it, or nobody can.
        """
        try:
            lock = open(self.path / _LOCK, "ab")  # noqa: SIM115 - closed below; faults of the body are not those of opening
        except OSError as error:
            raise file_fault(self.path / _LOCK, "write", error) from error
        with lock as file:
            try:
                import fcntl
            except ImportError:  # not a POSIX system
                yield
                return
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                text = f"another sweep writes to {self.path}"
                raise UsageError(Diagnostic("sweep-locked", text)) from error
            yield

    def remember(self, text: str) -> None:
        """Write the sweep's own text beside its results."""
        _written(self.path / _SWEEP, text.encode())

    def sought(self) -> tuple[str | None, dict[str, float]]:
        """Return the figure that the search of these results minimises, and the bounds of others; None and {} for other sweeps."""
        try:
            search = tomllib.loads((self.path / _SWEEP).read_text(encoding="utf-8"))["search"]
            return str(search["minimise"]), {name: float(to) for name, to in search.get("under", {}).items()}
        except (OSError, ValueError, LookupError, TypeError, AttributeError):
            return None, {}  # another sweep, or a text that was changed by hand

    def remember_design(self, design: DrawnDesign) -> None:
        """Write which row is the job of which point."""
        pyarrow = needed_pyarrow()
        about = asdict(design) | {"groups": None}
        rows = [(program, machine, key) for (program, machine), keys in design.groups.items() for key in keys]
        names = ("program", "machine", "key")
        table = pyarrow.table(
            {
                name: pyarrow.array([row[k] for row in rows], pyarrow.string()).dictionary_encode()
                for k, name in enumerate(names)
            }
        ).replace_schema_metadata({"design": json.dumps(about)})
        sink = pyarrow.BufferOutputStream()
        pyarrow.feather.write_feather(table, sink, compression="uncompressed")
        _written(self.path / _POINTS, bytes(sink.getvalue()))

    def design(self) -> DrawnDesign | None:
        """Return the design of the sweep that made the results; None of a search, which has none.

        Raises:
            UsageError: The folder holds no results.
        """
        if not (self.path / _SWEEP).is_file():
            hint = "cncgen sweep SWEEP.toml -o RESULTS/ makes them"
            raise UsageError(
                Diagnostic("sweep-folder", f"{self.path} holds no results of a sweep", hint=hint)
            )
        path = self.path / _POINTS
        if not path.is_file():
            return None
        pyarrow = needed_pyarrow()
        try:
            table = pyarrow.feather.read_table(path, memory_map=False)
            about = json.loads(table.schema.metadata[b"design"])
        except (OSError, ValueError, KeyError, TypeError, pyarrow.ArrowException) as error:
            text = f"cannot read {path}: {str(error).partition(chr(10))[0]}"
            raise UsageError(Diagnostic("sweep-part", text, hint="run the sweep again")) from error
        groups: dict[tuple[str, str], list[str]] = {}
        for row in zip(
            *(table.column(name).to_pylist() for name in ("program", "machine", "key")), strict=True
        ):
            groups.setdefault((row[0], row[1]), []).append(row[2])
        about["shares"] = tuple(tuple(column) for column in about["shares"])
        fixed = {name: tuple(about[name]) for name in ("columns", "levels", "figures")}
        return DrawnDesign(**{**about, **fixed, "groups": groups})

    def parts(self) -> list[Path]:
        """Return the parts in the order in which they were written."""
        return sorted(self.path.glob("part-*.parquet"))

    def states(self) -> dict[str, bool]:
        """Return the key of each row with whether its job failed.

        Raises:
            UsageError: A part cannot be read.
        """
        pyarrow = needed_pyarrow()
        found: dict[str, bool] = {}
        for path in self.parts():
            table = _read(pyarrow, path, ["key", "code"])
            codes = table.column("code").to_pylist()
            found.update(zip(table.column("key").to_pylist(), (bool(code) for code in codes), strict=True))
        return found

    def figures(self, names: Sequence[str]) -> dict[str, dict[str, float | None]]:
        """Return figures of each row by its key, without those of jobs that failed.

        Raises:
            UsageError: A part cannot be read, or lacks a figure.
        """
        pyarrow = needed_pyarrow()
        found: dict[str, dict[str, float | None]] = {}
        for path in self.parts():
            table = _read(pyarrow, path, ["key", *names])
            for row in table.to_pylist():
                found[row.pop("key")] = row
        return found

    def table(self) -> pyarrow.Table:
        """Return all rows by program, machine and point.

        Raises:
            UsageError: A part cannot be read.
        """
        pyarrow = needed_pyarrow()
        tables = [_read(pyarrow, path, None) for path in self.parts()]
        if not tables:
            raise UsageError(Diagnostic("sweep-folder", f"{self.path} holds no rows yet"))
        whole = pyarrow.concat_tables(tables, promote_options="default")
        return whole.sort_by([(name, "ascending") for name in ("program", "machine", "point")])

    def drop_failed(self) -> int:
        """Remove the rows of jobs that failed, so that they are missing and will be done; return how many."""
        pyarrow = needed_pyarrow()
        dropped = 0
        for path in self.parts():
            table = _read(pyarrow, path, None)
            kept = table.filter(pyarrow.compute.is_null(table.column("code")))
            dropped += len(table) - len(kept)
            if not len(kept):
                path.unlink()
            elif len(kept) < len(table):
                _written(path, _as_parquet(pyarrow, kept))
        return dropped

    def write(self, rows: Sequence[tuple[Place, JobOutcome]], layout: RowLayout) -> None:
        """Write rows as the next part."""
        pyarrow = needed_pyarrow()
        while (path := self.path / f"part-{self._next:06d}.parquet").exists():
            self._next += 1
        _written(path, _as_parquet(pyarrow, layout.table(pyarrow, rows)))
        self._next += 1


class RowLayout:
    """The columns of a sweep's table: key and place, a column a quantity, a column a figure, diagnostic.

    Args:
        quantities: Columns of the quantities, with whether their values are text, truth values or numbers.
        figures: Names.
    """

    def __init__(self, quantities: Mapping[str, type], figures: Sequence[str]) -> None:
        self.quantities, self.figures = dict(quantities), tuple(figures)

    def table(self, pyarrow: ModuleType, rows: Sequence[tuple[Place, JobOutcome]]) -> pyarrow.Table:
        """Return rows as a table."""
        text, number = pyarrow.string(), pyarrow.float64()
        types = {str: text, bool: pyarrow.bool_()}
        columns: dict[str, Any] = {
            "key": pyarrow.array([outcome.key for _, outcome in rows], text),
            "program": pyarrow.array([place.program for place, _ in rows], text),
            "machine": pyarrow.array([place.machine for place, _ in rows], text),
            "point": pyarrow.array([place.point for place, _ in rows], pyarrow.int64()),
        }
        for k, (name, kind) in enumerate(self.quantities.items()):
            values = [place.values[k] for place, _ in rows]
            typed = values if kind in types else [float(value) for value in values]
            columns[name] = pyarrow.array(typed, types.get(kind, number))
        for name in self.figures:
            columns[name] = pyarrow.array([outcome.figures.get(name) for _, outcome in rows], number)
        columns["code"] = pyarrow.array([outcome.code or None for _, outcome in rows], text)
        columns["error"] = pyarrow.array([outcome.error or None for _, outcome in rows], text)
        return pyarrow.table(columns)


def kind_of(values: Sequence[Value]) -> type:
    """Return the type of a column that holds such values: text, truth values or numbers."""
    if all(isinstance(value, bool) for value in values):
        return bool
    return str if any(isinstance(value, str) for value in values) else float


def _is_ours(name: str) -> bool:
    return name in (_SWEEP, _POINTS, _LOCK) or name.lstrip(".").startswith("part-")


def _read(pyarrow: ModuleType, path: Path, columns: list[str] | None) -> pyarrow.Table:
    try:
        return pyarrow.parquet.read_table(path, columns=columns)
    except (OSError, pyarrow.ArrowException) as error:
        text = f"cannot read {path}: {str(error).partition(chr(10))[0]}"
        hint = "remove the part: the sweep does its rows again"
        raise UsageError(Diagnostic("sweep-part", text, hint=hint)) from error


def _as_parquet(pyarrow: ModuleType, table: pyarrow.Table) -> bytes:
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table, sink)
    return bytes(sink.getvalue())


def _written(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, at once: not at the end of the command, as other outputs."""
    file = OutputFile(path)
    try:
        file.write(content)
        file.commit()
    finally:
        file.discard()
