"""What a machine and a program allow, beneath all strategies.

axis_limits   the limits of the axes as columns, and what they allow along a path
bend_speeds   the speed at which a bend may be passed
rows          what each row of a toolpath allows along its path
"""
