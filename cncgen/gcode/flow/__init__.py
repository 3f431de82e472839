"""The order in which lines are executed: straight on, in loops and branches, in subroutines and macros.

run          what the runs of all languages have in common
running      `Runner`, one run of a program of G-code
language_run `LanguageRun`, one run of a program of SINUMERIK or Heidenhain's plain language: its lines as records, frames of calls
course       line after line, wherever they lead: scanned, computed while they are read, or run one by one; it puts all of this together
computing    lines that a kernel computes while it reads them, O-words that lead to written labels and FANUC's macros among them
pending      plain blocks that are read and not yet run, in columns; `batches` hands them to a kernel
line_by_line runs parsed lines one by one; `executing` has the interpreter execute a block
o_words      O-words that the kernel `gcode_run` does not follow by itself, by the labels of `subroutines`; `sub_words` (SUB, CALL, RETURN)
plain_lines  `PlainLane`, runs of lines of SINUMERIK and Heidenhain: computed by the same kernel, through `batches` too
macros       calls, jumps and arguments of FANUC's macros
calls        the calls in progress, each with its local parameters
faults       what is wrong with a line, said once; `recovery` puts what the line would have set in force for the next ones
recurrence   tells that a program runs for ever
reading      gives the text of a line and parses it
"""
