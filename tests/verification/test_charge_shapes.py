"""Mass properties of rigid clumps against closed forms for overlapping spheres."""

import itertools
import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from nutamill.base.errors import CaseError
from nutamill.charge.particles.shapes import clump_shape, sphere_shape
from nutamill.charge.particles.union import union_properties

# the quadrature converges to rounding; its own estimate is asked for beside each closed form
CLOSE = 1e-9


def revolved(pieces):
    """Volume, first moment, axial and transverse second moments of a solid turned about x, from
    ``(a, b, y^2(x))`` pieces.

    V = int pi y^2, M = int pi y^2 x, I_axial = int pi/2 y^4, I_transverse about x = 0 = int (pi/4 y^4 + pi
    y^2 x^2).
    """
    x = Polynomial([0.0, 1.0])

    def total(of):
        integral = 0.0
        for a, b, y2 in pieces:
            antiderivative = of(y2).integ()
            integral += antiderivative(b) - antiderivative(a)
        return math.pi * integral

    return (
        total(lambda y2: y2),
        total(lambda y2: y2 * x),
        total(lambda y2: 0.5 * y2**2),
        total(lambda y2: 0.25 * y2**2 + y2 * x**2),
    )


def ball(centre, radius):
    """y^2 of a sphere on the x axis."""
    return Polynomial([radius**2 - centre**2, 2.0 * centre, -1.0])


def radical(d, r, s):
    """Where on the line of centres, from the first, two spheres at distance d meet."""
    return (d * d + r * r - s * s) / (2.0 * d)


def test_two_spheres_have_the_volume_of_both_less_their_lens():
    d, r, s = 1.3, 1.0, 0.7
    # E. W. Weisstein, Sphere-Sphere Intersection: the lens of two spheres
    lens = math.pi * (r + s - d) ** 2 * (d * d + 2 * d * (r + s) - 3 * (r - s) ** 2) / (12 * d)
    for axis in np.vstack([np.eye(3), [[0.6, 0.48, 0.64]]]):
        solid = union_properties([[0, 0, 0], d * axis], [r, s])
        assert solid.error < CLOSE
        assert solid.volume == pytest.approx(4 / 3 * math.pi * (r**3 + s**3) - lens, rel=CLOSE)


@pytest.mark.parametrize(
    ("places", "radii"),
    [((0.0, 1.3), (1.0, 0.7)), ((-1.1, 0.0, 0.9), (0.8, 1.0, 0.6)), ((0.0, 1.7), (1.0, 0.7))],
)
def test_spheres_in_a_line_have_the_moments_of_a_turned_solid(places, radii):
    cuts = [places[0] - radii[0]]
    for (p, r), (q, s) in itertools.pairwise(zip(places, radii, strict=True)):
        cuts.append(p + radical(q - p, r, s))
    cuts.append(places[-1] + radii[-1])
    pieces = [
        (a, b, ball(p, r)) for (a, b), p, r in zip(itertools.pairwise(cuts), places, radii, strict=True)
    ]
    volume, first, axial, transverse = revolved(pieces)
    solid = union_properties([[x, 0.2, -0.5] for x in places], radii)
    assert solid.error < CLOSE
    assert solid.volume == pytest.approx(volume, rel=CLOSE)
    assert solid.mass_centre == pytest.approx([first / volume, 0.2, -0.5], abs=CLOSE)
    about_centre = transverse - first**2 / volume
    assert solid.inertia == pytest.approx(np.diag([axial, about_centre, about_centre]), abs=CLOSE * axial)


def lens_properties(p, r, q, s):
    """Volume, mass centre and inertia about it of what two spheres share, by turning two caps about the line
    of centres.
    """
    d = np.linalg.norm(q - p)
    axis, meet = (q - p) / d, radical(d, r, s)
    volume, first, axial, transverse = revolved([(d - s, meet, ball(d, s)), (meet, r, ball(0.0, r))])
    across = transverse - first**2 / volume
    return volume, p + first / volume * axis, across * np.eye(3) + (axial - across) * np.outer(axis, axis)


