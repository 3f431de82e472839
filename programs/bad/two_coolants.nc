; expect 2:4:modal-conflict
M7 M8
M2
