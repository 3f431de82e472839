; expect 3:10:arc-end
G0 X5 Y5
G2 X5 Y5 R4 F100
M2
