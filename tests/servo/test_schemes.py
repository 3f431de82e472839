"""ZPETC, cross coupling and task frame control: their equations, what they promise, and how they stand to each other."""

import numpy as np
import pytest
from scipy.signal import dlsim, dlti

from cncgen.diagnostics import UsageError
from cncgen.machine.record import Servo
from cncgen.servo import plants
from cncgen.servo.bank import Coupling, LoopBank
from cncgen.servo.controller import Controller
from cncgen.servo.controllers import ccc, feedforward, tcf, zpetc
from cncgen.servo.controllers.p import p
from cncgen.servo.frequency import margins, open_loop, ratio_in_z, response_to_setpoint
from cncgen.servo.loop import close_loop, follow_transfer_function
from cncgen.servo.mirror import Compensation
from cncgen.servo.named_schemes import NAMES, Settings, scheme_maker, settings_of
from cncgen.servo.scheme import Scheme
from cncgen.servo.simulate import own_scheme
from cncgen.servo.stream import blocks

from .bench import circle, profile, run_scheme, stream

T = 0.001
PAPER_004 = ("p", "zpetc", "ccc", "zpetc+ccc", "tcf")


def test_ratio_in_z_is_the_loops():
    for name in ("xy-table", "dyna-1007", "die-bonder"):
        loop = own_scheme(profile(name), "X", T).loops[0]
        above, below = ratio_in_z(loop)
        w = np.geomspace(1.0, 3000.0, 40)
        z = np.exp(1j * w * loop.period)
        assert np.polyval(above, z) / np.polyval(below, z) == pytest.approx(
            response_to_setpoint(loop, w), rel=1e-6
        )


@pytest.mark.parametrize("zeros", [[0.5], [-0.95], [1.4, 0.3], [-1.2, 0.4 + 0.3j, 0.4 - 0.3j]])
def test_zpetc_has_no_phase_and_unit_gain_at_rest(zeros):
    """From wanted to actual position the response is |B⁻(e^jω)|²/B⁻(1)²: real, positive, 1 at ω = 0."""
    poles = np.array([0.9, 0.7, 0.5, 0.3, 0.2])[: len(zeros) + 2]
    above, below = np.real(np.poly(zeros)), np.poly(poles)
    above = above * below.sum() / above.sum()
    filtered = zpetc.design(follow_transfer_function(above, below, T, discrete=True))
    w = np.linspace(1e-3, 3.0, 50)
    z = np.exp(1j * w)
    ages = filtered.ahead - np.arange(len(filtered.taps))
    shaping = filtered.taps @ z ** ages[:, None]
    ringing = 1.0 + (filtered.poles[:, None] * z ** -(1.0 + np.arange(len(filtered.poles)))[:, None]).sum(
        axis=0
    )
    total = shaping / ringing * np.polyval(above, z) / np.polyval(below, z)
    assert total.imag == pytest.approx(np.zeros(50), abs=1e-9)
    assert (total.real > 0).all()
    kept = np.poly([zero for zero in zeros if abs(zero) >= zpetc.CANCELLABLE])
    expected = np.abs(np.polyval(np.atleast_1d(kept), z)) ** 2 / np.atleast_1d(kept).sum() ** 2
    assert total.real == pytest.approx(expected, rel=1e-8)


def test_zpetc_streams_as_scipy_filters():
    """A loop with a cancelled zero, chunk by chunk, beside dlsim over the whole command."""
    above, below = np.array([0.3, -0.12]), np.array([1.0, -1.1, 0.28])
    loop = follow_transfer_function(above, below, T, discrete=True)
    rows = np.cumsum(np.random.default_rng(2).normal(size=(9000, 1)), axis=0)
    scheme = Scheme((loop,), zpetc.Zpetc([zpetc.design(loop)]))
    ours = run_scheme(rows, scheme, axes="X", chunk=777)
    # Minimum phase: the output is the command itself, but for the end, where what follows is unknown.
    assert ours.position[3:-3] == pytest.approx(rows[3:-3], abs=1e-8)
    _, check = dlsim(dlti(above, below, dt=1), rows[:, 0] - rows[0, 0])
    own = run_scheme(rows, Scheme((loop,)), axes="X", chunk=777)
    assert own.position[:, 0] - rows[0, 0] == pytest.approx(check[:, 0], abs=1e-9)


