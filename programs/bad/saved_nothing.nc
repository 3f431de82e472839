; expect 2:1:nothing-saved 5:1:nothing-saved
M72
M70
M71
M72
M2
