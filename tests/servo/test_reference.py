"""The modified reference: Chen and Hsu's tables, closed forms, stable inversion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cncgen.servo.inversion import held_response, modified_reference, root_mean_square
from cncgen.servo.reference_profiles import (
    BELL_EXACT,
    ProfilePiece,
    ReferenceProfile,
    bell,
    exponential,
    linear,
)

T = 0.001
TIMES = np.arange(1001) * T
#: Tables 1 and 2, RMS in µm: linear, exponential, bell. Table 1 prints the inverse of its first system.
PRINTED = {
    ((1, 8), (1, 3)): (3.25, 2.34, 3.17),
    ((1, 1), (1, 2, 3)): (5.59, 4.45, 5.72),
    ((1, -8), (1, 3)): (2680, 4680, 2420),
    ((1, -2), (1, 5)): (46.7, 57.9, 46.6),
    ((1, -1), (1, 2, 3)): (5.59, 4.48, 5.71),
    ((1, -2), (1, 3, 8)): (5.60, 4.51, 5.66),
    ((1, -5), (1, 3, 8)): (5.69, 4.55, 5.74),
}


@pytest.mark.parametrize("system", list(PRINTED))
@pytest.mark.parametrize("column", [0, 1, 2])
def test_tables_1_and_2(system, column):
    profile = (linear, exponential, bell)[column]()
    command = modified_reference(*system, profile, TIMES)
    error = held_response(*system, command, T) - profile.value(TIMES)
    assert root_mean_square(error, T) * 1e3 == pytest.approx(PRINTED[system][column], rel=0.025)


@pytest.mark.parametrize(("system", "bound_um"), [(((1, -8), (1, 3)), 10.0), (((1, -2), (1, 5)), 20.0)])
@pytest.mark.parametrize("profile", [linear(), exponential(), bell(BELL_EXACT)])
def test_stable_inversion_is_bounded_and_follows(system, bound_um, profile):
    """Causal: 2700 and 47 µm with commands of metres; here what is left is the half-sample delay."""
    times = np.arange(-8000, 1001) * T
    command = modified_reference(*system, profile, times, stable=True)
    error = held_response(*system, command, T) - profile.value(times)
    assert root_mean_square(error, T) * 1e3 < bound_um
    assert np.abs(command).max() < 30.0
    assert abs(command[0]) < 1e-4


def test_the_causal_command_solves_its_differential_equation():
    """N u = D x for (s + 1)/(s² + 2 s + 3), integrated by solve_ivp over the linear profile."""
    profile = linear()

    def forcing(t):
        a = 45.0 if t <= 1 / 3 else (0.0 if t <= 2 / 3 else -45.0)
        v = 45.0 * t if t <= 1 / 3 else (15.0 if t <= 2 / 3 else 45.0 * (1 - t))
        return a + 2 * v + 3 * float(profile.value(np.array([t]))[0])

    u, at = 0.0, 0.0
    for end in (1 / 3, 2 / 3, 1.0):
        solved = solve_ivp(
            lambda t, u: forcing(t) - u, (at + 1e-12, end - 1e-12), [u], rtol=1e-10, atol=1e-12
        )
        u, at = solved.y[0, -1], end
    ours = modified_reference([1, 1], [1, 2, 3], profile, np.array([1.0]))
    assert ours[0] == pytest.approx(u, rel=1e-7)


def test_a_constant_numerator_is_a_sum_of_derivatives():
    """1/(s + 4): u = ẋ + 4 x."""
    profile = linear()
    t = np.array([0.1, 0.5, 0.9, 1.5])
    expected = np.array([4.5, 15.0, 4.5, 0.0]) + 4 * profile.value(t)
    assert modified_reference([1.0], [1.0, 4.0], profile, t) == pytest.approx(expected)


def test_profiles_are_what_the_paper_says():
    t = np.linspace(0, 1, 20001)
    for profile, peak in ((linear(), 45.0), (bell(BELL_EXACT), 60.0)):
        x = profile.value(t)
        speed = np.gradient(x, t)
        assert x[0] == 0.0
        assert x[-1] == pytest.approx(10.0)
        assert speed.max() == pytest.approx(15.0, rel=1e-3)
        assert np.abs(np.gradient(speed, t)[5:-5]).max() == pytest.approx(peak, rel=2e-3)
    printed = exponential(normalised=False)
    assert printed.value(np.array([1 / 3 + 1e-9])) - printed.value(np.array([1 / 3])) == pytest.approx(
        -0.0229, abs=1e-4
    )
    assert exponential().value(np.array([1.0])) == pytest.approx(10.0, abs=5e-3)


@pytest.mark.parametrize(
    ("system", "fault"),
    [
        (((1, 5, 4, 20), (1, 2, 3, 4, 5)), "imaginary"),
        (((1, 0, 4), (1, 2, 3, 4)), "imaginary"),
        (((1, 4, 4), (1, 2, 3, 4)), "double"),
        (((1, 2, 3), (1, 2)), "proper"),
    ],
)
def test_what_has_no_bounded_inverse_is_said(system, fault):
    with pytest.raises(ValueError, match=fault):
        modified_reference(*system, ReferenceProfile((ProfilePiece(0, 1, (0, 1)),), 1.0), TIMES)
