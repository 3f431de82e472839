; expect 3:1:unknown-code
G21
G123 X1
M2
