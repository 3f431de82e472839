; expect 2:7:unused-word 3:7:unused-word 4:7:unused-word
G92.1 X1
G92.2 Y1
G92.3 Z1
M2
