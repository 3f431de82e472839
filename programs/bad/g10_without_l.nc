; expect 2:1:g10-words
G10 P1 X1
M2
