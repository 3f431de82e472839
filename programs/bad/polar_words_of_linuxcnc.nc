; expect 2:4:polar-angle 5:4:polar-plane 7:12:polar-words
G0 @5
G0 X1
G18
G0 @5 ^30
G17
G91 G0 ^30 X1
M2
