"""Reading and writing files: a file that cannot be read gives a clear fault, and a file is written completely or not at all."""

from __future__ import annotations

import codecs
import errno
import io
import os
import stat
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from types import MappingProxyType

from cncgen.diagnostics import Diagnostic, UsageError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path
    from typing import IO, Any, BinaryIO, TypeVar

    _T = TypeVar("_T")

#: Whether the system locks files; Windows does not. (The module `fcntl` is imported with the first lock.)
_HAS_LOCKS = os.name == "posix"
#: Name of standard input and output wherever a file is asked for.
STANDARD = "-"
#: Its name in messages where it is read.
STANDARD_INPUT = "standard input"
#: Where Linux shows a process the files that it has open.
_DESCRIPTORS = "/proc/self/fd"


def file_fault(path: str | os.PathLike[str], verb: str, error: OSError) -> UsageError:
    """Return the exception that says why a file cannot be read or written (`verb`)."""
    reasons = {
        errno.ENOENT: "there is no such file" if verb == "read" else "its directory does not exist",
        errno.EISDIR: "it is a directory",
        errno.EEXIST: "it is there already, and no directory",
        errno.EACCES: "permission denied",
        errno.EPERM: "permission denied",
        errno.EROFS: "the file system is read-only",
        errno.ENOSPC: "no space is left on the device",
        errno.EDQUOT: "the disk quota is used up",
        errno.EFBIG: "the file would be too large",
        errno.ENOTDIR: "part of its path is not a directory",
        errno.ENAMETOOLONG: "its name is too long",
        errno.ELOOP: "its symbolic links go round in a circle",
    }
    reason = reasons.get(error.errno or 0, error.strerror or str(error))
    stream = STANDARD_INPUT if verb == "read" else "standard output"
    name = stream if path == STANDARD else os.fspath(path) or "the file with an empty name"
    return UsageError(Diagnostic(f"file-{verb}", f"cannot {verb} {name}: {reason}"))


#: Byte order marks of UTF-16, by the coding of what follows.
_WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
#: How long these marks are.
WIDE_MARK = 2


def is_wide(head: bytes) -> bool:
    """Tell whether a text begins with the mark of UTF-16, as Windows' editors ("Unicode") and PowerShell's `>` write it."""
    return head[:WIDE_MARK] in _WIDE


def as_utf8(text: bytes) -> bytes:
    """Return a text of UTF-16 with its mark in UTF-8, and any other unchanged; bytes that are not UTF-16 become U+FFFD."""
    coding = _WIDE.get(bytes(text[:WIDE_MARK]))
    return text[WIDE_MARK:].decode(coding, "replace").encode("utf-8", "replace") if coding else text


def utf8_of(head: bytes) -> Callable[[bytes], bytes]:
    """Return what makes UTF-8 of the pieces of a text, of which `head` is the first, one after another; see `as_utf8`."""
    coding = _WIDE.get(head[:WIDE_MARK])
    if coding is None:
        return bytes
    decoder = codecs.getincrementaldecoder("utf-16")("replace")
    return lambda piece: decoder.decode(piece).encode("utf-8", "replace")


#: Bytes read at a time of a file that has a bound.
_PIECE = 2**20


@contextmanager
def reading_faults(path: str | os.PathLike[str]) -> Iterator[None]:
    """Turn an OSError inside the block into a `UsageError` that names the file."""
    try:
        yield
    except OSError as error:
        raise file_fault(path, "read", error) from error
    except ValueError as error:
        raise UsageError(
            Diagnostic("file-read", f"cannot read a file whose name {_no_name(error)}")
        ) from error


def _no_name(error: ValueError) -> str:
    """Return why a name can be that of no file; raise an error that has another reason."""
    if "null" in str(error):
        return "holds a NUL"
    if isinstance(error, UnicodeEncodeError):
        return f"holds U+{ord(error.object[error.start]):04X}, which no file's name can hold"
    raise error


