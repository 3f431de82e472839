; expect 2:11:tool-orientation
G10 L1 P1 Q10
M2
