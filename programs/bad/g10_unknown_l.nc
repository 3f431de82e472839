; expect 2:5:g10-words
G10 L3 P1 X1
M2
