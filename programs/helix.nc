%
(Helix: thread milling, three turns with P, then a full circle at the bottom.)
(Shows motion in three axes on arcs of more than one turn.)
(START, X10 Y0 Z0)
G21 G17 G90 G94 G61
G0 X10 Y0 Z0
G2 X10 Y0 Z-6 I-10 J0 P3 F1200
G2 I-10
G0 Z5
M30
%
