; expect 2:1:start-words
(START, here)
M2
