"""Programs in Heidenhain's plain language. `text.plain_language` reads single blocks by the tables of their grammar.

lines      the lines of a text without numbers and comments
program_text   what the lines of a program say
executing  blocks on the interpreter: words with their values, motions, contours that are read
contour_lines  statements that draw: RND, CT, APPR, free contours
running    `HeidenhainRunner`: all other statements; labels, CALL LBL with REP, jumps FN 9 to 12
contours   RL RR, RND CHF, CT, APPR and DEP
din_iso    DIN/ISO: its blocks by their own grammar to statements of the plain language
planes     tilted planes as frames: PLANE SPATIAL, cycle 19
programs   the files that CALL PGM names
cycles     drilling, pockets and patterns that CYCL CALL, CYCL CALL POS, M99 and M89 run; cycles 1 to 5 and 17 in parts; 7 8 10 11 as frames, 9, 247
slots      slots and pockets: 251 to 254, 3 to 5
points     PATTERN DEF
"""
