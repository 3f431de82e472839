; expect 2:6:syntax
G0 X-
M2
