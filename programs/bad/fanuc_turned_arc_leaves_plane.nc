; expect fanuc 4:1:arc-turned
G68 X0 Y0 R30
G18
G2 X10 I5 F100
M30
