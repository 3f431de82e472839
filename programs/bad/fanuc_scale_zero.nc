; expect fanuc 2:11:scale-missing
G51 X0 Y0 P0
M30