def test_three_spheres_in_a_ring_are_the_sum_of_spheres_less_the_lenses_of_pairs():
    # pairs overlap, no point is in all three: circumradius 1.1 above every radius
    angles = np.array([0.1, 2.1, 4.3])
    centres = 1.1 * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    radii = np.array([1.02, 1.0, 1.05])
    parts = [
        (1.0, 4 / 3 * math.pi * r**3, c, 8 / 15 * math.pi * r**5 * np.eye(3))
        for c, r in zip(centres, radii, strict=True)
    ]
    for i, j in itertools.combinations(range(3), 2):
        assert np.linalg.norm(centres[i] - centres[j]) < radii[i] + radii[j]
        parts.append((-1.0, *lens_properties(centres[i], radii[i], centres[j], radii[j])))
    volume = sum(sign * v for sign, v, _, _ in parts)
    middle = sum(sign * v * c for sign, v, c, _ in parts) / volume
    inertia = np.zeros((3, 3))
    for sign, v, c, own in parts:
        arm = c - middle
        inertia += sign * (own + v * (arm @ arm * np.eye(3) - np.outer(arm, arm)))
    solid = union_properties(centres, radii)
    assert solid.error < CLOSE
    assert solid.volume == pytest.approx(volume, rel=CLOSE)
    assert solid.mass_centre == pytest.approx(middle, abs=CLOSE)
    assert solid.inertia == pytest.approx(inertia, abs=CLOSE * np.trace(inertia))


def test_a_cluster_deep_in_itself_has_the_moments_of_points_thrown_at_it():
    rng = np.random.default_rng(4)
    centres, radii = rng.normal(size=(6, 3)) * 0.5, rng.uniform(0.6, 1.0, 6)
    solid = union_properties(centres, radii)
    assert solid.error < CLOSE
    low, high = (centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0)
    points = rng.uniform(low, high, (200_000, 3))
    inside = (np.linalg.norm(points[:, None] - centres, axis=2) < radii).any(axis=1)
    box, n = float(np.prod(high - low)), len(points)
    terms = np.column_stack([np.ones(n), points, points[:, 0] ** 2 + points[:, 1] ** 2]) * inside[:, None]
    axial = solid.inertia[2, 2] + solid.volume * (solid.mass_centre[:2] @ solid.mass_centre[:2])
    exact = np.array([solid.volume, *(solid.volume * solid.mass_centre), axial])
    # five standard errors of a mean of n independent throws
    assert (np.abs(box * terms.mean(axis=0) - exact) < 5 * box * terms.std(axis=0) / math.sqrt(n)).all()


def test_mass_properties_turn_and_move_with_the_spheres():
    rng = np.random.default_rng(5)
    centres, radii = rng.normal(size=(4, 3)) * 0.6, rng.uniform(0.6, 1.0, 4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    here, there = (
        union_properties(centres, radii),
        union_properties(centres @ turn.T + (3.0, -2.0, 1.0), radii),
    )
    assert there.volume == pytest.approx(here.volume, rel=CLOSE)
    assert there.mass_centre == pytest.approx(turn @ here.mass_centre + (3.0, -2.0, 1.0), abs=CLOSE)
    assert there.inertia == pytest.approx(turn @ here.inertia @ turn.T, abs=CLOSE * np.trace(here.inertia))


def test_a_shape_is_in_its_principal_axes_about_its_mass_centre():
    rng = np.random.default_rng(6)
    centres = 0.5e-3 * rng.normal(size=(3, 3))
    shape = clump_shape(centres, [1.4e-3, 1.1e-3, 1.2e-3])
    solid = union_properties(shape.offsets, shape.radii)
    size = shape.bounding_radius
    assert solid.mass_centre == pytest.approx(np.zeros(3), abs=CLOSE * size)
    assert solid.inertia == pytest.approx(np.diag(shape.inertia), abs=CLOSE * shape.inertia.sum())
    assert (np.diff(shape.inertia) > 0).all()
    gaps = [np.linalg.norm(x[:, None] - x, axis=2) for x in (centres, shape.offsets)]
    assert gaps[1] == pytest.approx(gaps[0], rel=1e-12)


def test_a_shape_of_four_spheres_is_not_mirrored():
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1.2, 0], [0, 0, 0.8]])
    shape = clump_shape(corner, [0.8, 0.7, 0.75, 0.7])
    edges = shape.offsets[1:] - shape.offsets[0]
    assert np.linalg.det(edges) == pytest.approx(0.96, rel=1e-12)  # +1 x 1.2 x 0.8, as given


