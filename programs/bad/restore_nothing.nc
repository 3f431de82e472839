; expect 2:1:nothing-saved
M72
M2
