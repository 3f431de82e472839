; expect fanuc 2:1:unknown-code 3:1:unknown-code 4:1:unknown-code 5:1:unknown-code 6:1:unknown-code 7:1:unknown-code 8:1:unknown-code
G10.6
G2.2 X1
G68.3 X0 Y0 Z0 R0
G54.4 P1
G66.1 P1
G5.4 P1
G90.3
M30
