; expect 2:1:syntax
{setup}
G0 X1
M2
