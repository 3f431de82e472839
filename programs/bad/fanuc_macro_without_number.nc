; expect fanuc 2:1:sub-missing
G65 A1 B2
M30
