; expect 2:16:syntax
G1 X10 Y20 F200/2
M2
