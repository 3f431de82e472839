; expect 5:5:thread-words 6:16:thread-words 7:1:thread-words
G50 S2000
G97 S800 M3
G0 X30. Z5.
G76 P010061 Q100
G76 X20. Z-20. P-900 Q300 F1.5
G76 X20. Z-20. Q300 F1.5
M30
