; expect fanuc 5:1:too-many-steps
#1=1
WHILE[#1EQ1]DO1
#2=#2+1
END1
M30
