"""Statistics of the charge against motions whose spectra, wall work and fields are known."""

import math

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.charge.face import at_rest
from nutamill.charge.kernels.impacts import FINE, LOWEST, cutting_energy
from nutamill.charge.kernels.team import run_team
from nutamill.charge.measures.sampling import sample
from nutamill.charge.measures.statistics import (
    FIELD_SUMS,
    WALL_SUMS,
    charge_statistics,
    statistics_plan,
)
from nutamill.charge.measures.totals import gathered
from nutamill.charge.model import Ledger
from nutamill.charge.walls.patches import ANGLE_HEIGHT, ANGLE_RADIUS, FACE_HEIGHT, patch_table
from nutamill.charge.walls.surface import Surface, SurfaceKind

R, K = 0.0025, 1e5
M = sphere_mass(R)
BORE = Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.02, 0, 0))
RIB = Surface("rib", SurfaceKind.BOX, 0, 0, origin=(0.02, 0, 0.01), size=(0.004, 0.004, 0.01))


class Survey:
    """Statistics of a bench."""

    def __init__(self, bench, **plan):
        self.bench = bench
        self.plan = statistics_plan(bench.model, bench.state, bench.dt, **plan)
        self.sums = charge_statistics(self.plan, bench.state)

    def take(self, angle=0.0, threads=1):
        """One sample."""
        self.sums.samples[0] += 1
        run_team(sample, (*self.bench.parts, self.plan, self.bench.motion, angle, self.sums), threads)
        return self

    @property
    def totals(self):
        """Sums of all threads, by name."""
        return gathered(self.sums, self.bench.state.impacts)

    def wall(self, name):
        """Sum of one quantity over the samples, by patch, SI but for the interval."""
        k = WALL_SUMS.index(name)
        return self.totals["walls"][:, k] / self.plan.per_wall[k]

    def field(self, name):
        """The same by cell, (radius, azimuth, height)."""
        k = FIELD_SUMS.index(name)
        return (self.totals["fields"][:, k] / self.plan.per_field[k]).reshape(self.plan.cells)


def spectrum(bench, kind, part):
    """Counts and energies [J] of a spectrum of `bench`."""
    page = bench.state.impacts.spectra.sum(axis=0)[kind, part]
    edges = 2.0 ** (LOWEST + 0.5 * np.arange(len(page)))
    return page[:, 0], page[:, 1] / FINE * edges


def bin_of(energy):
    """Number of the half octave above 2^LOWEST J that holds an energy [J]."""
    return math.floor(2.0 * (math.log2(energy) - LOWEST))


@pytest.mark.parametrize("v", [1.0, 0.3, 0.001])
def test_bouncing_balls_are_counted_in_the_bin_of_their_energy(v):
    # free flight without gravity: the ball meets the floor with the speed it was given, along and across.
    # Energies are rounded to
    # 2^-16 of the lower edge of the bin
    n, along = 5, 0.4 * v
    x = np.column_stack([np.arange(n) * 3 * R, np.zeros(n), np.full(n, R + 1e-7)])
    bench = Bench(x, law(K, 0.1), 1e-6, [FLOOR], velocities=np.tile([along, 0, -v], (n, 1)))
    bench.step(round(2 * math.pi * math.sqrt(M / K) / 1e-6 + 1e-7 / v / 1e-6))
    assert np.all(bench.velocities[:, 2] > 0.0)
    for part, speed in ((0, v), (1, along)):
        energy = 0.5 * M * speed**2
        counts, energies = spectrum(bench, 1, part)
        assert counts[bin_of(energy)] == counts.sum() == n
        assert energies.sum() == pytest.approx(n * energy, rel=2.0**-16)
    assert not bench.state.impacts.spectra[:, 0].any()


