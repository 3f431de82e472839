; expect 2:7:syntax
G0 A90°
M2
