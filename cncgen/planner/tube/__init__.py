"""Path and speed chosen together within the tolerance of G64 (docs/tube.md). Modules in the order in which data passes them:

programmed       the rows of the program, from which the tolerance is measured
chorded          its curves as lines: sharp bends, and all of them for the plan that is improved
reference_path   the plan that is improved, sampled
row_places       where on it the rows begin
scales           the limits of the search, and times and speeds at corners
tube_nodes       where nodes stand on it, and the room around each
window_problem   the least-time problem on a window of nodes (kernel ``least_time_tube``)
window_start     first guesses of its solution
deviation        how far a solution leaves the rows between its nodes
window_judge     whether it holds limits at and between its nodes, and meets its neighbours
handing          trajectories: improved stretches, and stretches that stand as they were
window_rounds    rounds of a window's search, each with less room where the one before left the tolerance
window_search    the search of one window after the other; the first rounds of the next two are made in another thread meanwhile
row_runs         rows that are planned together: their nodes, and where on them a motion is
stream           runs all of this, window by window
"""

from cncgen.planner.tube.chorded import chorded, cornered
from cncgen.planner.tube.programmed import Programmed
from cncgen.planner.tube.stream import improve

__all__ = ["Programmed", "chorded", "cornered", "improve"]
