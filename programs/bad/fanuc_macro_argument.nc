; expect fanuc 2:8:syntax
G65 P1 N5
M30
O1
M99
