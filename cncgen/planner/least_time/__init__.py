"""`optimal`: the least time along the path with velocity, acceleration and jerk of every axis within their limits.

The unknown is q(s) = v², the square of the speed along the path, as in Verscheure et al. (2009) and, with jerk limits,
Debrouwere et al. (2013). Modules in the order in which data passes them:

    blocks      chunks of the toolpath become blocks of a fixed number of rows
    paces       the feed of each row as a speed; rows that are so slow that the motion stops at their ends
    limits      the limits of the axes (`Bounds`), and what they allow along the path
    joints      breakpoints of a block: where to stop, and how fast a corner may be passed (`Joints`)
    nodes       where the nodes between the breakpoints stand
    track       a block as intervals between nodes (`Track`)
    trials      corners that no estimate decides: planned both ways
    problem     the least-time problem on a row of intervals, and its solution (kernels ``least_time*``)
    creeping    a slow but certain solution where none is found
    pieces      the solution as pieces in time
    chords      chords between setpoints that leave the path too far: lower bounds of q, and solve again
    window      the look-ahead: solves the open intervals down to a stop, and hands on what is final
    rests       how long a rest in a corner lasts until a setpoint is near enough to it
    timeline    what is final, in time: trajectories, and where they slow down for corners
    planning    runs all of this, in threads (`ahead`), below speed limits from outside (`caps`)

Method, figures and what is not proved: docs/least-time.md, docs/corners.md, docs/evidence.md.
"""

from cncgen.planner.least_time.planning import plan_blocks, smooth_blocks

__all__ = ["plan_blocks", "smooth_blocks"]
