; expect 2:1:sub-path
o<../secret> call
M2
