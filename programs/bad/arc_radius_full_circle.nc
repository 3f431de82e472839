; expect 3:10:arc-end 4:1:arc-end
F100 G0 X5
G2 X5 Y0 R5
G3 R5
M2
