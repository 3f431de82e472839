; expect 2:4:repeated-word
G0 X0x10
M2
