; expect 2:1:feed-missing 3:4:repeated-word 4:1:unknown-code 5:9:division-by-zero 6:1:arc-centre 7:7:open-comment
G1 X1
G0 X2 X3
G999
F100 G1 X[1/0]
G2 X10
G0 X1 (open
M2
