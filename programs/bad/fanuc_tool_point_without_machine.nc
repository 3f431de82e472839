; expect fanuc 2:1:tcp-machine
G43.4 H1
M30
