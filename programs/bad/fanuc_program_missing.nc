; expect fanuc 2:1:sub-missing
M98 P1234
M30
