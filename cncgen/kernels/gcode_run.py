"""Run lines of G-code as `gcode_parse` has compiled them: expressions, parameters and settings, O-words, blocks into columns.

A line is parsed once, by the tables of the grammar, and kept as instructions; loops and calls run those. An uncertain line ends a run,
and is the interpreter's.

    offset of a line ──► row of `gcode_lines.Lines` ──► `gcode_instructions` ─┬► words: a block in the columns
       ▲                                                                   ├► settings, done at the end of the line
       └──── row of the line that it leads to ◄── `gcode_jumps` ◄───────────┴► an O-word, a jump, a call
"""

import cython
from cython.cimports.cncgen.kernels.gcode_codes import AFTER, AT, NUMBER_OF_LINE, PLAIN_LINE
from cython.cimports.cncgen.kernels.gcode_jumps import Jumps


@cython.cclass
class Computer(Jumps):
    """A place in a text, and the columns that its lines go to. O-words are followed once `follow` was told how, jumps and loops of macros
    where `leads` tells their lines.

    Args:
        text: The text.
        parser: A `gcode_parse.Parser` that nobody else uses, of LinuxCNC's grammar or FANUC's; or the code of a language.
        store: Parameters, read and set: a `LanguageStore` for lines of SINUMERIK and Heidenhain, which jump by it.
        columns: The columns of `gcode_scan.scan`: line, offset, flags, ends of the words, letters, values.
        waits: Tells whether a block with a code, a letter and a whole number, may wait.
        pause: Lines after which a jump back ends a run.
        meant: The operators and functions of the dialect by those of the grammar, where they differ.
        frames: The calls in progress, the innermost last.
        leads: Of macros, returns offset and number of the line that GOTO, DO or END leads to, by offset and number of its line, keyword and
            value; None where there is none.
        begins: Returns the place where a program begins, by offset and number of the line that calls it, and its number; None where that
            is not certain.

    Attributes:
        calls: Whether M98, M99 and G65 of macros are followed.
        blocks: How many blocks stand in the columns; whoever takes them sets it to 0.
        line: Number of the first line not read.
        lines, units: How many lines the last run read, and units of work that its calls were beside them.
        back: The O-word, by offset and line, whose jump back ended the last run, or None; `away`, where it led to in another text.
        reached, reached_line: The first line that was never reached outside of calls.
        skipped: Lines outside of calls that a jump led past when they were reached: offset and line of the first, offset of the one behind.
        since: Lines read since that line, or since whoever looks set it to 0.
        ran, ran_line: The line that was read last.
    """

    pause = cython.declare(cython.Py_ssize_t)
    line = cython.declare(cython.longlong, visibility="public")
    lines = cython.declare(cython.Py_ssize_t, visibility="public")
    back = cython.declare(object, visibility="public")
    reached = cython.declare(cython.Py_ssize_t, visibility="public")
    reached_line = cython.declare(cython.longlong, visibility="public")
    skipped = cython.declare(list, visibility="public")
    since = cython.declare(cython.Py_ssize_t, visibility="public")
    ran = cython.declare(cython.Py_ssize_t, visibility="public")
    ran_line = cython.declare(cython.longlong, visibility="public")

    def __init__(
        self, text, parser, store, columns, waits, pause, meant=None, frames=None, leads=None, begins=None
    ):
        Jumps.__init__(self, text, parser, store, columns, waits, meant, frames, leads, begins)
        self.pause = pause
        self.ran = self.ran_line = 0
        self.reached = self.reached_line = self.since = 0
        self.skipped = []
        self.line = 1

    @property
    def local(self):
        """The named parameters of the call in progress."""
        return self.store.local

    def run(
        self,
        offset: cython.Py_ssize_t,
        line: cython.longlong,
        local: dict,
        most: cython.Py_ssize_t = 1 << 62,
    ) -> cython.Py_ssize_t:
        """Run lines from `offset` on until one is not certain, a column is full, the text ends, or so many were run.

        Settings are done, blocks go to the columns, behind those that stand there. `local` are the named parameters of the
        subroutine in force. When `since` is `pause`, the next jump back ends the run. Returns the offset of the first line not read.
        """
        kind: cython.int
        outside: cython.bint
        r: cython.Py_ssize_t
        after: cython.Py_ssize_t
        self.store.local = local
        self.lines = self.units = 0
        self.back = self.away = None
        self.rows.again = self.marks is not None or (
            self.language is not None and self.language.leads is not None
        )
        r = self.rows.at(offset, line)
        outside = self._is_outside()
        while r >= 0 and self.blocks < self.block_line.shape[0] and self.lines < most:
            offset, line, after = self.kept[r, AT], self.kept[r, NUMBER_OF_LINE], self.kept[r, AFTER]
            self.rows.last = r
            self.first = self.words = self.word_end[self.blocks - 1] if self.blocks > 0 else 0
            self.next_line = line + 1
            kind = self.execute(r)
            if kind == PLAIN_LINE:
                self.end_block(r)
                self.next = self.rows.following(r)
            elif not self.follow_line(r, kind):
                self.store.undo()
                break
            self.lines += 1
            if kind != PLAIN_LINE:
                if outside:
                    self._reach(after, line + 1)
                if self.away is not None:
                    break
                outside = self._is_outside()
            self.ran, self.ran_line = offset, line
            if self.next < 0:
                # The end of the text.
                offset, line = -1 - self.next, self.next_line
            else:
                if kind != PLAIN_LINE and self.kept[self.next, AT] <= offset and self._is_time():
                    self.back = (offset, line)
                offset, line = self.kept[self.next, AT], self.kept[self.next, NUMBER_OF_LINE]
            r = self.next
            if outside:
                if kind != PLAIN_LINE and offset > self.reached:
                    self.skipped.append((self.reached, self.reached_line, offset))
                self._reach(offset, line)
            if self.back is not None:
                break
        if self.store.returned:
            self.store.settle()
        self.since += self.lines
        self.line = line
        return offset

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_outside(self) -> cython.bint:
        """Tell whether no call is in progress."""
        return len(self.frames) == 0 and self.store.calls == 0

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _is_time(self) -> cython.bint:
        """Tell whether a jump back is to be looked at."""
        return self.since + self.lines >= self.pause * (1 + (self.store.calls > 0))

    @cython.cfunc
    @cython.inline
    @cython.exceptval(check=False)
    def _reach(self, offset: cython.Py_ssize_t, line: cython.longlong) -> cython.void:
        """Note a line that was never reached before."""
        if offset > self.reached:
            self.reached, self.reached_line = offset, line
            self.since = -self.lines
