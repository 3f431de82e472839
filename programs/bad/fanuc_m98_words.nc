; expect fanuc 2:1:sub-missing 3:5:negative-number 4:5:not-whole
M98
M98 P-1
M98 P1.5
M98 P1 X5
M30
O1
M99
