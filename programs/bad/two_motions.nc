; expect 3:4:modal-conflict
F100
G0 G1 X1
M2
