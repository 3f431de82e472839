; expect 3:1:probe-mode
G93
G38.2 Z-5 F1
M2
