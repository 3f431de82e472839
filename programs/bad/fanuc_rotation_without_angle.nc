; expect fanuc 2:1:rotation-angle
G68 X0 Y0
M30
