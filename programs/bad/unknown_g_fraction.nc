; expect 2:1:unknown-code
G1.5 X1
M2