def test_cross_coupling_is_koren_and_los_formula():
    """One control period from rest with a known error, beside Cx and Cy as printed."""
    radius, angle, error = 25.0, 0.7, np.array([0.3, -0.2])
    loops = [close_loop(plants.integrator(), Controller(), T) for _ in range(2)]
    bank = LoopBank(loops, T)
    tangent = np.array([[np.cos(angle), np.sin(angle)]])
    curvature = np.array([[-np.sin(angle), np.cos(angle)]]) / radius
    coupling = Coupling(np.array([5.0, 0.2]), tangent, curvature, np.zeros((0, 2, 0)), np.zeros((0, 2, 0, 0)))
    _, force, _ = bank.run(np.zeros((2, 2)), np.array([error, error]), coupling)
    cx, cy = np.sin(angle) - error[0] / (2 * radius), np.cos(angle) + error[1] / (2 * radius)
    contour = -cx * error[0] + cy * error[1]
    weighted = (5.0 + 0.2) * contour
    assert force[0] == pytest.approx([-cx * weighted, cy * weighted], rel=1e-12)


@pytest.mark.parametrize("axes", [2, 3])
def test_cross_coupling_in_a_corner_rounder_than_the_error(axes):
    """The error 2 mm off a bend of 0.02 mm: the radius counts as 2 mm, so ε = |e| − |e|²/(2 · 2 mm) = 1 mm straight across."""
    loops = [close_loop(plants.integrator(), Controller(), T) for _ in range(axes)]
    tangent, across = np.eye(axes)[:1], np.eye(axes)[1:2]
    nothing = np.zeros((0, 2, 0)), np.zeros((0, 2, 0, 0))
    coupling = Coupling(np.array([5.0, 0.0]), tangent, -across / 0.02, *nothing)
    _, force, _ = LoopBank(loops, T).run(np.zeros((2, axes)), np.tile(2.0 * across, (2, 1)), coupling)
    # In the plane the gain of the axis is Cy = 1 − 2/(2 · 2) too.
    assert force[0] == pytest.approx(5.0 * across[0] * (0.5 if axes == 2 else 1.0), abs=1e-12)


def test_cross_coupling_stays_stable_in_a_sharp_corner():
    """Following 2 mm behind (v/Kv), round 0.02 mm: the gain that grew with |e|/ρ ran away to 1e9 mm."""
    lag, step = 2.0, 0.1
    along = np.concatenate([np.arange(0.0, 20.0, step), np.full(400, 20.0)])
    rows = np.column_stack(
        [along, np.concatenate([np.zeros(200), np.arange(0.0, 20.0, step), np.full(200, 20.0)])]
    )
    rows[199:201] += [[-0.02, 0.0], [-0.005, 0.005]]
    loops = tuple(close_loop(plants.velocity_loop(1.0, 0.01), p(step / T / lag), T) for _ in range(2))
    scheme = Scheme(loops, None, ccc.fitted(loops))
    response = run_scheme(rows, scheme)
    assert np.abs(rows - response.position).max() < 1.5 * lag
    assert response.position[-1] == pytest.approx([20.0, 20.0], abs=0.01)


