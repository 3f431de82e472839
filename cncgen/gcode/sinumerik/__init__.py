"""SINUMERIK 840D and 828D, milling: text to canonical motions.

reading      a line to a statement by the tables of the grammar (``grammars/sinumerik.lark``)
expressions  values of expressions: the common ones, with texts, variables and operators of SINUMERIK
variables    R parameters, DEF variables, system variables
programs     texts as programs: labels, loops and branches, PROC, files of subprograms
said         what the blocks of a text name, before it runs; `axes` are those of its columns
running      `SinumerikRunner`: branches, loops, jumps and calls
motions      one block on the interpreter: modes, words, positions, arcs; `commands` are words without a number
g_functions  G functions; `feeds_and_tools` feeds, speeds, tools and M functions
curves       ASPLINE, CSPLINE, POLY
cycles       CYCLE81 to 86, 840, HOLES1, HOLES2, and CYCLE800, a frame (`cncgen.gcode.codes.affine`); `pockets` POCKET3, POCKET4, SLOT1;
             `grooves` CYCLE93; `thread_cutting` CYCLE97 to 99; `unread_cycles` says what others do

Motions are those of the interpreter (`cncgen.gcode.interpreter`): a line becomes a block of coordinates in G90, whose codes are in
its table; words that the interpreter lacks (AC IC, polar words, CR, CIP) are worked out here.
"""
