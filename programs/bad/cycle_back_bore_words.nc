; expect 3:1:cycle-words
M3 S100 G0 Z5
G87 X1 Z-5 R-10 F100
M2
