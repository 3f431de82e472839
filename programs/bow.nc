%
(Bow: large figure eight.)
(Shows long travel at the programmed feed; the curve crosses itself.)
(START, X0 Y0)
G21 G17 G90 G94 G61
G0 X0 Y0
G6.2 P3 K0 X0 Y0 R1 F6000
K0 X-150 Y-150 R25
K0 X-150 Y150 R25
K0.25 X0 Y0 R1
K0.5 X150 Y-150 R25
K0.5 X150 Y150 R25
K0.75 X0 Y0 R1
K1
K1
K1
M30
%
