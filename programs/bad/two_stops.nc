; expect 2:4:modal-conflict
M0 M2
