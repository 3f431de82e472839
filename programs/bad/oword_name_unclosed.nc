; expect 2:2:syntax
o<drill call [1]
M2
