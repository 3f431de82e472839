; expect 2:8:g10-words 3:12:g10-words 4:8:unknown-tool 5:8:not-whole
G10 L2 P10 X1
G10 L20 P1 R5
G10 L1 P0 Z1
G10 L2 P1.5 X1
M2
