; expect 2:1:feed-missing
G38.2 Z-5
M2