def test_cross_coupling_in_space_acts_across_the_path_only():
    loops = [close_loop(plants.integrator(), Controller(), T) for _ in range(3)]
    tangent = np.array([[2.0, -1.0, 2.0]]) / 3.0
    error = np.array([0.3, 0.1, -0.4])
    coupling = Coupling(
        np.array([5.0, 0.0]), tangent, np.zeros((1, 3)), np.zeros((0, 2, 0)), np.zeros((0, 2, 0, 0))
    )
    _, force, _ = LoopBank(loops, T).run(np.zeros((2, 3)), np.array([error, error]), coupling)
    across = error - (error @ tangent[0]) * tangent[0]
    assert force[0] == pytest.approx(5.0 * across, rel=1e-12)


def test_task_frame_gains_are_the_papers_matrices():
    """Hsu 1999, eq. 14: K = A + v T⁻¹ R2m T + T⁻¹ Δ T − T⁻¹ A_Td T, and u = B⁺ (K e + w_d), as printed."""
    gain, lag = np.array([1.3, 0.8]), np.array([0.005, 0.007])
    stiffness, damping = np.array([9e4, 6e4]), np.array([600.0, 500.0])
    angle, w, dw = 0.8, 3.0, -40.0
    tangent = np.array([[np.cos(angle), np.sin(angle)]])
    turning = np.array([[[0.0, -1.0], [1.0, 0.0]]])
    made = tcf.TaskFrame(1.0 / lag, gain / lag, stiffness, damping)
    ours = made.feedback(tangent, w * turning, dw * turning)[0]
    frame = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turn, zero = np.array([[0.0, 1.0], [-1.0, 0.0]]), np.zeros((2, 2))
    a = np.block([[zero, np.eye(2)], [zero, -np.diag(1 / lag)]])
    b = np.vstack([zero, np.diag(gain / lag)])
    change = np.block([[frame.T, zero], [w * turn @ frame.T, frame.T]])
    wanted = np.block([[zero, np.eye(2)], [-np.diag(stiffness), -np.diag(damping)]])
    delta = np.block([[zero, zero], [dw * turn, zero]])
    back = np.linalg.inv(change)
    turning = np.kron(np.eye(2), w * turn)
    k = a + back @ turning @ change + back @ delta @ change - back @ wanted @ change
    drive = np.linalg.pinv(b) @ k
    assert np.hstack([ours[0], ours[1]]) == pytest.approx(drive, rel=1e-9, abs=1e-9)


