; expect 2:11:polar-words
G0 @5 ^30 X1
M2
