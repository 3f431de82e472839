%
(Heart: NURBS with a cusp-like notch.)
(Shows one corner that nearly stops and long curves that do not.)
(START, X0 Y0)
G21 G17 G90 G94 G61
G0 X0 Y0
G6.2 P4 K0 X0 Y0 R1 F5000
K0 X-12 Y14 R1
K0 X-38 Y30 R1
K0 X-44 Y58 R1
K0.125 X-22 Y72 R1
K0.25 X0 Y44 R3
K0.375 X22 Y72 R1
K0.5 X44 Y58 R1
K0.625 X38 Y30 R1
K0.75 X12 Y14 R1
K0.875 X0 Y0 R1
K1
K1
K1
K1
M30
%