def test_order_and_ratios_of_paper_004():
    """Circle of 10 mm at 5 m/min, Table 1: CCC at most 10 % and integrated control at most 4 % of P's contour error."""
    rows = circle(10.0, 5000 / 60, turns=3.0)
    servos = profile("dyna-1007")
    found = {}
    for name in PAPER_004:
        response = run_scheme(rows, scheme_maker(name, servos))
        part = slice(len(rows) // 2, -50)
        tracking = np.hypot(*(response.command - response.position)[part].T)
        found[name] = (
            (tracking.std() ** 2 + tracking.mean() ** 2) ** 0.5,
            (response.contour_error_mm[part] ** 2).mean() ** 0.5,
        )
    contour = {name: value[1] for name, value in found.items()}
    assert contour["zpetc+ccc"] < contour["tcf"] < contour["ccc"] < contour["zpetc"] < contour["p"]
    assert contour["ccc"] <= 0.10 * contour["p"]
    assert contour["zpetc+ccc"] <= 0.04 * contour["p"]
    assert found["tcf"][0] < found["zpetc"][0] < found["ccc"][0] < found["p"][0]


@pytest.mark.parametrize("name", NAMES[:-1])
def test_chunks_change_nothing(name):
    rows = circle(6.0, 70.0, turns=20.0)[:9000]
    maker = scheme_maker(name, profile("dyna-1007"))
    whole, parts = run_scheme(rows, maker, chunk=20_000), run_scheme(rows, maker, chunk=501)
    assert parts.position == pytest.approx(whole.position, abs=1e-11)


def test_cross_coupling_is_lowered_to_a_stable_contour_loop():
    loops = own_scheme(profile("dyna-1007"), "XY", T).loops
    eager = ccc.fitted(loops, 100.0, 1e4)
    assert ccc.contour_modulus(loops, eager.proportional, eager.integral) >= ccc.MODULUS
    assert eager.proportional < 100.0 * 88.85


def test_schemes_say_what_they_cannot_do():
    rows = circle(6.0, 50.0)[:50]
    with pytest.raises(UsageError, match="controller-unknown"):
        scheme_maker("pid", profile("dyna-1007"))
    with pytest.raises(UsageError, match="two or three linear axes"):
        run_scheme(rows[:, :1], scheme_maker("tcf", profile("dyna-1007")), axes="X")
    pure = {k: Servo("first-order", {"position_gain_1_s": 50.0}) for k in "XY"}
    with pytest.raises(UsageError, match="velocity state"):
        run_scheme(rows, scheme_maker("tcf", pure))
    ratio = {k: Servo("transfer-function", {"numerator": [1.0], "denominator": [0.01, 1.0]}) for k in "XY"}
    with pytest.raises(UsageError, match="controller-unfit"):
        run_scheme(rows, scheme_maker("tcf", ratio))


def test_a_model_error_shows_in_zpetc():
    servos = profile("dyna-1007")
    wrong = {
        k: Servo(s.model, {**s.parameters, "position_gain_1_s": 0.9 * s.parameters["position_gain_1_s"]})
        for k, s in servos.items()
    }
    exact = {k: Servo(s.model, {**s.parameters, "coulomb_lag_mm": 0.0}) for k, s in servos.items()}
    rows = circle(10.0, 80.0, turns=2.0)
    right, off = (run_scheme(rows, scheme_maker("zpetc", exact, Settings(models=m))) for m in (None, wrong))
    errors = [np.abs(r.command - r.position)[300:-50].max() for r in (right, off)]
    assert errors[0] < 1e-3
    assert errors[1] > 0.05


def test_margins_of_a_known_loop():
    """L = K/(s (s + 1)²): gain margin 2/K at 1 rad/s."""
    w = np.geomspace(1e-2, 1e2, 20000)
    found = margins(1.0 / (1j * w * (1j * w + 1) ** 2), w)
    assert found.gain == pytest.approx(2.0, rel=1e-4)
    # |L| = 1: ω (ω² + 1) = 1 at ω = 0.6823.
    assert found.crossover_rad_s == pytest.approx(0.682328, rel=1e-4)
    assert found.phase_deg == pytest.approx(180 - 90 - 2 * np.degrees(np.arctan(0.682328)), abs=0.01)


def test_open_loop_of_sampled_p_control():
    loop = close_loop(plants.integrator(), p(50.0), T)
    w = np.geomspace(1.0, 3000.0, 30)
    z = np.exp(1j * w * T)
    assert open_loop(loop, w) == pytest.approx(50.0 * T / (z - 1.0), rel=1e-9)


def test_blocks_hand_on_every_row_once_with_its_neighbours():
    rows = np.arange(20_000.0)[:, None]
    seen = []
    for block in blocks(stream(rows, "X", chunk=333), 3, 5):
        seen.append(block.rows)
        assert block.shifted(1)[:-1] == pytest.approx(block.rows[1:])
        expected = np.clip(block.first + np.arange(len(block)) - 3, 0, None)
        assert block.shifted(-3)[:, 0] == pytest.approx(expected)
    assert np.array_equal(np.concatenate(seen), rows)


def turned(rows):
    """A plane motion in a plane of space that no axis lies in, and the matrix that turned it."""
    axis, angle = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0), 0.9
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    matrix = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return np.column_stack([rows, np.zeros(len(rows))]) @ matrix.T, matrix


