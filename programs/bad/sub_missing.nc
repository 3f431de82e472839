; expect 2:1:sub-missing
o<nowhere> call
M2