def test_pairs_are_counted_once_wherever_they_lie_in_the_arrays():
    # more pairs than a chunk of 64 holds, some of them across two chunks; the relative motion of a pair
    # carries m v^2/4 of each part
    n, v, slip = 90, 0.5, 0.2
    first = np.array([[a, b, 0] for a in range(9) for b in range(10)]) * 8 * R
    x = np.concatenate([first, first + np.array([2 * R + 1e-7, 0, 0])])
    speeds = np.concatenate([np.tile([v / 2, slip, 0], (n, 1)), np.tile([-v / 2, 0, 0], (n, 1))])
    bench = Bench(x, law(K), 1e-6, velocities=speeds)
    bench.step(40)
    for part, speed in ((0, v), (1, slip)):
        counts, energies = spectrum(bench, 0, part)
        assert counts.sum() == n
        # the normal turns by slip over distance while the gap closes, 1e-5: the parts mix by that share of
        # the other speed
        assert energies.sum() == pytest.approx(n * 0.25 * M * speed**2, rel=2.0**-16 + 4e-5 * v / slip)


def test_a_contact_that_lasts_is_counted_once():
    bench = Bench([0, 0, R], law(K, 0.5), 2e-6, [FLOOR], gravity=(0, 0, -9.81))
    bench.step(5000)  # ten milliseconds: the ball has come to rest in its dent
    assert spectrum(bench, 1, 0)[0].sum() == 1


@pytest.mark.parametrize("degrees", [5.0, 15.0, 18.0, 19.0, 45.0, 80.0])
def test_cutting_energy_is_that_of_finnie(degrees):
    # Finnie 1960: sin 2a - 3 sin^2 a for shallow impacts, cos^2 a/3 for steep ones
    a = math.radians(degrees)
    f = math.sin(2 * a) - 3 * math.sin(a) ** 2 if math.tan(a) <= 1 / 3 else math.cos(a) ** 2 / 3
    assert cutting_energy(math.sin(a) ** 2, math.cos(a) ** 2) == pytest.approx(f, rel=1e-12)


def test_an_impact_wears_the_patch_it_hits():
    # onto the bore at azimuth 100 deg, height 13 mm, at 30 deg to the wall
    azimuth, a, v = math.radians(100.0), math.radians(30.0), 1.0
    out, tangent = (
        np.array([math.cos(azimuth), math.sin(azimuth), 0]),
        np.array([-math.sin(azimuth), math.cos(azimuth), 0]),
    )
    at = (0.02 - R - 1e-7) * out + [0, 0, 0.013]
    bench = Bench(
        at,
        law(K),
        1e-6,
        [BORE],
        velocities=v * (math.sin(a) * out + math.cos(a) * tangent),
        patches=patch_table([(ANGLE_HEIGHT, 36, 10, 0.0, 0.1)]),
    )
    survey = Survey(bench)
    bench.step(20)
    cut = survey.totals["cut"] / bench.model.per_cut
    assert np.flatnonzero(cut).tolist() == [10 * 10 + 1]
    # the wall curves by 1e-7/0.02 on the way: both parts are right to that, and to the small unit of 2^-30 of
    # the mass
    assert cut.sum() == pytest.approx(0.5 * M * v**2 * math.cos(a) ** 2 / 3, rel=1e-4)


@pytest.mark.parametrize(
    ("place", "face"),
    [((-1, 0, 0), 0), ((1, 0, 0), 1), ((0, -1, 0), 2), ((0, 1, 0), 3), ((0, 0, -1), 4), ((0, 0, 1), 5)],
)
def test_an_impact_on_a_rib_wears_its_face(place, face):
    direction = np.array(place, float)
    half = np.abs(direction) @ RIB.size
    at = np.array(RIB.origin) + direction * (half + R + 1e-7)
    bench = Bench(
        at,
        law(K),
        1e-6,
        [RIB],
        velocities=-direction + 0.5 * np.roll(direction, 1),
        patches=patch_table([(FACE_HEIGHT, 6, 4, -0.01, 0.01)]),
    )
    survey = Survey(bench)
    bench.step(10)
    (patch,) = np.flatnonzero(survey.totals["cut"])
    assert patch // 4 == face


