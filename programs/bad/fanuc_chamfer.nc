; expect linuxcnc 3:7:syntax 4:4:syntax
F100
G1 X10,C2
Y10,R3
G1 X0
M30
