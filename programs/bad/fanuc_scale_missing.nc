; expect fanuc 2:1:scale-missing
G51 X0 Y0
M30
