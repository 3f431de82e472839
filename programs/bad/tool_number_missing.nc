; expect 2:1:tool-missing 3:5:negative-number 4:1:negative-number 5:1:not-whole
M61
M61 Q-1
T-1
T1.5
M2