#: Contents of pipes among the process's descriptors, by their numbers (``-m <(cncgen machines show xy-table)``). A pipe gives
#: its content once, and some files are read twice.
_piped: dict[int, bytes] = {}


def _pipe_of(name: str) -> int:
    """Return the number of the pipe that a name such as ``/dev/fd/63`` stands for, 0 of anything else."""
    if name.startswith(("/dev/fd/", _DESCRIPTORS)):
        with suppress(OSError):
            found = os.stat(name)
            return found.st_ino if stat.S_ISFIFO(found.st_mode) else 0
    return 0


def read_bytes(path: str | os.PathLike[str], *, at_most: int | None = None) -> bytes:
    """Return the content of a file, or of standard input for ``-``.

    Raises:
        UsageError: It cannot be read, or holds more than `at_most` bytes.
    """
    name = os.fspath(path)
    pipe = _pipe_of(name)
    if pipe in _piped:
        return _piped[pipe]
    with open_input(path) as file, reading_faults(path):
        content = file.read() if at_most is None else b"".join(_pieces(file, at_most + 1))
    if at_most is not None and len(content) > at_most:
        raise UsageError(Diagnostic("file-read", f"cannot read {name}: it is larger than {at_most} bytes"))
    if pipe:
        _piped[pipe] = content
    return content


def read_utf8(path: str | os.PathLike[str], *, at_most: int) -> bytes:
    """Return the content of a file of text; see `read_bytes`. One of UTF-16, as ``>`` of Windows' PowerShell writes it, comes in UTF-8."""
    return as_utf8(read_bytes(path, at_most=at_most))


def _pieces(file: BinaryIO, most: int) -> Iterator[bytes]:
    """Yield the content up to so many bytes; a read of all of them would make room for all of them first."""
    while most > 0 and (piece := file.read(min(most, _PIECE))):
        most -= len(piece)
        yield piece


def peeked(file: BinaryIO, count: int, name: str) -> bytes:
    """Return the first bytes of an open file of that name and leave them to be read; b"" of one without a buffer.

    Raises:
        UsageError: They cannot be read.
    """
    peek = getattr(file, "peek", None)
    with reading_faults(name):
        return bytes(peek(count)[:count]) if peek else b""


