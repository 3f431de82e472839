; expect 2:7:open-comment
G0 X1 (to be continued
M2
