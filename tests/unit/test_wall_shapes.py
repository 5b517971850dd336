"""Walls of a file as surfaces of the charge: discs, tubes, rods and balls, their areas, and the regions that
they reach into.
"""

import math

import numpy as np
import pytest
from steel import STEEL

from nutamill.base.errors import CaseError
from nutamill.case import case_of_text
from nutamill.charge.walls.surface import SurfaceKind
from nutamill.simulation.setup.regions import walls_within
from nutamill.simulation.setup.statistics import patch_axes
from nutamill.simulation.setup.walls import world_surfaces

HEAD = (
    """
schema = 1
[[bodies]]
name     = "jar"
mass     = "1 kg"
inertia  = ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]
[charge]
kind     = "spheres"
diameter = "5 mm"
count    = 1
material = "steel"
"""
    + STEEL
    + """
[run]
until = "1 s"
[[regions]]
name   = "jar"
radius = "30 mm"
height = "50 mm"
point  = ["100 mm", "0 mm", "0 mm"]
"""
)
SHAPES = {
    "disc": ('radius = "20 mm"', SurfaceKind.DISC, (0.02, 0.0, 0.0), math.pi * 0.02**2),
    "tube": (
        'radius = "20 mm"\nheight = "50 mm"',
        SurfaceKind.TUBE,
        (0.02, 0.05, 0.0),
        math.tau * 0.02 * 0.05,
    ),
    "rod": (
        'radius = "20 mm"\nheight = "50 mm"',
        SurfaceKind.ROD,
        (0.02, 0.025, 0.0),
        math.tau * 0.02 * (0.05 + 0.02),
    ),
    "ball": ('radius = "20 mm"', SurfaceKind.BALL, (0.02, 0.0, 0.0), 4.0 * math.pi * 0.02**2),
}


def machine(shape: str, x: int):
    """A machine whose only wall is of a shape, its point at x [mm]."""
    keys = SHAPES[shape][0]
    wall = f'[[walls]]\nname = "wall"\nmaterial = "steel"\nshape = "{shape}"\n{keys}\n'
    return case_of_text(f'{HEAD}{wall}point = ["{x} mm", "0 mm", "0 mm"]\n')


@pytest.mark.parametrize("shape", SHAPES)
def test_a_wall_that_ends_is_the_surface_of_its_name(shape):
    _, kind, size, area = SHAPES[shape]
    case = machine(shape, 100)
    (surface,) = world_surfaces(case)
    assert (surface.kind, surface.size) == (kind, size)
    # a rod is given by its lower end, and the engine's is about its middle
    assert np.allclose(surface.origin, (0.1, 0.0, 0.025 if shape == "rod" else 0.0), rtol=0, atol=1e-15)
    assert patch_axes(case)["patch_area"].sum() == pytest.approx(area, rel=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_wall_that_ends_far_from_a_region_does_not_bound_it(shape):
    # spheres about the region and about the widest of the walls reach to 39 + 32 mm
    far, near = machine(shape, 25), machine(shape, 100)
    assert walls_within(far, far.regions[0]) == []
    assert len(walls_within(near, near.regions[0])) == (shape != "disc")


def test_a_key_that_a_shape_lacks_or_has_no_use_for_is_refused():
    text = HEAD + '[[walls]]\nname = "wall"\nmaterial = "steel"\nshape = "tube"\nradius = "20 mm"\n'
    with pytest.raises(CaseError, match=r'walls.wall.height: is missing, with shape = "tube"'):
        case_of_text(text)
    with pytest.raises(CaseError, match=r'walls.wall.height: has no meaning with shape = "ball"'):
        case_of_text(text.replace('"tube"', '"ball"\nheight = "20 mm"'))
