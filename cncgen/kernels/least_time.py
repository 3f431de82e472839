# cython: infer_types=True
"""Primal-dual interior-point method for the least time along a path (docs/least-time.md).

Called by `cncgen.planner.least_time.problem`. The problem is that of Verscheure et al. (2009) in q = v², with jerk limits as in
Debrouwere et al. (2013).

Unknown is q(s) = v² where its tangents at both ends of an interval meet: ``c[k + 1]`` belongs to interval `k`, on which the
jerk along the path is constant (`cncgen.kernels.least_time_ways`). The values at the interval's ends are ``b0 = ends[k,0] c[k]
+ ends[k,1] c[k+1]`` and ``b2 = ends[k,2] c[k+1] + ends[k,3] c[k+2]``. ``c[0]`` and ``c[n+1]`` are given; so is ``c[1]`` where
the window starts in motion. Minimised is

    F = Σ h/6 (b0^-1/2 + 4 m^-1/2 + b2^-1/2) + Σ extra0 b0^-1/2 + Σ extra2 b2^-1/2,

m being q in the middle, subject to rows r ± A·(q, d, κ) ≥ 0 at the ends of the intervals (`cncgen.kernels.least_time_problem`)
that each touch three neighbours. Hence the Newton matrix has five diagonals, and the work of an iteration is linear in the
number of intervals.

Rows are awake or asleep, and an iteration takes only those that are awake. Asleep are bounds of q and of the acceleration that
the iterate is far from; they wake when it comes near (an active-set idea within an interior-point method).

The function r is convex, so its tangent lies below it: a step that holds the linearised constraint holds the constraint itself,
which is why an iterate never leaves the feasible set (Hunter and Lange (2004), section 3.2, supporting hyperplanes), and slacks
may be reset to the constraint's value wherever that is larger. (Settling the ways moves rows, by less from step to step.) Steps
are Mehrotra's predictor and corrector (Mehrotra (1992); Nocedal and Wright, Numerical Optimization (2006), Algorithm 14.3),
with separate lengths for slacks and for multipliers.
"""

import cython
from cython.cimports.cncgen.kernels.least_time_between import apply, tighten
from cython.cimports.cncgen.kernels.least_time_matrix import factorize, substitute, survey, turn
from cython.cimports.cncgen.kernels.least_time_passes import correct, gather, predict, set_up, wake
from cython.cimports.cncgen.kernels.least_time_problem import Problem, sides
from cython.cimports.cncgen.kernels.least_time_ways import agree, refit, settle
from cython.cimports.libc.math import fabs, sqrt

#: Quantity that a row bounds: q or the middle ordinate, acceleration or d, jerk.
BOX, ACCELERATION, JERK = range(3)
#: Intervals at the start of a window in motion whose limits are eased (`least_time_between.apply`).
_EASED = cython.declare(cython.Py_ssize_t, 3)
#: The method has stalled after this many iterations in a row with short steps, or with the gap at its target but the residual
#: not. (One short step alone is usual after a limit was lowered.)
_STALLED = cython.declare(cython.int, 3)
#: Duality gap, as a part of the time, below which an iterate is near the optimum: a run that stalls may return it as a plan.
_SETTLED = cython.declare(cython.double, 2e-4)
#: Largest dual residual, as a part of the time, at the optimum, and of a plan to fall back on. A smaller one cannot be asked for:
#: at a gap of 10⁻⁷ slacks are differences of numbers a million times as large, and rounding may leave this much.
_RESIDUAL = cython.declare(cython.double, 1e-4)
_TRUSTED = cython.declare(cython.double, 1e-3)
#: The largest part of an ordinate of q by which a step may lower it. From more than 1.84 = 2.5^(2/3) times the minimum of q^-1/2
#: plus a linear term Newton's step leads below zero; and once q is far below the minimum each step raises it by 5/3 only.
_TAKEN = cython.declare(cython.double, 0.4)


