; expect 2:7:tool-length-words 3:1:tool-length-words
G43.2 H1 X1
G43.2
M2