def test_shear_work_of_a_sliding_ball_is_friction_times_distance_patch_by_patch():
    # A ball slides on a floor in its dent m g/k: friction mu m g brakes it and spins it up, so that the slip
    # is v - 7/2 mu g t
    # (Coulomb). Sampled every 20 us the work in a ring of the floor is right to one sample at its entry and
    # one at its exit,
    # and the friction, whose arm is half a dent (2e-7 m) short of R, to 1e-4.
    mu, g, v0, every, k = 0.3, 9.81, 1.0, 10, 1e5
    dt = 2e-6
    bench = Bench(
        [0.011, 1e-9, R - M * g / k],
        law(k, friction=mu),
        dt,
        [FLOOR],
        velocities=[v0, 0, 0],
        gravity=(0, 0, -g),
        patches=patch_table([(ANGLE_RADIUS, 8, 10, 0.0, 0.05)]),
    )
    survey = Survey(bench)
    samples = 1500
    for _ in range(samples):
        survey.take()
        bench.step(every)
    work = survey.wall("shear_work") * every * dt
    t = (np.arange(200_000) + 0.5) / 200_000 * samples * every * dt
    rate = mu * M * g * (v0 - 3.5 * mu * g * t)
    ring = ((0.011 + v0 * t - 0.5 * mu * g * t**2) / 0.005).astype(int)
    expected = np.bincount(ring, rate * (t[1] - t[0]), 10)
    tolerance = 2 * mu * M * g * v0 * every * dt + 1e-4 * expected.max()
    assert np.count_nonzero(expected) > 5
    assert work[:10] == pytest.approx(expected, abs=tolerance)
    assert not work[10:].any()
    # the load is the weight
    assert survey.wall("load").sum() / samples == pytest.approx(M * g, rel=1e-3)


CUTS = patch_table(
    [(ANGLE_RADIUS, 12, 4, 0.0, 0.02), (ANGLE_HEIGHT, 12, 8, 0.0, 0.08), (FACE_HEIGHT, 6, 4, -0.006, 0.01)]
)


def tumbling(n=150, precision="double", seed=3):
    """Balls thrown about between floor, bore and rib."""
    rng = np.random.default_rng(seed)
    grid = np.array([[a, b, c] for c in range(40) for a in range(6) for b in range(6)], float)
    grid = grid[np.hypot(grid[:, 0] - 2.5, grid[:, 1] - 2.5) < 2.6][:n]
    x = (grid - [2.5, 2.5, 0.0]) * 2.1 * R + [-0.002, 0, 1.2 * R]
    speeds = rng.normal(size=(n, 3)) - 20.0 * (x - x.mean(axis=0))
    pair = law(K, 0.2, 0.8, friction=0.5, rolling=0.05)
    return Bench(
        x,
        pair,
        3e-6,
        [FLOOR, BORE, RIB],
        velocities=speeds,
        precision=precision,
        gravity=(0, 0, -50.0),
        patches=CUTS,
    )


def test_work_over_all_patches_is_the_ledgers_within_the_error_of_sampling():
    # 30 blocks of 50 samples, each several contacts long and thus on its own: the scatter of what sampling
    # misses in a block gives
    # the standard error of the whole; 4 of them leave one chance in a thousand (Student's t, 29 degrees of
    # freedom)
    bench = tumbling()
    survey, every, blocks = Survey(bench), 5, 30
    places = (Ledger.WALL_NORMAL, Ledger.WALL_TANGENTIAL, Ledger.WALL_ROLLING)
    names = ("normal_work", "shear_work", "rolling_work")
    sampled, true = [np.zeros(3)], [-bench.state.ledger[list(places)]]
    for _ in range(blocks):
        for _ in range(50):
            survey.take()
            bench.step(every)
        sampled.append(np.array([survey.wall(name).sum() for name in names]) * every * bench.dt)
        true.append(-bench.state.ledger[list(places)])
    missed = np.diff(sampled, axis=0) - np.diff(true, axis=0)
    error = missed.std(axis=0, ddof=1) * math.sqrt(blocks)
    assert np.all(np.abs(missed.sum(axis=0)) < 4 * error)
    assert np.all(error < 0.05 * (true[-1] - true[0]))


def test_statistics_have_the_same_bits_on_one_and_two_threads():
    sums = []
    for threads in (1, 2):
        bench = tumbling(precision="single")
        survey = Survey(bench, cells=(3, 8, 5), extent=(0.02, 0.0, 0.1))
        for k in range(40):
            bench.threads = threads
            bench.step(10)
            survey.take(0.1 * k, threads)
        sums.append(survey.totals)
    assert (
        sums[0]["spectra"].any()
        and sums[0]["cut"].any()
        and sums[0]["walls"].any()
        and sums[0]["fields"].any()
    )
    assert all(np.array_equal(sums[0][name], sums[1][name]) for name in sums[0])


