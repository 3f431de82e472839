; expect fanuc 2:19:syntax 3:4:syntax
WHILE [#1 LT 3] DO
END
M30
