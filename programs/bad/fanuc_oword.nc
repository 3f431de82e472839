; expect fanuc 2:1:unsupported-flow
O1 CALL
M30
