; expect fanuc 3:1:arc-scaled
G51 X0 Y0 I2 J3
G2 X10 I5 F100
M30
