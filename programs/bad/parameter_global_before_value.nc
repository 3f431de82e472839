; expect 2:5:unknown-parameter
G0 X#<_width>
M2
