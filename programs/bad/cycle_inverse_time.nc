; expect 3:1:cycle-feed-mode
G93
G81 X1 Z-5 R2 F100
M2
