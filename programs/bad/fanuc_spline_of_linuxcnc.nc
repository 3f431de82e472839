; expect fanuc 2:1:unknown-code
G5.2 X1 Y1 P1 L3 F100
M30
