; expect 2:5:unknown-parameter
G0 X#<depth>
M2
