"""The blocks of an MDF 4 file (ASAM MDF 4.1, clause 5), as far as sorted groups of plain numbers need them.

A block begins with ``##``, two letters, four reserved bytes, its length and its number of links (both uint64), then the links,
each the place of another block or 0, then its data. Every link is followed once, and only within the file, so that a
damaged file costs no more than a sound one.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO

import numpy as np

#: Blocks followed in one file at most.
MAX_BLOCKS = 1_000_000
#: Bytes that the records of a group may unpack to: 4 GiB.
MAX_BYTES = 2**32
#: Place of the header block.
HEADER = 64
_HEAD = struct.Struct("<4s4xQQ")
#: numpy kinds of the channel data types 0 (unsigned), 2 (signed) and 4 (real), all little-endian.
_KINDS = {0: "u", 2: "i", 4: "f"}


@dataclass(frozen=True, slots=True)
class MdfBlock:
    """One block: its two letters, its links, and its data."""

    name: str
    links: tuple[int, ...]
    data: bytes

    def link(self, index: int) -> int:
        """Return a link, 0 where the block has fewer."""
        return self.links[index] if index < len(self.links) else 0

    def numbers(self, layout: str) -> tuple[int, ...]:
        """Return the numbers at the start of the data, little-endian."""
        return struct.unpack_from(f"<{layout}", self.data)


@dataclass(frozen=True, slots=True)
class Channel:
    """A column of a record: its name, whether it is the master (time), its place, its kind, and its linear conversion."""

    name: str
    master: bool
    offset: int
    kind: str
    first: float = 0.0
    factor: float = 1.0


class MdfFile:
    """Blocks by their place, each followed once."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._size = file.seek(0, 2)
        self._followed: set[int] = set()

    def block(self, place: int, *names: str, shared: bool = False) -> MdfBlock:
        """Return the block at a place.

        Args:
            place: Byte in the file.
            names: Letters that it may have.
            shared: Whether several links may lead to it (texts and conversions).

        Raises:
            ValueError: The file has no such block there, or it was followed before.
        """
        if not shared:
            if place in self._followed:
                raise ValueError(f"links lead to the block at byte {place} more than once")
            self._followed.add(place)
            if len(self._followed) > MAX_BLOCKS:
                raise ValueError(f"it has more than {MAX_BLOCKS} blocks")
        self._file.seek(place)
        head = self._file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise ValueError(f"the block at byte {place} lies outside of the file")
        letters, length, count = _HEAD.unpack(head)
        name = letters[2:].decode("ascii", "replace")
        if letters[:2] != b"##" or name not in names:
            raise ValueError(f"byte {place} does not begin a block {' or '.join(names)}")
        if length < _HEAD.size + 8 * count or place + length > self._size:
            raise ValueError(f"the block at byte {place} states {length} bytes and {count} links")
        links = struct.unpack(f"<{count}Q", self._file.read(8 * count))
        return MdfBlock(name, links, self._file.read(length - _HEAD.size - 8 * count))

    def chain(self, place: int, name: str) -> Iterator[MdfBlock]:
        """Yield the blocks of a list, whose first link is the next one."""
        while place:
            block = self.block(place, name)
            yield block
            place = block.link(0)

    def text(self, place: int) -> str:
        """Return a text block's text."""
        return self.block(place, "TX", shared=True).data.partition(b"\0")[0].decode() if place else ""

    def records(self, place: int) -> bytes:
        """Return the records of a group, from one block or a list of blocks, packed or not.

        Raises:
            ValueError: They are more than `MAX_BYTES`, or damaged.
        """
        if not place:
            return b""
        block = self.block(place, "DT", "DZ", "DL", "HL")
        if block.name in ("DT", "DZ"):
            return _unpacked(block)
        parts, total = [], 0
        first = block.link(0) if block.name == "HL" else 0
        lists = self.chain(first, "DL") if block.name == "HL" else self._with_rest(block)
        for item in lists:
            for link in item.links[1:]:
                parts.append(_unpacked(self.block(link, "DT", "DZ")))
                total += len(parts[-1])
                if total > MAX_BYTES:
                    raise ValueError(f"its records unpack to more than {MAX_BYTES} bytes")
        return b"".join(parts)

    def _with_rest(self, block: MdfBlock) -> Iterator[MdfBlock]:
        yield block
        yield from self.chain(block.link(0), "DL")


def _unpacked(block: MdfBlock) -> bytes:
    """Return the bytes of a data block, of a deflated one unpacked (type 0) and turned back (type 1)."""
    if block.name == "DT":
        return block.data
    _, kind, width, size, packed = struct.unpack_from("<2sBxIQQ", block.data)
    if size > MAX_BYTES or kind not in (0, 1):
        raise ValueError(f"a block of kind {kind} unpacks to {size} bytes")
    found = zlib.decompressobj().decompress(block.data[24 : 24 + packed], size)
    if len(found) != size:
        raise ValueError(f"a block unpacks to {len(found)} bytes and states {size}")
    if kind == 1 and width:
        whole = size - size % width
        turned = np.frombuffer(found, np.uint8, whole).reshape(width, -1).T
        return turned.tobytes() + found[whole:]
    return found


def channel_of(file: MdfFile, block: MdfBlock) -> Channel | None:
    """Return the channel of a block, or None if it is not a plain number in whole bytes."""
    kind, _, data_type, bit, offset, bits = block.numbers("BBBBII")
    name = file.text(block.link(2))
    if data_type not in _KINDS or bit or bits not in (8, 16, 32, 64) or kind not in (0, 2):
        return None
    letter = _KINDS[data_type]
    if letter == "f" and bits < 32:
        return None
    first, factor = _conversion(file, block.link(4))
    return Channel(name, kind == 2, offset, f"<{letter}{bits // 8}", first, factor)


def _conversion(file: MdfFile, place: int) -> tuple[float, float]:
    """Return offset and factor of a conversion, which is linear or none."""
    if not place:
        return 0.0, 1.0
    block = file.block(place, "CC", shared=True)
    kind, _, _, _, count = block.numbers("BBHHH")
    if kind == 0:
        return 0.0, 1.0
    if kind != 1 or count < 2:
        raise ValueError(f"a conversion of type {kind} is not linear")
    first, factor = struct.unpack_from("<dd", block.data, 24)
    return first, factor
