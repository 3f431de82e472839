; expect 2:5:negative-number 3:8:syntax
G41 D-1
G41.1 D
M2