#: Change of a way as a part of its interval to which they are settled for a start, and at the end; how often that is tried at most; and
#: the change after which the motion is taken anew.
_ROUGHLY = cython.declare(cython.double, 1e-3)
_AGREED = cython.declare(cython.double, 1e-13)
_TIMES = cython.declare(cython.int, 60)
_MOVED = cython.declare(cython.double, 1e-9)
#: Cost of accelerations that differ where the motion turns back, by the square of their ratio's logarithm and half the time beside it. What
#: F gains by a difference is up to a hundred of these times, so they differ by 10⁻⁶.
_TIED = cython.declare(cython.double, 1e8)


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _tie(
    problem: Problem, dual: cython.double[::1], right: cython.double[::1], band: cython.double[:, ::1]
) -> cython.void:
    """Add the cost of accelerations that differ on both sides of a place where the motion turns back.

    Args:
        problem: The problem.
        dual, right, band: As of `_NewtonSystem`.
    """
    for k in range(problem.n - 1):
        if problem.back[k] != 0:
            one = problem.ends[k, 2] / problem.extra[k, 1]
            other = problem.ends[k + 1, 1] / problem.extra[k + 1, 0]
            apart = one * problem.c[k + 1] - other * problem.c[k + 2]
            mean = 0.5 * (one * problem.c[k + 1] + other * problem.c[k + 2])
            # The interval beside it takes extra q^-1/2, with q = extra a.
            weight = _TIED * sqrt(problem.extra[k, 1] / mean) / (mean * mean)
            dual[k + 1] += weight * apart * one
            dual[k + 2] -= weight * apart * other
            right[k + 1] -= weight * apart * one
            right[k + 2] += weight * apart * other
            band[0, k + 1] += weight * one * one
            band[1, k + 1] -= weight * one * other
            band[0, k + 2] += weight * other * other


@cython.cclass
class _NewtonSystem:
    """The Newton system of a problem about its unknowns, and what an iteration changes.

    Attributes:
        problem: The problem.
        sides: One-sided constraints that are awake.
        band: Three upper diagonals of the Newton matrix.
        dual, right: Residual ∇F − Σ λ ∇g, and right side.
        centre, second: Terms that the corrector's right side adds to the predictor's, by mu and beside it.
        dc: The step.
        out: Results of a pass over the rows.
        step, rise: Part of it that unknowns and slacks have gone, and that multipliers go in the next `gather`.
        gap, broken: Σ λ w, and the largest part of a limit by which it is passed.
    """

    problem: Problem
    sides: cython.Py_ssize_t
    band: cython.double[:, ::1]
    dual: cython.double[::1]
    right: cython.double[::1]
    centre: cython.double[::1]
    second: cython.double[::1]
    dc: cython.double[::1]
    out: cython.double[::1]
    step: cython.double
    rise: cython.double
    gap: cython.double
    broken: cython.double

    def __init__(self, problem: Problem) -> None:
        """Make room beside the problem."""
        n: cython.Py_ssize_t = problem.n
        import numpy

        self.problem = problem
        self.dual, self.right, self.centre, self.second, self.dc = numpy.zeros((5, n + 2))
        self.band, self.out = numpy.zeros((3, n + 2)), numpy.zeros(4)
        self.step = self.rise = self.gap = self.broken = 0.0
        self.sides = sides(problem)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def gather(self) -> cython.void:
        """Go with slacks and multipliers where the unknowns have gone, and set up matrix, right side and residual."""
        gather(self.problem, self.step, self.rise, self.dual, self.right, self.band, self.out)
        _tie(self.problem, self.dual, self.right, self.band)
        self.broken = self.out[0]
        self.gap = self.out[1]

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def set_up(self, mu: cython.double) -> cython.void:
        """Set up slacks and multipliers on the central path."""
        wake(self.problem, mu)
        set_up(self.problem, mu)
        self.sides = sides(self.problem)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def wake(self) -> cython.void:
        """Wake the rows that come near their limits."""
        if wake(self.problem, self.gap / max(self.sides, 1)):
            self.sides = sides(self.problem)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def residual(self) -> cython.double:
        """Return Σ |∇F − Σ λ ∇g| c over the free unknowns."""
        total: cython.double = 0.0
        for k in range(self.problem.free, self.problem.n + 1):
            total += fabs(self.dual[k] * self.problem.c[k])
        return total

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def factorize(self) -> cython.bint:
        """Factor the matrix; return False where rounding has taken its positive diagonal."""
        return factorize(self.band, self.problem.free, self.problem.n + 1)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def answer(self, dc: cython.double[::1]) -> cython.void:
        """Solve the factored system for its right side."""
        substitute(self.band, self.problem.free, self.problem.n + 1, self.right, dc)

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def advance(self, least: cython.double) -> cython.void:
        """Move the unknowns by Mehrotra's predictor and corrector; the latter aims at a gap of at least `least`.

        Mehrotra (1992); Algorithm 14.3 of Nocedal and Wright (2006): `sigma` is μ_aff/μ, whose cube is the centring parameter,
        and a step goes 0.99 of the way to the nearest bound.
        """
        self.answer(self.dc)
        lowest = turn(self.problem, self.dc)
        predict(self.problem, self.second, self.centre, self.out)
        step = 1.0 / max(1.0, max(self.out[0], lowest / _TAKEN))
        ahead = 1.0 / max(1.0, self.out[1])
        # Σ w Δλ is −Σ λ w − Σ λ Δw, as the predictor aims at λ w = 0.
        sigma = 1.0 - ahead + ((step - ahead) * self.out[2] + step * ahead * self.out[3]) / self.gap
        mu = max(sigma * sigma * sigma * self.gap, least) / self.sides
        for k in range(self.right.shape[0]):
            self.right[k] += self.second[k] + mu * self.centre[k]
        self.answer(self.dc)
        lowest = turn(self.problem, self.dc)
        correct(self.problem, mu, self.out)
        self.step = 1.0 / max(1.0, max(self.out[0] / 0.99, lowest / _TAKEN))
        self.rise = 1.0 / max(1.0, self.out[1] / 0.99)
        for k in range(self.right.shape[0]):
            self.problem.c[k] += self.step * self.dc[k]


