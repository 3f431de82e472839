; expect 2:4:modal-conflict 3:5:modal-conflict 4:5:modal-conflict 5:5:modal-conflict 6:4:modal-conflict
G0 G1 X5 F100
G90 G91
G20 G21
G54 G55
M3 M4
M2
