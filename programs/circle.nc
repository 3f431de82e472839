%
(Circle of 10 mm as a quadratic NURBS of 7 control points.)
(Shows that equal parameter steps are not equal speed on a rational curve.)
(START, X10 Y0)
G21 G17 G90 G94 G61
G0 X10 Y0
G6.2 P3 K0 X10 Y0 R1 F5000
K0 X10 Y10 R0.5
K0 X-10 Y10 R0.5
K0.25 X-10 Y0 R1
K0.5 X-10 Y-10 R0.5
K0.5 X10 Y-10 R0.5
K0.75 X10 Y0 R1
K1
K1
K1
M30
%
