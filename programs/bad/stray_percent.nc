; expect 3:1:stray-percent
G0 X1
%
M2
