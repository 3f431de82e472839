; expect 2:1:wait-time
M66 P0 L3
M2
