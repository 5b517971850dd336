"""A ball that falls on a sprung box, whose mass and spring are ours or an FMU's: case file and march."""

import numpy as np

from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.fmus.exchange import started
from nutamill.simulation.setup.model import build

BOX = """
schema = 1
title = "box on springs"

[[bodies]]
name     = "box"
mass     = "2 kg"
inertia  = ["0.01 kg m^2", "0.01 kg m^2", "0.02 kg m^2"]
position = ["0 mm", "0 mm", "-10 mm"]
"""
OWN = """
[[joints]]
name    = "guide"
kind    = "prismatic"
between = ["ground", "box"]
point   = ["0 mm", "0 mm", "-10 mm"]
axis    = [0, 0, 1]

[[springs]]
name        = "spring"
between     = ["ground", "box"]
point_a     = ["0 mm", "0 mm", "-100 mm"]
point_b     = ["0 mm", "0 mm", "-10 mm"]
stiffness   = "20000 N/m"
free_length = "100 mm"

[[forces]]
name  = "weight_taken_off"
body  = "box"
force = ["0 N", "0 N", "19.62 N"]
"""
FOREIGN = """
[[fmus]]
name  = "mass"
file  = "bench.fmu"
start = { stiffness = 20000.0, mass = 2.0, pz = -0.01 }

[[fmus.bodies]]
body         = "box"
position     = ["px", "py", "pz"]
velocity     = ["vx", "vy", "vz"]
acceleration = ["ax", "ay", "az"]
force        = ["fx", "fy", "fz"]
"""
BALL = """
[[walls]]
name     = "floor"
body     = "box"
material = "steel"
shape    = "box"
side     = "inside"
point    = ["0 mm", "0 mm", "20 mm"]
size     = ["40 mm", "40 mm", "60 mm"]

[[regions]]
name  = "inside"
body  = "box"
shape = "box"
point = ["0 mm", "0 mm", "20 mm"]
size  = ["40 mm", "40 mm", "60 mm"]

[charge]
kind     = "spheres"
diameter = "20 mm"
count    = 1
material = "steel"

[materials.steel]
density       = "7800 kg/m^3"
young_modulus = "210 GPa"
poisson_ratio = 0.3

[contact]
softening = 1e-4

[contact.pairs.steel-steel]
sliding_friction = 0.3
restitution      = 0.9

[[sensors]]
name = "box"
kind = "position"
of   = "box"

[run]
until       = "20 ms"
threads     = 1
dt          = "5 us"
series_rate = "1000 Hz"
"""


def rows_of(case, seconds, ball=(0.0, 0.0, 0.011)):
    """Rows of a march from the ball 1 mm above the floor, or elsewhere in the box: no bed has to settle."""
    bed = np.array([ball])
    with started(case) as exchange:
        model, state, scratch = build(case, bed, exchange)
        record_first_row(model, state, scratch)
        model, rows, fault = enter(model, state, scratch, round(seconds * case.run.series_rate))
        assert fault is None
        return dict(zip(model.readout.names, model.readout.series(rows, state.first_row).T, strict=True))
