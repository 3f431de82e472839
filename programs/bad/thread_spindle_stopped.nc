; expect 2:1:spindle-stopped
G33 Z-5 K1
M2
