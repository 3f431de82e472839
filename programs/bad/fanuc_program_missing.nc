; expect fanuc 2:5:sub-missing
M98 P1234
M30
