; expect 3:6:syntax
#<depth>=5
O100 G0 X#<depth>
M2
