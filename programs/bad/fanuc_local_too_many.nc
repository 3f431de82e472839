; expect fanuc 2:8:macro-arguments 3:8:macro-arguments 4:8:syntax 5:8:syntax
G65 P1 I1 I2 I3 I4 I5 I6 I7 I8 I9 I10 I11
G65 P1 G0 X1
G65 P1 N5
G65 P1 O5
M30
O1
M99
