; expect 3:11:arc-radius
G0 X10 Y0
G3 X0 Y11 I-10 F100
M2
