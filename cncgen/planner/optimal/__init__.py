"""`optimal`: the least time along the path with velocity, acceleration and jerk of every axis within their limits.

Method, figures and what is not proved: docs/least-time.md.
"""

from cncgen.planner.optimal.planning import plan_blocks, smooth_blocks

__all__ = ["plan_blocks", "smooth_blocks"]
