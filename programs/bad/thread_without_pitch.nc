; expect 3:1:pitch-missing
S100 M3
G33 Z-5
M2
