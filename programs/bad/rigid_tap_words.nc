; expect 2:1:spindle-stopped 4:1:pitch-missing 5:11:pitch-missing 6:1:tapping-axes
G33.1 Z-5 K1
M3 S100
G33.1 Z-5
G33.1 Z-5 K-1
G33.1 Z-5 A3 K1
M2
