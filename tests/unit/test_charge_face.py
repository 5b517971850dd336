"""The face of the charge engine: what it refuses, and the helpers that describe walls and contacts."""

import numpy as np
import pytest

import nutamill as nm
from nutamill.charge.laws.oscillator import damping_ratio_from_restitution

BALL = nm.spheres([0.01]).placed([[0.0, 0.0, 0.02]])
STEEL = nm.linear_pair(stiffness=1e5)


def test_wrong_settings_of_a_march_are_refused_together():
    with pytest.raises(nm.CaseError) as refusal:
        nm.Charge(BALL, [7850.0], STEEL, dt=0.0, threads=0, motion=np.zeros((1, 3)))
    first, second, third = str(refusal.value).splitlines()
    assert first == "dt: must be positive, got 0.0 s"
    assert second.startswith("threads: must be from 1 to ") and second.endswith(", got 0")
    assert third == "motion: must have shape (n_carriers, 19), got (1, 3)"


def test_a_motion_that_is_not_finite_is_refused():
    motion = np.zeros((1, 19))
    motion[0, 7] = np.nan
    with pytest.raises(nm.CaseError, match=r"^motion: must be finite$"):
        nm.Charge(BALL, [7850.0], STEEL, dt=1e-6, motion=motion)


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, -2, 0), (1, 0, 0), (1, 2, -3), (1, 1, 1)])
def test_a_plane_faces_along_its_normal(normal):
    wall = nm.plane("wall", (1.0, 2.0, 3.0), normal)
    assert wall.origin == (1.0, 2.0, 3.0)
    assert wall.rotation @ [0, 0, 1] == pytest.approx(np.array(normal) / np.linalg.norm(normal), abs=1e-15)
    assert wall.rotation.T @ wall.rotation == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(wall.rotation) == pytest.approx(1.0, abs=1e-15)


def test_a_linear_pair_has_the_damping_of_its_restitution_and_one_friction():
    pair = nm.linear_pair(stiffness=1e5, restitution=0.8, friction=0.3, overlap_stop=0.2)
    assert pair.damping_ratio == damping_ratio_from_restitution(0.8, False)
    assert pair.static_friction == pair.dynamic_friction == 0.3
    assert (pair.overlap_warn, pair.overlap_stop) == (0.1, 0.2)