@pytest.mark.parametrize("name", ["ccc", "tcf"])
def test_schemes_in_space_are_those_of_the_plane_turned(name):
    """With equal axes nothing depends on how the coordinates lie: a circle in a slanted plane beside one in X Y."""
    servo = Servo("first-order", {"position_gain_1_s": 80.0, "time_constant_s": 0.005})
    rows = circle(10.0, 80.0, turns=1.0)
    slanted, matrix = turned(rows)
    plane = run_scheme(rows, scheme_maker(name, dict.fromkeys("XY", servo)))
    space = run_scheme(slanted, scheme_maker(name, dict.fromkeys("XYZ", servo)), axes="XYZ")
    back = space.position @ matrix
    # Cross coupling in the plane weighs each axis by its own variable gain, which is the vector's to first order in e κ.
    tolerance = 1e-9 if name == "tcf" else 2e-3
    assert back[:, :2] == pytest.approx(plane.position, abs=tolerance)
    assert np.abs(back[:, 2]).max() < 1e-9
    assert space.contour_error_mm.max() < 0.2 * run_scheme(slanted, scheme_maker("p", dict.fromkeys("XYZ", servo)),
                                                            axes="XYZ").contour_error_mm.max()  # fmt: skip


def test_task_frame_on_a_helix_holds_the_path():
    """A curve with torsion: continuous state feedback would hold it exactly, the sampled one to second order in T."""
    t = np.arange(0.0, 1.5, T)
    phase = 6.0 * np.where(t < 0.5, t**2, t - 0.25)
    rows = np.column_stack([10 * np.cos(phase), 10 * np.sin(phase), 4.0 * phase])
    servos = {
        k: Servo("first-order", {"position_gain_1_s": g, "time_constant_s": lag})
        for k, g, lag in (("X", 90.0, 0.004), ("Y", 70.0, 0.005), ("Z", 50.0, 0.007))
    }
    tcf_run, p_run = (run_scheme(rows, scheme_maker(n, servos), axes="XYZ") for n in ("tcf", "p"))
    assert tcf_run.contour_error_mm.max() < 0.01 * p_run.contour_error_mm.max()


def test_the_normal_error_decays_with_its_own_gains():
    """Along (1, 1, 0) at rest in the frame: errors along and across obey ë + 2ζω ė + ω² e = 0, each with its own ω, ζ."""
    plants_3 = [plants.velocity_loop(1.0, lag) for lag in (0.004, 0.006, 0.009)]
    frame = tcf.task_frame(plants_3, (40.0, 0.5), (90.0, 1.0))
    tangent = np.array([[1.0, 1.0, 0.0]]) / np.sqrt(2.0)
    none = np.zeros((1, 3, 3))
    gain = frame.feedback(tangent, none, none)[0]
    drag, strength = np.diag(frame.drag), np.diag(frame.strength)
    closed = np.block([[np.zeros((3, 3)), np.eye(3)], [-strength @ gain[0], -drag - strength @ gain[1]]])
    wanted = [*np.roots([1, 40, 1600]), *np.roots([1, 180, 8100]), *np.roots([1, 180, 8100])]
    found = np.linalg.eigvals(closed)
    assert np.sort(found.real) == pytest.approx(np.sort(np.real(wanted)), rel=1e-6)
    assert np.sort(found.imag) == pytest.approx(np.sort(np.imag(wanted)), abs=1e-4)


def test_zpetc_is_designed_at_the_setpoints_period():
    """The xy-table's loop runs at half the setpoints' period; the prefilter leaves less than a hundredth of its error."""
    rows = circle(10.0, 60.0)
    errors = {
        name: np.abs((r := run_scheme(rows, scheme_maker(name, profile("xy-table")))).command - r.position)[
            :-50
        ].max()
        for name in ("p", "zpetc")
    }
    assert errors["zpetc"] < 0.01 * errors["p"]


