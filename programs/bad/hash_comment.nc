; expect 2:3:syntax
# setup
G0 X1
M2
