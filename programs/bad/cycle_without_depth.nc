; expect 3:1:cycle-words 4:1:cycle-words
G0 Z5
G81 X1 Y1 R2 F100
G83 X1 Z-5 R2 F100
M2
