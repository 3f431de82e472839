; expect fanuc 2:1:parameter-number 3:5:parameter-number 4:1:parameter-read-only 5:1:parameter-read-only 6:1:parameter-number
#99999=1
G0 X#30000
#5001=1
#0=3
#1=#[1.5]
M30