@contextmanager
def open_input(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a file for reading bytes, or standard input for ``-``; a `UsageError` names a file that cannot be opened."""
    if os.fspath(path) == STANDARD:
        if sys.stdin is None:
            raise file_fault(STANDARD_INPUT, "read", OSError(errno.EBADF, "it is closed"))
        note_read(sys.stdin.buffer)
        yield sys.stdin.buffer
        return
    begun = _begun.pop(os.fspath(path), None)
    if begun is not None:
        with io.BufferedReader(begun) as again:
            yield again
        return
    with reading_faults(path):
        file = open(path, "rb")  # noqa: SIM115 - closed below; faults of the body are not those of opening
        if stat.S_ISDIR(os.fstat(file.fileno()).st_mode):
            file.close()
            raise IsADirectoryError(errno.EISDIR, "is a directory")
    with file:
        note_read(file)
        yield file


def note_read(file: BinaryIO) -> None:
    """Note that the run of a command reads an open file, which none of its outputs may replace then."""
    with suppress(OSError, ValueError):  # a stream of Python's own
        if _read is not None:
            _read.add(_identity(os.fstat(file.fileno())))


def _identity(found: os.stat_result) -> tuple[int, int]:
    return found.st_dev, found.st_ino


class _Begun(io.RawIOBase):
    """A pipe whose first bytes have been looked at, and are read again."""

    def __init__(self, pipe: BinaryIO, count: int) -> None:
        self._pipe = pipe
        self.head = pipe.read(count)
        self._left = self.head

    def readable(self) -> bool:
        """Return True."""
        return True

    def fileno(self) -> int:
        """Return the descriptor of the pipe."""
        return self._pipe.fileno()

    def readinto(self, buffer: Any) -> int:
        """Fill a buffer with the next bytes; return their number, 0 at the end."""
        data = self._left[: len(buffer)]
        self._left = self._left[len(data) :]
        data = data or self._pipe.read1(len(buffer))  # type: ignore[attr-defined]
        buffer[: len(data)] = data
        return len(data)

    def close(self) -> None:
        """Close the pipe."""
        self._pipe.close()
        super().close()


#: Pipes that `head_of` has begun, by name, until `open_input` goes on with them.
_begun: dict[str, _Begun] = {}


def head_of(path: str | os.PathLike[str], count: int) -> bytes:
    """Return the first bytes of a file, of which `open_input` then reads all; b"" without anything to read.

    A pipe can be read once: it is kept open for the `open_input` that follows. Of devices nothing is read.
    """
    name = os.fspath(path)
    if name in _begun:
        return _begun[name].head[:count]
    with suppress(OSError, ValueError):
        mode = os.stat(name).st_mode
        if stat.S_ISFIFO(mode):
            _begun[name] = _Begun(open(name, "rb"), count)  # noqa: SIM115 - closed by `open_input`
            return _begun[name].head
        if stat.S_ISREG(mode):
            with open(name, "rb") as file:
                return file.read(count)
    return b""


def check_folder(path: str | os.PathLike[str]) -> None:
    """Raise `UsageError` unless `path` is a folder that can be searched."""
    with reading_faults(path):
        if not stat.S_ISDIR(os.stat(path).st_mode):
            raise NotADirectoryError(errno.ENOTDIR, "it is not a directory")


def is_terminal(stream: Any) -> bool:
    """Tell whether a stream is an open terminal."""
    with suppress(ValueError, AttributeError):
        return bool(stream.isatty())
    return False


class OutputFile:
    """A file that appears under its name only when `commit` is called: written in its folder, then renamed.

    Where the system can, it has no name at all until then, so that a process that is killed leaves nothing; where it cannot,
    or amid a replacement, what is left beside the target is removed by the next run that writes it.
    A device or a pipe that exists is written directly. Any OSError is raised as a
    `UsageError` that names the file, except a broken pipe.
    """

    def __init__(self, path: str | os.PathLike[str], replaces: str | os.PathLike[str] | None = None) -> None:
        """Open it.

        Args:
            path: Its name.
            replaces: A file that was read, and that it may replace.
        """
        from pathlib import Path

        self.path, self._name = Path(path), os.fspath(path)
        self._replaces = replaces
        self._target: Path | None = None
        self._temporary: str | None = None
        #: A second descriptor of a file that has a name beside its target: its lock says that a process still writes it.
        self._lock: int | None = None
        self.file: BinaryIO = self._guard(self._open)

    def _guard(self, action: Callable[[], _T]) -> _T:
        try:
            return action()
        except BrokenPipeError:
            raise
        except OSError as error:
            raise file_fault(self._name, "write", error) from error
        except ValueError as error:
            fault = Diagnostic("file-write", f"cannot write a file whose name {_no_name(error)}")
            raise UsageError(fault) from error

    def _open(self) -> BinaryIO:
        try:
            mode = self.path.stat().st_mode
        except FileNotFoundError:
            mode = None
        if not self._name:
            raise OSError(errno.EINVAL, "give it a name")
        # `Path` drops the slash that marks a folder.
        if (mode is not None and stat.S_ISDIR(mode)) or self._name.endswith(("/", os.sep)):
            raise IsADirectoryError(errno.EISDIR, "is a directory")
        if mode is not None and not stat.S_ISREG(mode):
            return open(self.path, "wb")
        if mode is not None and not os.access(self.path, os.W_OK):
            raise PermissionError(errno.EACCES, "permission denied")
        self._target = self.path.resolve()
        _remove_stale(_beside(self._target))
        handle = _nameless(self._target.parent)
        if handle is None:
            handle = self._named_beside()
        umask = os.umask(0)
        os.umask(umask)
        os.fchmod(handle, stat.S_IMODE(mode) if mode is not None else 0o666 & ~umask)
        return os.fdopen(handle, "w+b")

    @property
    def seekable(self) -> bool:
        """Tell whether the output can be rewound."""
        return self._target is not None

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Write bytes."""
        written: int = self._guard(lambda: self.file.write(data))
        return written

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to a place in the output."""
        place: int = self._guard(lambda: self.file.seek(offset, whence))
        return place

    def tell(self) -> int:
        """Return the place where the next byte goes."""
        place: int = self._guard(self.file.tell)
        return place

    def flush(self) -> None:
        """Flush the buffer to the system."""
        self._guard(self.file.flush)

    def _named_beside(self) -> int:
        """Make the file under a name beside its target; return its descriptor."""
        assert self._target is not None
        while True:
            self._temporary = _unused_beside(self._target)
            handle = os.open(self._temporary, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600)
            _temporaries.add(self._temporary)
            self._lock = _locked(handle)
            if os.fstat(handle).st_nlink:
                return handle
            # Another run took it for one that was left, before it was locked.
            os.close(handle)
            self._unlock()

    def finish(self) -> None:
        """Hand all of the file to the system; only its name is missing."""

        def handed() -> None:
            if not self.file.closed:
                self.file.flush()
            if (
                self._temporary is not None or self._target is None
            ):  # file systems over a network tell faults here
                self.file.close()

        try:
            self._guard(handed)
        except BaseException:
            self.discard()
            raise

    def name_beside(self) -> None:
        """Give a finished file a name beside its target, where a name may still be lacking."""

        def named() -> None:
            if self._target is not None and self._temporary is None and not self.file.closed:
                path = _unused_beside(self._target)
                self._lock = _locked(self.file.fileno())
                _temporaries.add(path)
                self._temporary = path
                _give_name(self.file.fileno(), path)

        self._guard(named)

    def check_unread(self, read: set[tuple[int, int]]) -> None:
        """Raise `UsageError` where it would replace a file that was read, by device and number; a terminal may be both."""
        with suppress(OSError):
            if self._target is None:
                return
            own = _identity(os.stat(self.path))
            if own in read and (self._replaces is None or own != _identity(os.stat(self._replaces))):
                message = f"{self._name} would overwrite a file that was read"
                raise UsageError(Diagnostic("option-value", message, hint="give each its own file"))

    def commit(self) -> None:
        """Close the file and give it its name."""
        self.finish()

        def name() -> None:
            if self._target is None:
                return
            if self._temporary is None and not self.file.closed:
                with suppress(FileExistsError):
                    _give_name(self.file.fileno(), str(self._target))
                    return
                self.name_beside()
            if self._temporary is not None:
                os.replace(self._temporary, self._target)
                _temporaries.discard(self._temporary)
                self._temporary = None

        try:
            self._guard(name)
        finally:
            self.discard()

    def discard(self) -> None:
        """Close the file and remove the output; nothing after `commit`."""
        with suppress(OSError):
            self.file.close()
        if self._temporary is not None:
            with suppress(OSError):
                os.unlink(self._temporary)
            _temporaries.discard(self._temporary)
            self._temporary = None
        self._unlock()

    def _unlock(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


#: Names of files that are being written, beside their targets.
_temporaries: set[str] = set()


def remove_temporaries() -> None:
    """Remove half-written files before the process ends abruptly."""
    for path in tuple(_temporaries):
        with suppress(OSError):
            os.unlink(path)


def _beside(target: Path) -> str:
    """Return the name beside a file under which it is written."""
    return os.path.join(target.parent, f".{target.name[:200]}.part")


def _unused_beside(target: Path) -> str:
    """Return a name beside a file that no run uses."""
    path = _beside(target)
    return f"{path[:-5]}.{os.urandom(6).hex()}.part" if os.path.lexists(path) else path


def _locked(handle: int) -> int | None:
    """Lock a file for this process; return the descriptor that holds the lock, or None where the system has no locks."""
    if not _HAS_LOCKS:
        return None
    import fcntl

    holder = os.dup(handle)
    try:
        fcntl.flock(holder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(holder)
        return None
    return holder


def _remove_stale(path: str) -> None:
    """Remove the file of a killed process: nobody holds its lock."""
    with suppress(OSError):
        handle = os.open(path, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
        try:
            lock = _locked(handle)
            if lock is not None:
                if os.path.samestat(os.fstat(handle), os.stat(path)):
                    os.unlink(path)
                os.close(lock)
        finally:
            os.close(handle)


@contextmanager
def scratch_folder() -> Iterator[str]:
    """Make a folder among the temporary files for a with block, and remove the folders that killed processes have left."""
    import shutil
    import tempfile

    for name in _stale_folders(tempfile.gettempdir()):
        shutil.rmtree(name, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=_SCRATCH) as name:
        handle = os.open(name, os.O_RDONLY) if _HAS_LOCKS else None
        lock = None if handle is None else _locked(handle)
        try:
            yield name
        finally:
            for each in (handle, lock):
                if each is not None:
                    os.close(each)


#: How names of `scratch_folder` begin, and the age, s, from which one that is not locked belongs to nobody.
_SCRATCH, _STALE_S = "cncgen-scratch-", 60.0


def _stale_folders(place: str) -> Iterator[str]:
    """Yield folders of this user's killed processes."""
    if not _HAS_LOCKS:
        return
    with suppress(OSError), os.scandir(place) as entries:
        for entry in entries:
            if not (entry.name.startswith(_SCRATCH) and entry.is_dir(follow_symlinks=False)):
                continue
            with suppress(OSError):
                about = entry.stat(follow_symlinks=False)
                if about.st_uid != os.getuid() or time.time() - about.st_mtime < _STALE_S:
                    continue
                handle = os.open(entry.path, os.O_RDONLY | os.O_NOFOLLOW)
                lock = _locked(handle)
                os.close(handle)
                if lock is not None:
                    yield entry.path
                    os.close(lock)


def _nameless(folder: Path) -> int | None:
    """Open a file in a folder that has no name yet; None where the system or the file system knows no such files."""
    if not hasattr(os, "O_TMPFILE") or not os.path.isdir(_DESCRIPTORS):
        return None
    with suppress(OSError):
        return os.open(folder, os.O_TMPFILE | os.O_RDWR, 0o600)
    return None


def _give_name(handle: int, path: str) -> None:
    """Give a file that has none a name in its folder (linkat of Linux, open(2))."""
    folder = os.open(os.path.dirname(path), os.O_RDONLY)
    try:
        # With a folder's descriptor it is linkat, which follows the link that a descriptor is.
        os.link(f"{_DESCRIPTORS}/{handle}", os.path.basename(path), dst_dir_fd=folder)
    finally:
        os.close(folder)


class StandardOutput:
    """Standard output as a binary sink; a full disk behind it is a `UsageError` like that of a file.

    A reader that goes away raises BrokenPipeError, or, where the work has to go on for the sake of other files
    (`outlives_reader`), leaves the rest unwritten.
    """

    seekable = False

    def __init__(self, outlives_reader: bool = False) -> None:
        if sys.stdout is None:  # the process was started with it closed
            raise file_fault("standard output", "write", OSError(errno.EBADF, "it is closed"))
        self._outlives_reader = outlives_reader
        self.flush()

    def _guard(self, action: Callable[[], object]) -> None:
        try:
            action()
        except BrokenPipeError:
            if not self._outlives_reader:
                raise
            silence(sys.stdout)
        except OSError as error:
            raise file_fault("standard output", "write", error) from error

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Write bytes."""
        self._guard(lambda: sys.stdout.buffer.write(data))
        return len(data)

    def flush(self) -> None:
        """Flush the buffer to the system."""
        self._guard(sys.stdout.flush)


def silence(stream: IO[str] | IO[bytes]) -> None:
    """Redirect a stream without readers to the null device, so that later writes cause no message."""
    with suppress(OSError, ValueError):
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, stream.fileno())
        os.close(nothing)


#: Where bytes go.
Sink = OutputFile | StandardOutput

#: Files that wait for the end of `together`; None: each appears when it is done.
_waiting: list[OutputFile] | None = None
#: The files that the run of a command has read, by device and number.
_read: set[tuple[int, int]] | None = None


@contextmanager
def together() -> Iterator[None]:
    """Let the files that are written in a with block appear when it ends well: all of them, or none.

    None may replace a file that was read in the block (`option-value`): a subprogram is found while the program runs.
    It is the process's own (files of other threads wait too), made for the run of a command.
    """
    global _waiting, _read
    outer = _waiting, _read
    files: list[OutputFile] = []
    read: set[tuple[int, int]] = set()
    _waiting, _read = files, read
    try:
        yield
        for file in files:
            file.check_unread(read)
        if len(files) > 1:
            for file in files:
                file.name_beside()
        for file in files:
            file.commit()
    finally:
        _waiting, _read = outer
        for file in files:
            file.discard()


@contextmanager
def open_output(
    path: str | os.PathLike[str] | None,
    *,
    outlives_reader: bool = False,
    replaces: str | os.PathLike[str] | None = None,
) -> Iterator[Sink]:
    """Open `path` for writing, standard output for ``-`` or None; the file appears when the block ends well.

    Args:
        path: The file.
        outlives_reader: Whether a reader of standard output that goes away does not end the work.
        replaces: A file that was read, and that `path` may replace.
    """
    if path is None or os.fspath(path) == STANDARD:
        output = StandardOutput(outlives_reader)
        yield output
        output.flush()
        return
    file = OutputFile(path, replaces)
    try:
        yield file
    except BaseException:
        file.discard()
        raise
    if _waiting is None:
        file.commit()
    else:
        file.finish()
        _waiting.append(file)


def write_text(
    path: str | os.PathLike[str] | None, text: str, replaces: str | os.PathLike[str] | None = None
) -> None:
    """Write a text whole or not at all (standard output for ``-`` or None); see `open_output`."""
    with open_output(path, replaces=replaces) as file:
        file.write(encoded(text))


def encoded(text: str) -> bytes:
    """Return a text as UTF-8; bytes of a file name outside UTF-8 stand in it escaped."""
    return text.encode(errors="backslashreplace")


def check_distinct(
    inputs: Iterable[tuple[str, str]],
    outputs: Mapping[str, str | None],
    replaces: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Refuse outputs that would overwrite each other or an input.

    Args:
        inputs: Names of inputs, each with its description (``the program``); objects other than files do not count.
        outputs: The files that are written, by the option that names each.
        replaces: Inputs that an option may overwrite.

    Raises:
        UsageError: Naming the two.
    """
    taken = {os.path.realpath(path): what for path, what in inputs if os.path.isfile(path)}
    for option, path in outputs.items():
        if path is None or path == STANDARD or (os.path.exists(path) and not os.path.isfile(path)):
            continue
        place = os.path.realpath(path)
        if place in taken and taken[place] != replaces.get(option):
            message = f"{option} {path} would overwrite {taken[place]}"
            raise UsageError(Diagnostic("option-value", message, hint="give each its own file"))
        taken[place] = f"what {option} writes"


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise `UsageError` where a file could not be written now, before the work that it is for.

    Of devices and pipes nothing is asked: to open one is to begin with it.
    """
    with suppress(OSError, ValueError):
        mode = os.stat(path).st_mode
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            return
    OutputFile(path).discard()


def open_in_browser(page: str) -> tuple[str, bool]:
    """Write a page to a temporary file and open it in the browser; return its name, and whether a browser was started."""
    import tempfile
    import webbrowser

    with tempfile.NamedTemporaryFile(
        "w", encoding="utf-8", prefix="cncgen-", suffix=".html", delete=False
    ) as file:
        file.write(page)
    from pathlib import Path

    return file.name, webbrowser.open(Path(file.name).as_uri())
