; expect fanuc 6:5:goto-target
M98 P1
G0 X1
M30
O1
M99 P77
