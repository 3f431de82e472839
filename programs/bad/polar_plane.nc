; expect 3:4:polar-plane
G18
G0 @3 ^2
M2