@cython.cclass
class _StoppingRule:
    """Whether an iteration has come to its end, and the best iterate that is near enough to the optimum.

    Attributes:
        tolerance, slack: As `solve` takes them.
        near, gap: That iterate and its duality gap, 1e300 for none yet.
        worst: The largest part of a limit that was last found between the ends of intervals.
        stalled: Iterations in a row that came no nearer.
    """

    tolerance: cython.double
    slack: cython.double
    near: cython.double[::1]
    gap: cython.double
    worst: cython.double
    stalled: cython.int

    def __init__(self, tolerance: cython.double, slack: cython.double, size: cython.Py_ssize_t) -> None:
        """Know nothing yet."""
        import numpy

        self.tolerance, self.slack, self.near, self.gap = tolerance, slack, numpy.zeros(size), 1e300
        self.worst, self.stalled = 0.0, 0

    @cython.cfunc
    @cython.nogil
    @cython.exceptval(check=False)
    def of(self, system: _NewtonSystem, f: cython.double, residual: cython.double) -> cython.int:
        """Return 0 at the optimum, −1 where no further iteration would come nearer, 1 else."""
        optimal: cython.bint = system.gap < 2.0 * self.tolerance * f
        held: cython.bint = self.worst < 1.0 + self.slack and system.broken < self.slack
        if held and optimal and residual < _RESIDUAL * f:
            return 0
        if held and residual < _TRUSTED * f and system.gap < self.gap:
            self.gap = system.gap
            self.near[:] = system.problem.c
        elif self.gap < _SETTLED * f:
            self.stalled = self.stalled + 1 if optimal or system.step < 0.02 else 0
            if system.gap > 3.0 * self.gap or self.stalled == _STALLED:
                return -1
        return 1


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _due(iteration: cython.int, gap: cython.double) -> cython.bint:
    """Tell whether to look between the ends of the intervals: far from the optimum the shares may lag by an iteration.

    Args:
        iteration: Number of it.
        gap: The last one's duality gap as a part of F.
    """
    return iteration > 2 and (gap < 0.012 or (gap < 0.3 and iteration % 2 == 0))


