; expect fanuc 2:11:syntax
G65 P1 A1 O5
M30
O1
M99
