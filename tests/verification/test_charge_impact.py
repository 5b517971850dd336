"""Binary impacts against closed forms of the linear spring and dashpot, and of hard spheres."""

import math

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.charge.laws.leapfrog import dashpot_share
from nutamill.charge.laws.oscillator import (
    contact_time,
    damping_ratio_from_restitution,
    largest_overlap,
    restitution_from_damping_ratio,
)

R, K, V = 0.0025, 5e5, 1.0
M = sphere_mass(R)


def bounce(zeta, cut, m_eff, pair, dt, phase=0.3, precision="double", k_law=None):
    """Speed after an impact at V = 1 m/s; contact begins a share `phase` of a substep after a sampling
    instant.
    """
    gap = (7.0 + phase) * dt * V
    if pair:
        x = [[-R - gap / 2, 0, 0], [R + gap / 2, 0, 0]]
        bench = Bench(
            x,
            k_law or law(K, zeta, cut=cut),
            dt,
            velocities=[[V / 2, 0, 0], [-V / 2, 0, 0]],
            precision=precision,
        )
    else:
        bench = Bench(
            [0, 0, R + gap],
            k_law or law(K, zeta, cut=cut),
            dt,
            [FLOOR],
            velocities=[0, 0, -V],
            precision=precision,
        )
    n = int(1.5 * contact_time(K, m_eff, zeta, False) / dt) + 12
    bench.step(n)
    return (bench.velocities[1, 0] - bench.velocities[0, 0] if pair else bench.velocities[0, 2]), bench


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("pair", [False, True])
@pytest.mark.parametrize("wanted", [0.9, 0.5, 0.3])
def test_ball_leaves_with_the_restitution_it_was_given(wanted, pair, cut):
    # With tension: ln e = -pi zeta/sqrt(1 - zeta^2). Without: Schwager and Poeschel 2007. The scheme is
    # of second order in
    # a = w0 dt: each end of the contact is wrong by at most (a^2/8)(1 + 4 zeta) of the impulse, and the
    # oscillation by a^2/24 pi.
    zeta = damping_ratio_from_restitution(wanted, cut)
    m_eff = M / 2 if pair else M
    dt = contact_time(K, m_eff, zeta, cut) / 100
    a2 = (math.sqrt(K / m_eff) * dt) ** 2
    tolerance = a2 * (0.25 * (1 + 4 * zeta) * (1 + wanted) + math.pi / 24)
    for phase in (0.1, 0.3, 0.6, 0.8):
        assert bounce(zeta, cut, m_eff, pair, dt, phase)[0] == pytest.approx(wanted, abs=tolerance)


def test_restitution_error_falls_with_the_square_of_the_substep():
    # Mean error of eight phases at h, h/2, h/4: order 2 means a factor of 4 each, first order would give 2.
    # The ends of a contact make it; with tension cut no phase meets its release twice.
    zeta = damping_ratio_from_restitution(0.5, True)
    mean = []
    for n in (20, 40, 80):
        dt = contact_time(K, M, zeta, True) / n
        mean.append(
            sum(abs(bounce(zeta, True, M, False, dt, (phase + 0.3) / 8)[0] - 0.5) for phase in range(8)) / 8
        )
    order = math.log2(mean[0] / mean[2]) / 2
    assert 1.8 < order < 2.6


@pytest.mark.parametrize("zeta", [0.02, 0.05, 0.1])
def test_steps_within_a_contact_lose_what_the_damped_oscillator_loses(zeta):
    # Roots z of the march against abs(exp(-zeta w dt)). With the share of the dashpot the rate of decay is
    # wrong by 5/3 zeta^3 (w dt)^2, and by odd powers beyond; without it by zeta (w dt)^2/2.
    for step in (0.1, 0.2, 0.3):
        c = dashpot_share.py_func(step * step) * 2.0 * zeta * step
        # z^2 (z - 2 + 1/z) + (w dt)^2 z^2 + c (z^2 - z + (z - 1)^2/2) = 0
        roots = np.roots([1.0, step * step - 2.0 + 1.5 * c, 1.0 - 2.0 * c, 0.5 * c])
        decay = -np.log(np.sort(np.abs(roots))[1:]) / step
        assert decay == pytest.approx(
            zeta, abs=zeta * step**2 * (2.0 * zeta**2 + zeta * step + 0.5 * step**2)
        )


def test_restitution_at_the_automatic_substep_in_single_precision():
    # a = w0 dt = 0.153: the second-order bound above, and a release met twice: half a substep of the
    # dashpot's impulse, zeta a e
    zeta = damping_ratio_from_restitution(0.5, False)
    dt = contact_time(K, M / 2, zeta, False) / 20
    a = math.sqrt(2 * K / M) * dt
    errors = [
        bounce(zeta, False, M / 2, True, dt, (phase + 0.3) / 8, "single")[0] - 0.5 for phase in range(8)
    ]
    second_order = a * a * (0.25 * (1 + 4 * zeta) * 1.5 + math.pi / 24)
    assert max(map(abs, errors)) < second_order + zeta * a * 0.5
    assert np.median(np.abs(errors)) < second_order


def test_largest_overlap_is_that_of_the_damped_oscillator():
    zeta = 0.2
    dt = contact_time(K, M, zeta, False) / 200
    _, bench = bounce(zeta, False, M, False, dt)
    # sampled twice in a step of the maximum: second order, (w0 dt)^2/8; the start adds (w0 dt)^2/8 (1 + 4
    # zeta)
    a2 = K / M * dt * dt
    assert bench.state.largest_overlap[1] * 2 * R == pytest.approx(largest_overlap(K, M, zeta, V), rel=a2)


