"""An exchange structure in memory: statements as columns, instances parsed when they are asked for."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cncgen.diagnostics import Diagnostics, Severity
from cncgen.kernels import part21_scan as scan
from cncgen.stepnc.part21.complexes import Complexes, Supertypes
from cncgen.stepnc.part21.parsing import SyntaxFault, parse_body, parse_statement
from cncgen.stepnc.part21.statements import Statements, report_faults, split
from cncgen.stepnc.part21.values import Instance, Record, Ref
from cncgen.stepnc.reporting import Reporter

#: Text that every exchange file has, however broken it is.
_OWN = re.compile(rb"ISO-10303-21|\b(?:HEADER|DATA|ENDSEC)\b|#\d+\s*=\s*[A-Z(!]", re.IGNORECASE)
_LAST_NUMBER = re.compile(rb",\s*([+-]?[0-9]+\.?[0-9]*(?:[Ee][+-]?[0-9]{1,3})?)\s*\)\s*\Z")

#: Parsed instances that are kept; beyond it the oldest half is dropped.
MAX_CACHED = 50_000
#: Characters of a statement that is parsed; a longer one is an error (a million references are 8 MB).
MAX_STATEMENT = 64_000_000

#: Statements outside DATA (header, anchors, text that is not Part 21) that are looked at.
MAX_OTHERS = 100_000

_SECTIONS = (
    "HEADER",
    "DATA",
    "ANCHOR",
    "REFERENCE",
    "SIGNATURE",
    "ENDSEC",
    "ISO-10303-21",
    "END-ISO-10303-21",
)
_POWERS = 10.0 ** np.arange(23)


def _report_stranger(data: bytes, reporter: Reporter) -> None:
    """Report a file that is something else as a whole: said of its lines, it would be a fault of each."""
    message = "this is no STEP-NC: the file does not begin with ISO-10303-21; and holds no instance (#1 = …)"
    hint = "--language gcode reads it as G-code"
    if b"\0" in data[:64]:
        hint = "is it UTF-16? save it as UTF-8 or ASCII"
    elif not data.strip() or data.lstrip().startswith(b"<"):
        hint = "is it the right file? XML (ISO 10303-28) is not read"
    reporter.report("part21-section", message, 0, hint=hint)


class Exchange:
    """The content of a Part 21 file.

    Faults of the syntax become diagnostics: those of the statements when the file is loaded, those within a
    statement when it is parsed (`instance`, `check_syntax`).

    Attributes:
        data: The bytes of the file.
        reporter: Where faults go.
        rows: All statements.
        header: The entities of the HEADER section, by keyword.
        anchors: ``<name>`` of the ANCHOR section to its value (edition 3).
        references: Names of the REFERENCE section to their resources (edition 3).
        schemas: Names in FILE_SCHEMA, in capitals, object identifiers cut off.
        comments_before: The text before the header (it holds comments).
    """

    def __init__(
        self,
        data: bytes,
        reporter: Reporter,
        aliases: Mapping[str, str] | None = None,
        supertypes: Supertypes | None = None,
    ) -> None:
        if not _OWN.search(data):
            _report_stranger(data, reporter)
            data = b""
        self.data = data
        self.reporter = reporter
        self._aliases = aliases or {}
        self.rows: Statements = split(data)
        self._resolve_aliases()
        self._complexes = Complexes(data, self.rows, supertypes or {}, self._aliases)
        report_faults(data, self.rows, reporter)
        self.header: dict[str, Record] = {}
        self.anchors: dict[str, Any] = {}
        self.references: dict[Any, Any] = {}
        self._cache: dict[int, Instance | None] = {}
        self._is_instance: NDArray[np.bool_] = np.zeros(len(self.rows), bool)
        self.comments_before = data[: self._sections()].decode("utf-8", "replace")
        self.schemas = self._schemas()
        self._index()

    @classmethod
    def load(
        cls,
        data: bytes,
        name: str = "-",
        diagnostics: Diagnostics | None = None,
        aliases: Mapping[str, str] | None = None,
        supertypes: Supertypes | None = None,
    ) -> Exchange:
        """Read a file.

        Args:
            data: Its bytes.
            name: How diagnostics call it.
            diagnostics: Where they go (a new list where None).
            aliases: Other names of entities, short to long; instances show the long ones.
            supertypes: The direct supertypes of entities; with them a complex instance of one entity is a simple one.
        """
        found = diagnostics if diagnostics is not None else Diagnostics()
        return cls(data, Reporter(name, data, found), aliases, supertypes)

    def _resolve_aliases(self) -> None:
        """Give statements under an alias the type of the long name."""
        if not self._aliases:
            return
        hashes = {
            scan.keyword_hash(a.encode()): scan.keyword_hash(n.encode()) for a, n in self._aliases.items()
        }
        short = np.array(sorted(hashes), np.int64)
        k = np.minimum(np.searchsorted(short, self.rows.types), len(short) - 1)
        found = short[k] == self.rows.types
        self.rows.types[found] = np.array([hashes[h] for h in short.tolist()], np.int64)[k[found]]

    # Sections

    def _sections(self) -> int:
        """Walk the statements other than instances; return the offset where the header ends."""
        rows = self.rows
        names = {scan.keyword_hash(s.encode()): s for s in _SECTIONS}
        special = np.flatnonzero(rows.ids < 0)
        if len(special) > MAX_OTHERS:
            self._report_row(
                int(special[MAX_OTHERS]), "part21-size", f"{len(special)} statements are not instances"
            )
            special = special[:MAX_OTHERS]
        section, began, header_end = "", -1, min(len(self.data), 65_536)
        seen: set[str] = set()
        for row in special.tolist():
            keyword = names.get(int(rows.types[row]), "") if rows.ids[row] < 0 else ""
            if keyword == "SIGNATURE" or section == "SIGNATURE":
                section = self._signature(row)
                continue
            if keyword == "" or (section == "HEADER" and keyword not in ("ENDSEC", "DATA")):
                self._inner_statement(row, section, keyword)
                continue
            seen.add(keyword)
            if keyword == "DATA":
                self._parse(row, "data_head")
            if section == "HEADER" and keyword == "ENDSEC":
                header_end = int(rows.ends[row])
            if keyword in ("ENDSEC", "DATA", "END-ISO-10303-21"):
                self._end_section(section, began, row)
                section, began = ("DATA", row) if keyword == "DATA" else ("", row)
            elif keyword != "ISO-10303-21":
                section, began = keyword, row
        self._end_section(section, began, len(rows))
        self._missing_sections(seen, whole="DATA" in seen and not section)
        return header_end

    def _end_section(self, section: str, began: int, row: int) -> None:
        inside = slice(began + 1, row)
        if section == "DATA":
            self._is_instance[inside] = self.rows.ids[inside] >= 0
        elif section == "REFERENCE":
            for k in range(began + 1, min(row, began + 1 + MAX_OTHERS)):
                pair = self._parse(k, "reference") if self.rows.ids[k] >= 0 else None
                if pair:
                    self.references[pair[0]] = pair[1]
        elif self.rows.ids[inside].max(initial=-1) >= 0:
            first = began + 1 + int(np.argmax(self.rows.ids[inside] >= 0))
            where = f"in the {section} section" if section else "outside every section"
            self._report_row(first, "part21-section", f"an instance stands {where}, not in DATA")
            self._is_instance[inside] = self.rows.ids[inside] >= 0

    def _signature(self, row: int) -> str:
        """Return the section after a statement of a signature; the signature itself is not checked.

        The standard has ``SIGNATURE`` base64 ``ENDSEC;`` in one statement; writers put a semicolon after the keyword.
        """
        return "" if self.text(row).rstrip().upper().endswith("ENDSEC") else "SIGNATURE"

    def _inner_statement(self, row: int, section: str, keyword: str) -> None:
        """Read a statement of a section other than an instance."""
        if self.rows.flags[row] & scan.UNTERMINATED:
            return
        if section == "HEADER":
            record = self._parse(row, "header_entity")
            if record:
                self.header.setdefault(record.keyword, record)
        elif section == "ANCHOR":
            anchor = self._parse(row, "anchor")
            if anchor:
                self.anchors[str(anchor[0])] = anchor[1]
        elif section == "REFERENCE":
            pair = self._parse(row, "reference")
            if pair:
                self.references[pair[0]] = pair[1]
        elif self.rows.starts[row] < self.rows.ends[row]:
            text = (
                self.data[(at := int(self.rows.starts[row])) : min(at + 30, int(self.rows.ends[row]))]
                .decode("utf-8", "replace")
                .strip()
            )
            self._report_row(
                row, "part21-section", f"{text!r} is neither an instance (#id = …) nor a section"
            )

    def _missing_sections(self, seen: set[str], whole: bool) -> None:
        """Report sections that are missing; without its last line the file is taken if its data are `whole`."""
        if not self.data:
            return
        problems = {
            "ISO-10303-21": "the file does not begin with ISO-10303-21;",
            "HEADER": "the file has no HEADER section",
            "DATA": "the file has no DATA section",
            "END-ISO-10303-21": "the file does not end with END-ISO-10303-21; (is it cut off?)",
        }
        for keyword, message in problems.items():
            if keyword not in seen:
                at = max(len(self.data) - 1, 0) if keyword.startswith("END") else 0
                severity = Severity.WARNING if whole and keyword.startswith("END") else Severity.ERROR
                self.reporter.report("part21-section", message, at, severity=severity)

    def _schemas(self) -> tuple[str, ...]:
        record = self.header.get("FILE_SCHEMA")
        names = record.parameters[0] if record and record.parameters else ()
        if not isinstance(names, tuple):
            return ()
        return tuple(n.split("{")[0].strip().upper() for n in names if isinstance(n, str))

    # Instances

    def _index(self) -> None:
        rows = np.flatnonzero(self._is_instance)
        order = rows[np.argsort(self.rows.ids[rows], kind="stable")]
        ids = self.rows.ids[order]
        double = np.flatnonzero(ids[1:] == ids[:-1]) + 1 if len(ids) else np.zeros(0, np.int64)
        for k in double[:100].tolist():
            first = self.reporter.line_of(int(self.rows.starts[order[k - 1]]))
            message = f"#{ids[k]} is defined again; line {first} defines it first"
            self._report_row(int(order[k]), "part21-duplicate", message)
        keep = np.ones(len(ids), bool)
        keep[double] = False
        self._sorted_ids, self._sorted_rows = ids[keep], order[keep]
        # Most writers number from some number on without gaps: then the number is the place.
        last = len(self._sorted_ids) - 1
        self._first = int(self._sorted_ids[0]) if last >= 0 else 0
        self._gapless = last >= 0 and int(self._sorted_ids[last]) - self._first == last

    @property
    def instance_rows(self) -> NDArray[np.int64]:
        """Return the rows of the instances in the order of the file."""
        return np.sort(self._sorted_rows)

    def row_of(self, ident: int) -> int:
        """Return the row of an instance, −1 where the file lacks it."""
        if self._gapless:
            place = ident - self._first
            return int(self._sorted_rows.item(place)) if 0 <= place < len(self._sorted_rows) else -1
        k = self._sorted_ids.searchsorted(ident)
        if k < len(self._sorted_ids) and self._sorted_ids[k] == ident:
            return int(self._sorted_rows[k])
        return -1

    def rows_of_ids(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the rows of instances, −1 where the file lacks them; shape as given."""
        if not len(self._sorted_ids):
            return np.full(len(ids), -1)
        k = np.minimum(np.searchsorted(self._sorted_ids, ids), len(self._sorted_ids) - 1)
        return np.where(self._sorted_ids[k] == ids, self._sorted_rows[k], -1)

    def rows_of_type(self, *keywords: str) -> NDArray[np.int64]:
        """Return the rows of the simple instances of those types, in the order of the file."""
        hashes = [scan.keyword_hash(k.encode()) for k in keywords]
        return np.flatnonzero(np.isin(self.rows.types, hashes) & self._is_instance)

    def instances(self, *keywords: str) -> Iterator[Instance]:
        """Yield the simple instances of those types in the order of the file."""
        for row in self.rows_of_type(*keywords).tolist():
            instance = self.at_row(row)
            if instance is not None:
                yield instance

    def instance(self, ident: int) -> Instance | None:
        """Return an instance, None where the file lacks it or its text has a fault (which is reported)."""
        row = self.row_of(ident)
        return self.at_row(row) if row >= 0 else None

    def partial_entities(self, ident: int) -> tuple[str, ...]:
        """Return the partial entities of an instance in the external mapping that has a simple form, none of any other."""
        return self._complexes.orders.get(self.row_of(ident), ())

    def at_row(self, row: int) -> Instance | None:
        """Return the instance of a row, None where its text has a fault (which is reported)."""
        if row in self._cache:
            return self._cache[row]
        if len(self._cache) >= MAX_CACHED:
            for old in list(self._cache)[: MAX_CACHED // 2]:
                del self._cache[old]
        found = self._cache[row] = self._parse_instance(row)
        return found

    def _parse_instance(self, row: int) -> Instance | None:
        begin, end = int(self.rows.bodies[row]), int(self.rows.ends[row])
        if end - begin > MAX_STATEMENT:
            self._report_row(
                row, "part21-size", f"a statement of {end - begin} bytes, more than {MAX_STATEMENT}"
            )
            return None
        text = self._decode(begin, end)
        try:
            parts = parse_body(text)
        except SyntaxFault as fault:
            self._report_syntax(row, begin, text, fault)
            return None
        if self._aliases:
            names = self._aliases
            parts = tuple(Record(names[p.keyword], p.parameters) if p.keyword in names else p for p in parts)
        return Instance(int(self.rows.ids[row]), self._complexes.merged(row, parts))

    def _parse(self, row: int, rule: str) -> Any:
        begin = int(self.rows.starts[row])
        text = self._decode(begin, min(int(self.rows.ends[row]), begin + MAX_STATEMENT))
        try:
            return parse_statement(text, rule)
        except SyntaxFault as fault:
            self._report_syntax(row, begin, text, fault)
            return None

    def _report_syntax(self, row: int, begin: int, text: str, fault: SyntaxFault) -> None:
        if self.rows.flags[row] & (scan.UNTERMINATED | scan.NO_EQUALS):
            return  # reported already
        offset = begin + len(text[: fault.offset].encode("utf-8", "replace"))
        name = f"#{self.rows.ids[row]}: " if self.rows.ids[row] >= 0 else ""
        self.reporter.report("part21-syntax", name + fault.message, min(offset, len(self.data)))

    def _decode(self, begin: int, end: int) -> str:
        raw = self.data[begin:end]
        try:
            return raw.decode("utf-8")
        except UnicodeDecodeError:
            message = "bytes that are neither ASCII nor UTF-8 are read as ISO 8859-1"
            self.reporter.report("part21-encoding", message, begin, severity=Severity.WARNING)
            return raw.decode("iso8859-1")

    def check_syntax(self, rows: NDArray[np.int64]) -> None:
        """Parse the instances of those rows for their faults, keeping none."""
        for row in rows.tolist():
            if row not in self._cache:
                self._parse_instance(row)

    # Places and bulk

    def text(self, row: int) -> str:
        """Return the text of a statement without its semicolon."""
        return self.data[int(self.rows.starts[row]) : int(self.rows.ends[row])].decode("utf-8", "replace")

    def line(self, ident: int) -> int:
        """Return the line where an instance begins, 0 where the file lacks it."""
        row = self.row_of(ident)
        return self.reporter.line_of(int(self.rows.starts[row])) if row >= 0 else 0

    @cached_property
    def row_lines(self) -> NDArray[np.int64]:
        """Return the line of every statement, shape (n,)."""
        return self.reporter.lines_of(self.rows.starts)

    def report(self, ident: int, code: str, message: str, **options: Any) -> None:
        """Report a fault of an instance at its place, or of the file where it lacks the instance."""
        row = self.row_of(ident)
        self.reporter.report(code, message, int(self.rows.starts[row]) if row >= 0 else None, **options)

    def report_missing(self, row: int, target: int) -> None:
        """Report that a statement refers to what is not in the file, at the reference (once)."""
        at = self.offset_of_reference(row, target)
        text = f"#{self.rows.ids[row]} refers to #{target}, which is not in the file"
        self.reporter.report("part21-dangling", text, at)

    def offset_of_reference(self, row: int, target: int) -> int:
        """Return where a statement refers to an instance, or where its text begins if it does not."""
        begin, end = int(self.rows.bodies[row]), int(self.rows.ends[row])
        found = re.compile(rb"#0*%d(?![0-9])" % target).search(self.data, begin, end)
        return found.start() if found else begin

    def _report_row(self, row: int, code: str, message: str) -> None:
        self.reporter.report(code, message, int(self.rows.starts[row]))

    @cached_property
    def _links(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        targets = np.empty(self.data.count(b"#"), np.int64)
        offsets = np.zeros(len(self.rows) + 1, np.int64)
        buffer = np.frombuffer(self.data, np.uint8)
        total = scan.references(buffer, self.rows.bodies, self.rows.ends, targets, offsets)
        self._complexes.reorder(targets[:total], offsets)
        return targets[:total], offsets

    @property
    def links(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return all references: targets (ids) and, shape (n + 1,), where those of each row begin."""
        return self._links

    def links_of(self, row: int) -> NDArray[np.int64]:
        """Return the ids that a statement refers to, in the order of its attributes."""
        targets, offsets = self._links
        return targets[offsets[row] : offsets[row + 1]]

    def last_number(self, row: int) -> float | None:
        """Return the last parameter of a simple instance where that is a number, mostly without parsing the rest."""
        if row in self._complexes.orders:
            instance = self.at_row(row)
            last = instance.parameters[-1] if instance and instance.parameters else None
            return float(last) if isinstance(last, int | float) and not isinstance(last, Ref) else None
        end = int(self.rows.ends[row])
        found = _LAST_NUMBER.search(self.data[max(int(self.rows.bodies[row]), end - 60) : end])
        return float(found[1]) if found else None

    @cached_property
    def _points(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int8]]:
        rows = self.rows_of_type("CARTESIAN_POINT")
        coordinates = np.zeros((len(rows), 3))
        dimensions = np.zeros(len(rows), np.int8)
        buffer = np.frombuffer(self.data, np.uint8)
        bodies, ends = self.rows.bodies[rows], self.rows.ends[rows]
        scan.points(buffer, bodies, ends, coordinates, dimensions, _POWERS)
        return rows, coordinates, dimensions

    @property
    def points(self) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int8]]:
        """Return the rows of the CARTESIAN_POINTs, coordinates (n, 3), and dimensions (−1: parse the instance)."""
        return self._points

    def coordinates_of(self, ids: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return the coordinates (n, 3) of points, and which of the ids are points that the kernel could read."""
        point_rows, coordinates, dimensions = self._points
        rows = self.rows_of_ids(ids)
        if not len(point_rows):
            return np.zeros((len(ids), 3)), np.zeros(len(ids), bool)
        k = np.minimum(np.searchsorted(point_rows, rows), len(point_rows) - 1)
        return coordinates[k], (point_rows[k] == rows) & (dimensions[k] >= 2)
