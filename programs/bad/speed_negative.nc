; expect 2:1:negative-speed
S-100 M3
M2
