"""Jung and Choi: interpolators to three digits, the stateline at a corner, and no deadlock ever."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from cncgen.kernels import servo_stateline
from cncgen.servo.controllers import stateline
from cncgen.servo.controllers.stateline import Rule, StatelineAxis, run_stateline
from cncgen.setpoints.two_stage import second_stage
from tests.kernels.plain import uncompiled

AXES = (StatelineAxis(60.0, 0.004), StatelineAxis(60.0, 0.004))


def corner(speed=50.0, length=25.0, period=0.016):
    s = np.arange(0.0, length + 1e-9, speed * period)
    return np.concatenate([np.column_stack([s, 0 * s]), np.column_stack([0 * s[1:] + s[-1], s[1:]])])


@pytest.mark.parametrize(
    ("kind", "radial_um", "jump_mm_s"), [(2, -16.0, 7.996), (3, -0.0192, 0.0128), (4, -0.0255, 0.320)]
)
def test_interpolators_on_a_circle(kind, radial_um, jump_mm_s):
    """R = 20 mm, 100 mm/s, Δt = 16 ms: the figures −16.0, −0.019, −0.026 µm; 7.996, 0.0128, 0.320 mm/s."""
    radius, speed, period = 20.0, 100.0, 0.016
    angle = np.arange(300) * speed * period / radius
    master = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    fine = second_stage(master, 32, kind)[320:-320]
    off = np.hypot(*fine.T) - radius
    assert off[np.abs(off).argmax()] * 1e3 == pytest.approx(radial_um, rel=4e-3)
    # Quadratic pieces: the speed at a knot follows exactly from the two half-way speeds on either side.
    parts = 64
    rates = np.diff(second_stage(master, parts, kind), axis=0) / (period / parts)
    knots = np.arange(10, 290) * parts
    right, left = 1.5 * rates[knots] - 0.5 * rates[knots + 1], 1.5 * rates[knots - 1] - 0.5 * rates[knots - 2]
    assert np.hypot(*(right - left).T).max() == pytest.approx(jump_mm_s, rel=2e-3)


@pytest.mark.parametrize(("kind", "share"), [(2, 0.0), (3, 0.0625), (4, 0.125)])
def test_interpolators_at_a_right_angle(kind, share):
    """They leave a corner by 0, 0.0625 h and 0.125 h (h the master's step)."""
    h = 0.8
    fine = second_stage(corner(), 32, kind)
    overshoot = max(fine[:, 0].max() - corner()[:, 0].max(), -fine[:, 1].min())
    assert overshoot == pytest.approx(share * h, rel=0.02, abs=1e-12)


def test_the_stateline_cuts_the_corner_miss_eightfold_for_little_time():
    master = corner()
    reference, apex = second_stage(master, 32, 2), np.array([master[:, 0].max(), 0.0])
    free = run_stateline(reference, AXES, Rule.NONE, 0.05)
    for rule in (Rule.ERROR, Rule.RULE_2):
        watched = run_stateline(reference, AXES, rule, 0.05)
        misses = [np.hypot(*(r.position - apex).T).min() for r in (free, watched)]
        assert misses[0] >= 8.0 * misses[1]
        assert watched.time_s <= 1.05 * free.time_s
        assert watched.held > 0


@given(
    st.integers(0, 10**6),
    st.sampled_from([Rule.ERROR, Rule.RULE_2, Rule.JERK]),
    st.integers(2, 4),
    st.floats(-4, 0),
    st.floats(5, 200),
    st.floats(5e-4, 0.02),
)
def test_motion_always_ends_and_the_path_keeps_its_shape(seed, rule, kind, bound, gain, lag):
    rng = np.random.default_rng(seed)
    master = np.cumsum(rng.normal(size=(rng.integers(2, 30), 2)) * rng.uniform(0.05, 2.0), axis=0)
    axis = StatelineAxis(min(gain, 0.8 / lag), lag)
    reference = second_stage(master, 32, kind)
    run = run_stateline(reference, (axis, axis), rule, 10.0**bound)
    assert run.place[-1] == len(reference) - 1
    assert run.forced == 0
    assert (np.diff(run.place) >= 0).all()
    assert np.diff(run.place).max(initial=0) <= 1
    assert np.abs(run.position[-1] - reference[-1]).max() <= 10.0**bound + 1e-5


def test_no_deadlock_over_1000_random_paths_and_gains():
    rng = np.random.default_rng(1)
    for _ in range(1000):
        master = np.cumsum(rng.normal(size=(rng.integers(2, 12), 2)) * rng.uniform(0.05, 2.0), axis=0)
        lags = rng.uniform(5e-4, 0.02, 2)
        axes = [StatelineAxis(min(rng.uniform(5, 200), 0.8 / lag), lag) for lag in lags]
        rule = Rule(int(rng.integers(1, 4)))
        reference = second_stage(master, 32, int(rng.integers(2, 5)))
        run = run_stateline(reference, axes, rule, 10.0 ** rng.uniform(-3, 0))
        assert run.place[-1] == len(reference) - 1
        assert run.forced == 0


def followed(reference, axes, rule, bound, period=0.0005, spread=0.016):
    """Eqs 7, Rule 2 and the jerk rule term by term, with each loop's step by the matrix exponential; shorter than patience.

    Returns positions and reference index of each control period, and how many periods were held.
    """
    n = len(reference)
    speeds = np.zeros(
        (n + 3, len(axes))
    )  # of the period that ends at row i; 0 before the first and after the last row
    speeds[1:n] = np.diff(reference, axis=0) / period
    gains = np.array([axis.error_gains for axis in axes])
    kve, kac, kje = gains.T
    flows = [
        expm(period * np.array([[0.0, 1.0, 0.0], [0.0, -1.0 / axis.lag, 1.0 / axis.lag], [0.0, 0.0, 0.0]]))
        for axis in axes
    ]
    state = np.column_stack([reference[0], np.zeros(len(axes))])
    at, moved, moved_before = 0, 0.0, 0.0
    positions, places, held = [], [], 0
    while True:
        error = reference[at] - state[:, 0]
        if at == n - 1 and (np.abs(error) <= bound + 1e-6).all():
            return np.array(positions), places, held
        now, following, after = moved * speeds[at], speeds[at + 1], speeds[at + 2]
        before = moved_before * speeds[at - 1] if at else 0.0 * now
        left = {
            Rule.NONE: 0.0 * error,
            Rule.ERROR: error,
            Rule.RULE_2: error + (kve + kac / spread) * (following - now),
            Rule.JERK: error
            + (kve + kac / spread) * (following - now)
            + kje / spread * ((after - following) - (now - before)),
        }[rule]
        # An axis whose error is within the bound never holds the line: waiting cannot help it.
        agrees = (np.abs(error) <= bound) | (np.abs(left) <= np.abs(kve * following) + bound)
        high = at < n - 1 and bool(agrees.all())
        held += at < n - 1 and not high
        moved, moved_before = float(high), moved
        at += high
        for i, axis in enumerate(axes):
            command = axis.gain * (reference[at, i] - state[i, 0])
            state[i] = (flows[i] @ [*state[i], command])[:2]
        positions.append(state[:, 0].copy())
        places.append(at)


@pytest.mark.parametrize("rule", list(Rule))
def test_a_run_is_the_rules_term_by_term(rule):
    """Unlike axes on paths of corners, bounds from micrometres to most of a step, references of two rows and more."""
    rng = np.random.default_rng(3)
    held_at_all = 0
    for rows in (2, 3, 4, 5, *[12] * 5, 31):
        axes = [StatelineAxis(rng.uniform(20.0, 70.0), lag) for lag in rng.uniform(0.002, 0.012, 2)]
        master = np.cumsum(rng.normal(size=(6, 2)) * rng.choice([0.02, 0.3, 1.0]), axis=0)
        reference, bound = second_stage(master, 8, 3)[:rows], 10.0 ** rng.uniform(-2.5, -0.5)
        run = run_stateline(reference, axes, rule, bound)
        position, places, held = followed(reference, axes, rule, bound)
        assert run.place.tolist() == places
        assert run.position == pytest.approx(position.reshape(-1, 2), abs=1e-10)
        assert (run.held, run.forced) == (held, 0)
        held_at_all += held
    assert (held_at_all > 0) == (rule is not Rule.NONE)


def test_patience_ends_a_wait():
    """A step of 10 mm and then a tiny one, before which E e^(−10 t) comes down to 21 µm: 0.6 s, unless patience ends before."""
    reference = np.array([[0.0], [10.0], [10.0001]])
    axis = [StatelineAxis(10.0, 0.004)]
    patient = run_stateline(reference, axis, Rule.ERROR, 1e-3)
    hasty = run_stateline(reference, axis, Rule.ERROR, 1e-3, patience_s=0.05)
    assert patient.forced == 0
    assert np.bincount(patient.place)[1] * patient.period == pytest.approx(0.62, abs=0.03)
    assert hasty.forced == 1
    # Held for a hundred control periods of 0.5 ms, and forced in the next.
    assert np.bincount(hasty.place)[1] == 101
    assert hasty.held == 101


def test_error_gains_are_those_of_ramp_and_parabola():
    """Kv/(s(τs + 1)): E(s)/R(s) = s(τs + 1)/(τs² + s + Kv), expanded at s = 0."""
    axis = StatelineAxis(60.0, 0.004)
    s = 1e-2
    ratio = s * (axis.lag * s + 1) / (axis.lag * s**2 + s + axis.gain)
    kve, kac, kje = axis.error_gains
    assert ratio == pytest.approx(kve * s + kac * s**2 + kje * s**3, rel=1e-9)
    remainder = ratio - kve * s - kac * s**2
    assert remainder == pytest.approx(kje * s**3, rel=0.05)


def test_a_bound_of_zero_is_refused():
    with pytest.raises(ValueError, match="positive"):
        run_stateline(second_stage(corner(), 32, 2), AXES, Rule.ERROR, 0.0)
    with pytest.raises(ValueError, match="equations 2, 3 and 4"):
        second_stage(corner(), 32, 5)


def test_the_kernel_uncompiled_gives_the_same(monkeypatch):
    if servo_stateline.__file__.endswith(".py"):
        pytest.skip("the kernel is not compiled here")
    reference = second_stage(corner(length=4.0), 32, 3)
    compiled = run_stateline(reference, AXES, Rule.JERK, 0.05)
    monkeypatch.setattr(stateline, "servo_stateline", uncompiled("servo_stateline"))
    plain = run_stateline(reference, AXES, Rule.JERK, 0.05)
    assert compiled.position == pytest.approx(plain.position, abs=1e-12)
    assert np.array_equal(compiled.place, plain.place)
