"""Heidenhain's plain language beyond single blocks: statements that lead from line to line.

q_formulas expressions of Q parameters, FN 0 to 8 and 13, the formulas of Q
lines      the lines of a text without numbers and comments
running    `HeidenhainRunner`: labels, CALL LBL with REP, jumps FN 9 to 12, TCPM-free blocks through `text.plain_language`
contours   RL RR, RND CHF, CT, APPR and DEP
din_iso    DIN/ISO, said in plain language
planes     tilted planes as frames: PLANE SPATIAL, cycle 19
programs   the files that CALL PGM names
cycles     drilling, pockets and patterns that CYCL CALL, CYCL CALL POS, M99 and M89 run; cycles 1 to 5 and 17 in parts; 7 8 10 11 as frames, 9, 247
slots      slots and pockets: 251 to 254, 3 to 5
points     PATTERN DEF

A program without any of these goes the usual way (`cncgen.gcode.flow`).
"""
