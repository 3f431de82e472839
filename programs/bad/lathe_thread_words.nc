; expect 4:1:spindle-stopped 7:1:thread-words
G18 G8
G0 X10 Z0
G76 Z-10 P1 I-1 J0.2 K0.8
M3 S100
G76 Z-10 P0 I-1 J0.2 K0.8
G76 P1 I-1 J0.2 K0.8
M2
