"""FMUs of other programs that packages carry, in our runs: an oscillator of six freedoms under a ball, and a
motor of FMI 3.

Both are written in Python and run where that is the Python of the run:
``pip install --no-deps crane-fmu gemseo-fmu`` and ``pip install component-model pythonfmu``.
"""

import numpy as np
import pytest
from box_and_ball import BALL, BOX, rows_of
from motor_on_shaft import SHAFT
from packaged_fmu import packaged

from nutamill.case import load_case
from nutamill.simulation.runs import run

pytest.importorskip("fmpy", reason="needs the extra fmu")
pytestmark = pytest.mark.external


OSCILLATOR = BOX.replace('"2 kg"', '"1 kg"').replace('"0.01 kg m^2"', '"1 kg m^2"').replace("0.02 kg", "1 kg")
OWN = """
[[bushings]]
name               = "mount"
between            = ["ground", "box"]
point              = ["0 mm", "0 mm", "-10 mm"]
axis               = [0, 0, 1]
shear_stiffness    = "20000 N/m"
axial_stiffness    = "20000 N/m"
bending_stiffness  = "10000 N m/rad"
torsion_stiffness  = "10000 N m/rad"
shear_damping      = "20 N s/m"
axial_damping      = "20 N s/m"
bending_damping    = "10 N m s/rad"
torsion_damping    = "10 N m s/rad"

[[forces]]
name  = "weight_taken_off"
body  = "box"
force = ["0 N", "0 N", "9.81 N"]
"""
FOREIGN = """
[[fmus]]
name  = "oscillator"
file  = "HarmonicOscillator6D.fmu"

[[fmus.bodies]]
body             = "box"
origin           = ["0 mm", "0 mm", "-10 mm"]
position         = ["x[0]", "x[1]", "x[2]"]
attitude         = ["x[3]", "x[4]", "x[5]"]
attitude_as      = "rotation_vector"
velocity         = ["v[0]", "v[1]", "v[2]"]
angular_velocity = ["v[3]", "v[4]", "v[5]"]
force            = ["f[0]", "f[1]", "f[2]"]
moment           = ["f[3]", "f[4]", "f[5]"]

[fmus.start]
"""
CONSTANTS = {"k": (20000.0, 10000.0), "c": (20.0, 10.0), "m": (1.0, 1.0)}
"""Of the oscillator, along and about its axes. Its masses are one: it does not divide loads by them."""


BESIDE = (0.004, 0.0, 0.0102)
"""Where the ball begins [m]: 4 mm beside the middle, 0.2 mm above the floor; axes of the box."""


def test_a_six_dimensional_oscillator_of_another_program_carries_a_ball_as_our_own_mount_does(tmp_path):
    """The ball falls beside the middle of the box, which moves and tilts. Windows of 80 and 40 us against our
    own of 5 us: the exchange is of first order at least, though the FMU gives no accelerations.
    """
    packaged("crane-fmu", "HarmonicOscillator6D.fmu", tmp_path, "component-model", "pythonfmu")
    starts = [
        f'"{name}[{axis}]" = {along if axis < 3 else about}'
        for name, (along, about) in CONSTANTS.items()
        for axis in range(6)
    ]
    for name, text in (("own", OWN), ("foreign", FOREIGN + "\n".join(starts) + "\n")):
        (tmp_path / f"{name}.toml").write_text(OSCILLATOR + text + BALL, encoding="utf-8")

    def motion(name, window):
        rows = rows_of(load_case(tmp_path / f"{name}.toml").with_("run.window", window), 0.008, BESIDE)
        return np.column_stack([rows["box_position_z"], rows["charge_mass_centre_z"]])

    fine = motion("own", 1)
    errors = [np.abs(motion("foreign", window) - fine).max(axis=0) for window in (16, 8)]
    moved = np.abs(fine[:, 0] - fine[0, 0]).max()
    assert moved > 1e-6
    assert (errors[1] < 1e-3 * moved).all()
    assert (errors[0] > 2.0 * errors[1]).all()


def test_a_motor_of_another_program_of_fmi_3_drives_a_shaft(tmp_path):
    """FMU3Model adds its increment to its output at every step: its torque is known at every row."""
    packaged("gemseo-fmu", "FMU3Model.fmu", tmp_path)
    motor = """
[[fmus]]
name  = "motor"
file  = "FMU3Model.fmu"
start = { increment = 0.01 }

[[fmus.drives]]
drive  = "shaft"
torque = "output"
speed  = "input"
"""
    (tmp_path / "case.toml").write_text(SHAFT + motor, encoding="utf-8")
    with run(load_case(tmp_path / "case.toml"), to=tmp_path / "a.h5", trust_fmu=True) as result:
        assert result.provenance["fmus.motor"].endswith("FMI 3, made by PythonFMU3 0.2.2")
        time, torque = (result.series[name].values for name in ("time", "drive_shaft_torque"))
    steps = np.rint(time / 50e-6)  # the FMU begins with 3 N m
    assert torque[1:] == pytest.approx(3.0 + 0.01 * steps[1:], rel=1e-12)


HALVES = """
[[fmus]]
name  = "one"
file  = "MassSpringSubSystem1.fmu"
links = { x2 = "two.x2" }

[[fmus.bodies]]
body     = "box"
position = ["x1", "", ""]
velocity = ["v1", "", ""]

[[fmus]]
name  = "two"
file  = "MassSpringSubSystem2.fmu"
links = { x1 = "one.x1" }
"""
WHOLE = """
[[fmus]]
name = "system"
file = "MassSpringSystem.fmu"

[[fmus.bodies]]
body     = "box"
position = ["x1", "", ""]
velocity = ["v1", "", ""]
"""
WATCHED = """
[[sensors]]
name = "box"
kind = "position"
of   = "box"

[run]
until       = "1 s"
series_rate = "50 Hz"
"""


def test_two_halves_of_another_program_that_feed_each_other_move_as_the_whole(tmp_path):
    """Each half gets the place of the other a window late or early: with unit masses and springs the mass
    misses at most the window times the other's speed, here below 1 m/s, times a half of the square of 1 s.
    """
    for name in ("MassSpringSubSystem1", "MassSpringSubSystem2", "MassSpringSystem"):
        packaged("gemseo-fmu", f"{name}.fmu", tmp_path)
    box = BOX.replace('"-10 mm"', '"0 mm"')
    errors = []
    for step in (1e-3, 0.5e-3):
        places = []
        for name, fmus in (("halves", HALVES), ("whole", WHOLE)):
            (tmp_path / "case.toml").write_text(box + fmus + WATCHED, encoding="utf-8")
            case = load_case(tmp_path / "case.toml").with_("run.step", f"{step} s")
            with run(case, to=tmp_path / f"{name}-{step}.h5", trust_fmu=True) as result:
                places.append(result.series.box_position_x.values)
        errors.append(np.abs(places[0] - places[1]).max())
        assert errors[-1] < 0.5 * step
        assert np.abs(places[1]).max() > 1.0
    assert 1.8 < errors[0] / errors[1] < 2.2
