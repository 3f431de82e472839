; expect fanuc 3:1:goto-target 4:1:unknown-code 5:5:sub-missing 6:5:sub-missing 8:1:unknown-code 11:10:goto-target 12:17:loop-unmatched 13:1:repeated-word 14:5:sub-missing 16:1:loop-unmatched 17:1:repeated-word 18:5:goto-target
O1
GOTO 99
G999
M98 P1234
G65 P9999 A1
WHILE[#1LT3]DO1
G998
#1=#1+1
END1
IF[#1EQ3]GOTO 98
WHILE [#2 LT 3] DO 2
T1 T2
M98 P55
#1=1
END 3
T3 T4
M99 P400
M30
