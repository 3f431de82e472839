; expect fanuc 2:1:goto-target
GOTO 99
M30