def test_a_shape_made_larger_keeps_its_form():
    shape = clump_shape([[0, 0, 0], [1, 0, 0]], [0.8, 0.7])
    large = shape.scaled(3e-3)
    assert large.equivalent_diameter == pytest.approx(3e-3, rel=1e-14)
    again = union_properties(large.offsets, large.radii)
    assert (large.volume, *large.inertia) == pytest.approx((again.volume, *np.diag(again.inertia)), rel=1e-9)
    assert large.aspect_ratio == pytest.approx(shape.aspect_ratio, rel=1e-14)
    # length 0.8 + 1 + 0.7 over breadth 1.6
    assert shape.aspect_ratio == pytest.approx(2.5 / 1.6, rel=1e-14)


def test_a_sphere_is_the_clump_of_one():
    shape = clump_shape([[1.0, 2.0, 3.0]], [0.0025])
    mass = 4 / 3 * math.pi * 0.0025**3
    assert shape.volume == pytest.approx(mass, rel=1e-14)
    assert shape.inertia == pytest.approx(np.full(3, 0.4 * mass * 0.0025**2), rel=1e-14)
    assert (shape.offsets == 0.0).all() and shape.bounding_radius == 0.0025
    assert shape.push_mass() == pytest.approx([mass], rel=1e-14)
    assert sphere_shape().equivalent_diameter == pytest.approx(1.0, rel=1e-14)


def test_a_push_across_a_dumbbell_at_its_end_meets_least_mass():
    # equal spheres at +-a on a rod: 1/m_n = 1/m + a^2/I across the rod, the whole mass along it
    shape = clump_shape([[-1.0, 0, 0], [1.0, 0, 0]], [1.2, 1.2])
    assert shape.push_mass() == pytest.approx(
        np.full(2, 1 / (1 / shape.volume + 1 / shape.inertia[2])), rel=1e-9
    )


def test_no_direction_of_a_push_meets_less_mass_than_stated():
    rng = np.random.default_rng(7)
    shape = clump_shape(rng.normal(size=(3, 3)) * 0.6, [1.0, 0.8, 0.9])
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    arms = np.cross(shape.offsets[:, None], directions)
    masses = 1 / (1 / shape.volume + (arms**2 / shape.inertia).sum(axis=2))
    least = masses.min(axis=1)
    assert (least >= shape.push_mass() * (1 - 1e-12)).all()
    # the nearest of 4000 directions is some 0.04 rad off; the form is quadratic about its largest value
    assert least == pytest.approx(shape.push_mass(), rel=5e-3)


REFUSED = {
    "zero radius": ([[0, 0, 0], [1, 0, 0]], [1.0, 0.0], "sphere 1: the radius must be positive, got 0"),
    "not a number": ([[0, 0, math.nan]], [1.0], "sphere 0: the centre must be finite"),
    "apart": (
        [[0, 0, 0], [1, 0, 0], [9, 0, 0]],
        [0.6, 0.6, 0.6],
        "must hang together, no chain of overlaps leads from sphere 0 to 2",
    ),
    "inside another": (
        [[0, 0, 0], [0.2, 0, 0]],
        [1.0, 0.5],
        "sphere 1: must not be wholly inside another, it is in sphere 0",
    ),
    "twice the same": (
        [[0, 0, 0], [0, 0, 0]],
        [1.0, 1.0],
        "sphere 1: must not be wholly inside another, it is in sphere 0",
    ),
    "no spheres": (np.zeros((0, 3)), [], "must be (k, 3) centres and (k,) radii"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_spheres_that_are_no_rigid_particle_are_refused_by_number(name):
    centres, radii, message = REFUSED[name]
    with pytest.raises(CaseError) as error:
        clump_shape(centres, radii)
    assert message in str(error.value)


def test_spheres_that_touch_in_a_point_hang_together():
    shape = clump_shape([[0, 0, 0], [0.1, 0, 0]], [0.07, 0.03])
    assert shape.volume == pytest.approx(4 / 3 * math.pi * (0.07**3 + 0.03**3), rel=CLOSE)
