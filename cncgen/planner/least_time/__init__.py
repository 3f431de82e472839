"""`optimal`: the least time along the path with velocity, acceleration and jerk of every axis within their limits.

The unknown is q(s) = v², the square of the speed along the path, as in Verscheure et al. (2009) and, with jerk limits,
Debrouwere et al. (2013). Modules in the order in which data passes them:

    crawling             rows that are so slow that the motion stops at their ends
    breakpoints          where the derivatives of a block and of its neighbours may jump (`Breakpoints`)
    corners              what these are: where to stop, and how fast a corner may be passed (`Corners`)
    mesh_spacing         where the nodes between the breakpoints stand
    mesh                 a block as intervals between nodes (`Mesh`)
    problem              the least-time problem on a row of intervals, and its solution (kernels ``least_time*``)
    time_scaling         a slow but certain solution where the solver finds none
    motion_pieces        the solution as pieces in time
    chord_refinement     chords between setpoints that leave the path too far: lower bounds of q, and solve again
    rolling_window       the look-ahead: solves the open intervals down to a stop, and hands on what is final
    setpoint_alignment   how long a rest in a corner lasts until a setpoint is near enough to it
    timeline             what is final, in time: trajectories, and where they slow down for corners
    block_planning       cuts the toolpath into blocks of about the same work and runs all of this, in threads (`prefetch`), below speed limits from outside (`speed_caps`)
    replanning           the speed of one plan becomes the bound of the next
    contour_bound        plans under a bound of the predicted contour error
    strategy             chooses among the last two

The limits come from `cncgen.planner.limits`.
Method, figures and what is not proved: docs/least-time.md, docs/corners.md, docs/evidence.md.
"""

from cncgen.planner.least_time.block_planning import plan_blocks, smooth_blocks

__all__ = ["plan_blocks", "smooth_blocks"]
