; expect 2:6:syntax 3:6:syntax
G0 X1'000
G0 X1_000
M2
