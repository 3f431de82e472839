"""The limits that a machine and a program set, beneath all strategies.

axis_limits     the limits of the axes as columns, what a jump of the path takes of them, and what they allow along it
speeds          the speed that the program asks of each row, and at which a bend may be passed; jerk-limited changes of speed
row_limits      what each row of a toolpath allows along its path
"""
