; expect fanuc 3:1:goto-target
O1
GOTO 20
M30
O2
N20 M99
