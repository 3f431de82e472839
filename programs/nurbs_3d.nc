%
(Cubic NURBS in X, Y and Z with unequal weights.)
(Shows that nothing is special about a plane.)
(START, X0 Y0 Z0)
G21 G17 G90 G94 G61
G0 X0 Y0 Z0
G6.2 P4 K0 X0 Y0 Z0 R1 F4000
K0 X15 Y30 Z8 R1.2
K0 X40 Y35 Z-6 R0.8
K0 X55 Y5 Z-12 R1
K0.25 X75 Y-10 Z4 R1.5
K0.5 X95 Y25 Z10 R0.9
K0.75 X110 Y10 Z0 R1
K1
K1
K1
K1
M30
%
