; expect fanuc 2:1:pitch-missing 3:9:pitch-missing 4:1:spindle-stopped
G33 Z-5
G33 Z-5 F0
G33 Z-5 F1
M30
