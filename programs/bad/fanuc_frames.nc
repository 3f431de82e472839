; expect fanuc 2:1:rotation-angle 3:1:scale-missing 4:8:scale-missing 5:1:axis-missing 6:6:syntax 7:1:axis-missing
G68 X0 Y0
G51 X0 Y0
G51 X0 P0
G51.1
G68 R
G68 X0 Y0 I1 J0 K0 R5
M30
