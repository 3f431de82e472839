; expect 2:8:syntax 3:1:unknown-code 4:7:negative-feed 5:4:repeated-word 7:16:open-comment
G0 X1.5.
G999
G1 X5 F-3
G0 Y1 Y2
G0 Z1
G1 X1 Y1 F100  (open
M2
