; expect 7:1:comp-gouge 8:1:comp-gouge
T1 M6
G10 L1 P1 R5
G0 X0 Y0
G41 D1 G1 X10 Y0 F100
X12
Y3
X0
G40 G0 Y20
M2