@cython.cfunc
@cython.nogil
@cython.exceptval(check=False)
def _respond(system: _NewtonSystem, gathered: cython.bint, out: cython.double[::1]) -> cython.void:
    """Fill `out` with the last column of the inverse Newton matrix, as a part of its last entry, where it can be factored.

    Args:
        system: Its matrix is that of the iterate if `gathered`, else of an earlier one.
        out: Shape (n + 2,).
    """
    n: cython.Py_ssize_t = system.problem.n
    if not gathered:
        system.step = system.rise = 0.0
        survey(system.problem)
        system.gather()
    if system.factorize():
        for k in range(n + 2):
            system.right[k] = 0.0
        system.right[n] = 1.0
        system.answer(out)
        end = out[n]
        for k in range(n + 2):
            out[k] /= end


def solve(
    problem: Problem,
    tolerance: cython.double,
    slack: cython.double,
    most: cython.int,
    report: cython.double[::1],
    change: cython.double[::1],
) -> int:
    """Improve the unknowns to the least time within the rows; the problem is changed in place.

    Args:
        problem: With its rows, and unknowns to start from.
        tolerance: Duality gap as a part of F at which to end.
        slack: Part by which a limit may be passed between the ends of an interval.
        most: Iterations at most.
        report: Shape (7,): F, gap, primal infeasibility, iterations, dual residual, worst ratio between the ends, and by which part
            of its interval a way still changed when they were last settled.
        change: Shape (n + 2,), zeros: becomes dc/dc[n], how the solution follows where its last unknown is pushed, a change of q
            by the change of q at the end. Stays as it is where the matrix lost its positive diagonal by rounding.

    Returns:
        0; 1 where it came near and then stalled (every limit held, dual residual ten times larger at most); or why it did
        not converge: −1 out of iterations, or rows that do not hold a limit between the ends of intervals; −2 the matrix
        lost its positive diagonal by rounding.
    """
    system: _NewtonSystem = _NewtonSystem(problem)
    verdict: _StoppingRule = _StoppingRule(tolerance, slack, problem.n + 2)
    iteration: cython.int = 0
    status: cython.int = 1
    fresh: cython.bint
    eased: cython.Py_ssize_t = _EASED if problem.free > 1 else 0
    f: cython.double = 0.0
    residual: cython.double = 0.0
    left: cython.double = 0.0
    with cython.nogil:
        agree(problem, _ROUGHLY, _TIMES)
        refit(problem)
        apply(problem, slack, eased)
        for iteration in range(most):
            f = survey(problem)
            if _due(iteration, system.gap / f):
                fresh = system.gap > 0.0006 * f
                if settle(problem, fresh) > _MOVED:
                    f = survey(problem)
                refit(problem)
                verdict.worst = tighten(problem, slack, eased, fresh)
                if fresh or verdict.worst > 1.0 + slack:
                    apply(problem, slack, eased)
            if iteration == 0:
                system.set_up(3.0 * f / system.sides)
            else:
                system.wake()
            system.gather()
            residual = system.residual()
            status = verdict.of(system, f, residual)
            if status < 1:
                break
            if not system.factorize():
                status = -2
                break
            system.advance(tolerance * f)
        if status != 0 and verdict.gap < 1e300:
            # Stalled beside the optimum: by rounding, or where a limit was lowered last.
            problem.c[:] = verdict.near
            f = survey(problem)
            system.gap = verdict.gap
            system.broken = 0.0
            status = 1
        elif status == 1:
            status = -1
        left = agree(problem, _AGREED, _TIMES)
        f = survey(problem)
    report[0] = f
    report[1] = system.gap
    report[2] = system.broken
    report[3] = iteration
    report[4] = residual
    report[5] = verdict.worst
    report[6] = left
    with cython.nogil:
        _respond(system, status == 0, change)
    return status
