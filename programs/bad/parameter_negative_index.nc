; expect 2:6:syntax 3:1:parameter-number
G0 X#-1
#[0-5]=1
M2
