; expect fanuc 2:1:axis-missing
G51.1
M30
