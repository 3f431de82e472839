; expect 2:1:axis-words-twice
G92 G1 X1 F100
M2
