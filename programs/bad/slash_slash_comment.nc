; expect 2:2:syntax 3:7:syntax
// setup
G0 X1 // move
M2
