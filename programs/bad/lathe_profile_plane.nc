; expect 7:1:profile-plane
o100 sub
G1 X5 Z-5
X10 Z-10
o100 endsub
F100
G71 Q100 D0.5 I1 R1
M2
