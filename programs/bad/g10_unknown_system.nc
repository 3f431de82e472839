; expect 2:8:g10-words
G10 L2 P10 X1
M2
