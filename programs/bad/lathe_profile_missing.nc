; expect 3:5:sub-missing 4:1:profile-missing
G18
G71 Q100 D0.5 I1 R1 F100
G70 D0.1 F100
M2