@pytest.mark.parametrize("name", ["ccc", "tcf"])
def test_coupled_controllers_see_what_the_encoder_says(name):
    """Noise and steps of the encoder reach the coupling: at rest it answers them."""
    quiet = {"position_gain_1_s": 80.0, "time_constant_s": 0.005, "control_period_s": T}
    noisy = Servo("first-order", {**quiet, "noise_rms_mm": 0.001, "encoder_resolution_mm": 0.001})
    rows = circle(10.0, 80.0, turns=0.5)
    forces = [
        run_scheme(rows, scheme_maker(name, dict.fromkeys("XY", s))).force
        for s in (Servo("first-order", quiet), noisy)
    ]
    own = 80.0 * 0.001
    assert (forces[1] - forces[0])[300:].std() > 2.0 * own


def test_settings_are_read_and_faults_are_named():
    found = settings_of({"ccc_proportional": 4, "ccc_integral_1_s": 0.0, "tcf_normal_rad_s": 100.0})
    assert (found.ccc_proportional, found.ccc_integral_1_s, found.tcf_normal_rad_s) == (4.0, 0.0, 100.0)
    with pytest.raises(UsageError) as caught:
        settings_of({"ccc_gain": 1.0, "tcf_normal_rad_s": -1.0, "ccc_proportional": 2.0})
    assert [d.code for d in caught.value.diagnostics] == ["machine-key", "machine-value", "machine-missing"]


def test_stiffness_of_known_loops():
    """P: Kv; PD+: Kp a mm, where it is well damped; whatever the control period."""
    slow = {
        k: Servo("first-order", {"position_gain_1_s": g, "time_constant_s": 0.005})
        for k, g in (("X", 30.0), ("Y", 20.0))
    }
    assert ccc.own_gain(own_scheme(slow, "XY", T).loops) == pytest.approx(25.0, rel=1e-4)
    servo = profile("die-bonder")["Y"]
    damped = Servo(servo.model, {**servo.parameters, "derivative_gain_volt_s_rad": 0.06})
    assert ccc.own_gain(own_scheme({"Y": damped}, "Y", T).loops) == pytest.approx(0.00577 * 1000, rel=1e-3)


def test_feedforward_leaves_no_error_at_constant_velocity():
    """eᵥ of P round 1/(s(τs + 1)) is 1/Kv whatever τ; along a ramp the shaped axis follows exactly."""
    servo = Servo("first-order", {"position_gain_1_s": 40.0, "time_constant_s": 0.004})
    assert feedforward.velocity_error(own_scheme({"X": servo}, "X", T).loops[0]) == pytest.approx(
        1 / 40.0, rel=1e-9
    )
    ramp = (30.0 * np.arange(1500) * T)[:, None]
    shaped, own = (run_scheme(ramp, scheme_maker(n, {"X": servo}), axes="X") for n in ("feedforward", "p"))
    assert (own.command - own.position)[1000] == pytest.approx(30.0 / 40.0, rel=1e-6)
    assert abs(shaped.command - shaped.position)[1000] < 1e-9
    several = profile("xy-table")["X"]
    run_off = run_scheme(ramp, scheme_maker("feedforward", {"X": several}), axes="X")
    assert np.abs(run_off.command - run_off.position)[1000:1400].max() < 1e-9


def test_plain_is_the_loop_without_its_feedforward():
    rows = circle(10.0, 60.0, turns=0.5)
    servo = profile("die-bonder")
    plain = {k: Servo(s.model, {**s.parameters, "feedforward": False}) for k, s in servo.items()}
    ours, own = (
        run_scheme(rows, maker) for maker in (scheme_maker("plain", servo), scheme_maker("p", plain))
    )
    assert np.array_equal(ours.position, own.position)


def test_the_mirror_filter_is_one_pass_of_compensation():
    rows = circle(10.0, 60.0, turns=1.0)
    ours = run_scheme(rows, scheme_maker("mirror", profile("dyna-1007")))
    work = Compensation(stream(rows), profile("dyna-1007"), passes=1, settle_s=0.0)
    command = np.concatenate([c.position for c in work.chunks()])
    check = run_scheme(command, own_scheme(profile("dyna-1007"), "XY", T))
    assert ours.position == pytest.approx(check.position, abs=1e-12)
