; expect 2:8:negative-feed
G1 X10 F-5
M2
