; expect 2:1:speed-missing
G96 D1000
M2
