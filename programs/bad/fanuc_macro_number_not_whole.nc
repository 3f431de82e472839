; expect fanuc 2:5:not-whole 3:8:not-whole 4:8:negative-number
G65 P1.5
G65 P2 L1.5
G65 P2 L-1
M30
O2
M99