def test_contact_lasts_as_long_as_the_closed_form_says():
    zeta = 0.2
    dt = contact_time(K, M, zeta, False) / 200
    bench = Bench([0, 0, R + 1e-9], law(K, zeta), dt, [FLOOR], velocities=[0, 0, -V])
    n = 0
    while bench.step(1).reading().contacts[1] or n < 3:
        n += 1
    assert n * dt == pytest.approx(contact_time(K, M, zeta, False), abs=2 * dt)


@pytest.mark.parametrize("cut", [False, True])
def test_stiffness_from_the_bodies_is_their_series(cut):
    # 1/k = 1/(E_a d_a) + 1/(E_b d_b); the wall takes the particle's diameter. Peak overlap V sqrt(M/k)
    # without damping.
    per_a, per_b, d = 2e8, 3e6, 2 * R
    k = 1 / (1 / (per_a * d) + 1 / (per_b * d))
    dt = contact_time(k, M, 0.0, False) / 200
    bench = Bench(
        [0, 0, R + 1e-9], law(0.0, 0.0, a=per_a, b=per_b, cut=cut), dt, [FLOOR], velocities=[0, 0, -V]
    )
    bench.step(150)
    assert bench.state.largest_overlap[1] * d == pytest.approx(V * math.sqrt(M / k), rel=(math.pi / 200) ** 2)


def test_gross_sliding_impact_is_that_of_hard_spheres():
    # Slip never stops if |slip| > 7/2 mu (1 + e) v_n: v_t' = v_t - mu (1 + e) v_n, w' = 5/2 mu (1 + e) v_n/R
    # (Walton 1993).
    # The torque's arm is R less half an overlap: 1 % of R here; the spring loads friction within mu kn/kt of
    # the overlap: both in 2 %.
    mu, e, v_n, v_t, k = 0.1, 0.8, 0.1, 1.0, K
    zeta = damping_ratio_from_restitution(e, True)
    dt = contact_time(k, M, zeta, True) / 200
    bench = Bench(
        [0, 0, R + 1e-9], law(k, zeta, friction=mu, cut=True), dt, [FLOOR], velocities=[v_t, 0, -v_n]
    )
    bench.step(260)
    change = mu * (1 + e) * v_n
    assert bench.velocities[0, 0] - v_t == pytest.approx(-change, rel=0.02)
    assert bench.spins[0, 1] == pytest.approx(2.5 * change / R, rel=0.02)


def test_sticking_impact_turns_the_slip_by_the_cosine():
    # Undamped springs without slip: slip' = slip cos(pi sqrt(7/2 kt/kn)) (Walton 1993). The arm differs from
    # R by half an
    # overlap, at most V sqrt(M/k)/2 = 0.3 % of R, so the frequency and the cosine's argument by less: 0.01 of
    # the slip.
    ratio, v_n, v_t = 2 / 7, 0.5, 0.01
    dt = contact_time(K, M, 0.0, False) / 200
    bench = Bench(
        [0, 0, R + 1e-9], law(K, 0.0, ratio, friction=100.0), dt, [FLOOR], velocities=[v_t, 0, -v_n]
    )
    bench.step(230)
    slip = bench.velocities[0, 0] - R * bench.spins[0, 1]
    assert slip == pytest.approx(v_t * math.cos(math.pi * math.sqrt(3.5 * ratio)), abs=0.01 * v_t)


def test_damping_ratio_and_restitution_are_inverse():
    for cut in (False, True):
        for e in (0.05, 0.3, 0.5, 0.99, 1.0):
            assert restitution_from_damping_ratio(
                damping_ratio_from_restitution(e, cut), cut
            ) == pytest.approx(e, rel=1e-9)


def test_cut_tension_matches_the_published_ratios():
    # e = 0.5 -> 0.2155 over the full half period, 0.255 with the force cut at zero (Schwager and Poeschel
    # 2007)
    assert damping_ratio_from_restitution(0.5, False) == pytest.approx(0.2155, abs=5e-5)
    assert damping_ratio_from_restitution(0.5, True) == pytest.approx(0.255, abs=5e-4)


def test_unequal_balls_of_two_materials_follow_a_two_body_integration():
    # Newton's equations of two spheres along their line, integrated here with a substep ten times smaller
    ra, rb, rho_a, rho_b, k, zeta = 0.002, 0.003, 2500.0, 7800.0, 3e5, 0.15
    ma, mb = sphere_mass(ra, rho_a), sphere_mass(rb, rho_b)
    m_eff = ma * mb / (ma + mb)
    dt = contact_time(k, m_eff, zeta, False) / 100
    laws = {(0, 0): law(1.0), (1, 1): law(2.0), (0, 1): law(k, zeta)}
    x = [[0, 0, 0], [ra + rb + 1e-7, 0, 0]]
    bench = Bench(
        x,
        laws,
        dt,
        radius=[ra, rb],
        materials=np.array([0, 1]),
        densities=[rho_a, rho_b],
        velocities=[[1, 0, 0], [0, 0, 0]],
    )
    bench.step(60)
    c, h = 2 * zeta * math.sqrt(m_eff * k), dt / 10
    d, u, va, vb = -1e-7, 1.0, 1.0, 0.0
    for _ in range(600):
        d += 0.5 * h * u
        force = k * d + c * u if d > 0 else 0.0
        va, vb = va - h * force / ma, vb + h * force / mb
        u = va - vb
        d += 0.5 * h * u
    # each is wrong by second order of w0 dt = 0.03, or first order of the tenth of it: 1e-3 of the speed
    assert bench.velocities[:, 0] == pytest.approx([va, vb], abs=2e-3)
