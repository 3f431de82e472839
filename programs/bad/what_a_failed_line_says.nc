; expect 2:12:division-by-zero 4:13:unused-word 6:8:repeated-word 8:1:unknown-code
G21 G90 G1 X[1/0] F100
X2
G2 X4 I1 J0 Q3
G2 X6 I1 J0
G18 G1 X7 X8
G2 X10 Z0 I1 K0
G999 G0 X1
X2
M2