def packed(spin=0.0, layers=6):
    """A square lattice of touching balls around the z axis, turning about it as one body."""
    grid = np.array(
        [[a + 0.5, b + 0.5, c + 0.5] for c in range(layers) for a in range(-4, 4) for b in range(-4, 4)]
    )
    x = grid * 2 * R
    w = np.array([0.0, 0.0, spin])
    return x, Bench(x, law(K), 1e-6, velocities=np.cross(w, x), spins=np.tile(w, (len(x), 1)))


def test_fields_of_a_turning_packing_are_omega_times_r_and_its_solids_fraction():
    # Each ball's volume runs through all points of its sphere in 1024 samples. By symmetry a sector of 90 deg
    # holds a quarter,
    # and a cell that ends in the middle of a layer half of it: pi/6 of the lattice's volume, exactly but for
    # rounding.
    spin, layers = 30.0, 6
    x, bench = packed(spin, layers)
    survey = Survey(bench, cells=(1, 4, 4), extent=(0.03, 0.0, layers * 2 * R))
    for _ in range(1024):
        survey.take()
    volume = survey.field("solid_volume")[0] / 1024
    cell = (16 * R * 16 * R / 4) * layers * 2 * R / 4
    assert volume == pytest.approx(np.full((4, 4), math.pi / 6 * cell), rel=1e-6)
    # velocities: the mean of omega r over the balls of a cell
    ring = Survey(bench, cells=(5, 4, 1), extent=(0.03, 0.0, 1.0)).take()
    r = np.hypot(x[:, 0], x[:, 1])
    row = np.minimum((r / 0.006).astype(int), 4)
    expected = np.bincount(row, spin * r, 5) / np.bincount(row, minlength=5)
    mass = ring.field("mass").sum(axis=(1, 2))
    assert ring.field("momentum_a").sum(axis=(1, 2)) / mass == pytest.approx(expected, rel=1e-6)
    assert ring.field("momentum_r").sum(axis=(1, 2)) / mass == pytest.approx(np.zeros(5), abs=1e-6)
    assert ring.field("square_speed").sum() == pytest.approx(M * spin**2 * (r**2).sum(), rel=1e-6)


def test_velocities_are_those_relative_to_the_body():
    spin = 30.0
    _, bench = packed(spin)
    bench.motion = at_rest()
    bench.motion[0, 10:13] = 0.0, 0.0, spin
    survey = Survey(bench, cells=(3, 4, 1), extent=(0.03, 0.0, 1.0)).take()
    # small units are 2^-30 of a ball at 1 m/s; a rounding each
    assert np.abs(survey.field("momentum_a")).max() < 128 * M * 2.0**-30
    assert survey.field("square_speed").max() < 128 * M * 2.0**-30


def test_the_grid_turns_by_the_angle_it_is_given():
    bench = Bench([0.01, 0.001, 0.01], law(K), 1e-6)
    for angle, sector in ((0.0, 0), (math.radians(50), 10), (math.radians(-95), 3)):
        survey = Survey(bench, cells=(1, 12, 1), extent=(0.02, 0.0, 0.02)).take(angle)
        assert np.flatnonzero(survey.field("particles")[0, :, 0]).tolist() == [sector]


def test_neighbours_of_a_packing_are_those_of_its_lattice():
    # 8 x 8 x 6 balls pressed together by 0.1 um: 6 neighbours less one for each free face
    x, _ = packed()
    bench = Bench(x * (1 - 1e-4), law(K), 1e-6)
    bench.step(1)  # lists are made in the first substep
    bench.state.v[...] = 0.0
    counts = Survey(bench).take().totals["neighbours"]
    grid = np.stack(np.meshgrid(range(8), range(8), range(6), indexing="ij"), axis=-1).reshape(-1, 3)
    touching = 6 - (grid == 0).sum(axis=1) - (grid == [7, 7, 5]).sum(axis=1)
    assert counts[:7].tolist() == np.bincount(touching, minlength=7).tolist()
