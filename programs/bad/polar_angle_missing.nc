; expect 2:4:polar-angle
G0 @5
M2
