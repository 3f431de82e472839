; expect fanuc 2:1:axis-missing
G31 F100
M30
