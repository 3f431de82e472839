; expect fanuc 3:1:cycle-words 5:1:cycle-words 7:11:cycle-depth 9:15:cycle-repeats 10:15:dwell-negative
G0 Z5 F100
G81 X1 R2
G80
G83 X1 R2 Q1
G80
G81 X1 Z5 R2
G80
G81 X1 Z-5 R2 K1.5
G82 X1 Z-5 R2 P-1
M30
