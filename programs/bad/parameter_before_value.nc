; expect 2:1:unknown-parameter 3:5:unknown-parameter
#<depth>=[#<top>-2]
G0 Z#<depth>
M2
