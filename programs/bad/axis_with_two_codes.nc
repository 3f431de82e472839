; expect linuxcnc 2:7:axis-words-twice 3:1:axis-words-twice 4:1:axis-words-twice
G0 X1 G92
G28 G0 X1
G10 L2 P1 G1 X5
M2
