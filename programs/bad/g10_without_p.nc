; expect 2:1:g10-words
G10 L2 X1
M2
