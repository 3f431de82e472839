; expect fanuc 9:1:loop-overlap 12:1:loop-nested 15:1:loop-unmatched 26:1:loop-unmatched 18:1:loop-number 19:1:loop-number 20:1:loop-unmatched
O1
#1=0
WHILE[#1LT2]DO1
#1=#1+1
WHILE[#2LT2]DO2
#2=#2+1
END1
END2
WHILE[#3LT2]DO1
#3=#3+1
DO1
END1
END1
DO2
G0 X1
M98 P2
DO 4
END 4
END 3
POPEN
DPRNT[X#1[53]*Y#2[30]]
PCLOS
M30
O2
END2
M99
