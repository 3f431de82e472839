; expect 2:5:modal-conflict
G17 G18
M2
