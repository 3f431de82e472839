; expect fanuc 2:1:g10-words 3:1:g10-words 4:5:g10-words 5:8:g10-words 6:9:g10-words 7:7:system-number 8:5:system-number
G10 L10 P1
G10 L10 R5
G10 L99 P1 R1
G10 L2 P7 X1
G10 L20 P301 X1
G54.1 P301
G54 P0
M30
