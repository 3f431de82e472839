; expect 2:1:pin-missing 3:1:pin-missing 4:8:wait-mode 5:8:wait-mode 6:1:wait-time
M66
M66 P0 E0
M66 P0 L5
M66 E0 L3 Q1
M66 P0 L3
M2
