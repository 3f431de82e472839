; expect 2:1:program-abort
(abort, no tool)
M2
