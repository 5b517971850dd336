"""The same NuMill in Exudyn, an independent multibody code: redundant coordinates, index 3, implicit
integration.
"""

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.drives import drive_motion
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.sensors import Sensor, SensorKind, column_names, march_recording, sensor_table
from nutamill.simulation.setup.mechanism import mechanism_parts

pytest.importorskip("exudyn", reason="the comparison with an independent engine needs: pip install exudyn")

from exudyn_mill import exudyn_mill  # after the check above: it imports exudyn

pytestmark = [
    pytest.mark.external,
    # of names that newer versions of Exudyn spell otherwise
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]

END, ROWS = 0.04, 16
"""Length of a run [s], and readings in it [1]."""
STEP = 12.5e-6
"""Step of both codes [s]; at twice that the torque of Exudyn is three times further off, ours stays."""
RPM = 2 * np.pi / 60
RISE = np.array([0.0, *(0.0007 + 0.001 * np.arange(40))])
"""Knots of the smooth run-up [s], none of them at a reading: acceleration jumps there."""
PROFILES = {
    "steady": [[0.0, 700 * RPM], [1.0, 700 * RPM]],
    "run-up": [[t, 700 * RPM * (3 * (t / 0.041) ** 2 - 2 * (t / 0.041) ** 3)] for t in map(float, RISE)],
}


def our_mill(mounting, profile):
    """The mill as described, its state at the start, its drive, and its readings by name (ROWS + 1, n)."""
    smooth = ["mechanism.joint_friction=0", "mechanism.joint_friction_viscous=0 N m s/rad"]
    case = load_case("numill", ["charge.kind=none", f"mechanism.mounting={mounting}", *smooth])
    machine = case.with_("drive.profile", PROFILES[profile]).machine
    mill = mechanism_parts(machine)
    mechanism, state, scratch = assemble(
        mill.bodies, mill.joints, mill.bushings, drives=mill.drives, gravity=machine.gravity
    )
    bodies = {body.name for body in mill.bodies}
    sensors = [
        Sensor(
            joint.name,
            SensorKind.JOINT_REACTION,
            joint.name,
            axes_body=joint.body_a if joint.body_a in bodies else None,
        )
        for joint in mill.joints
    ]
    sensors += [Sensor(f"body {name}", SensorKind.POINT_POSITION, name) for name in sorted(bodies)]
    table = sensor_table(mechanism, state, [*sensors, Sensor("motor", SensorKind.DRIVE, "motor")])
    names = column_names(table)
    static_equilibrium(mechanism, state, scratch)
    first = [
        array[:-1].copy()
        for array in (state.position, state.quaternion, state.velocity, state.angular_velocity)
    ]
    rows = np.zeros((ROWS + 1, 1 + len(names)))
    march_recording(mechanism, state, scratch, table, STEP, round(END / ROWS / STEP), rows)
    read = dict(zip(names, rows[:, 1:].T, strict=True))
    series = {
        joint.name: np.column_stack([read[f"{joint.name}_force_{axis}"] for axis in "xyz"])
        for joint in mill.joints
    }
    series |= {
        f"body {name}": np.column_stack([read[f"body {name}_{axis}"] for axis in "xyz"]) for name in bodies
    }
    return (
        mill,
        first,
        (lambda t: drive_motion(mechanism.drives[0], mechanism.knots, t)),
        series | {"torque": read["motor_torque"]},
    )


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("mounting", ["rigid", "flexible"])
def test_forces_torque_and_frame_motion_of_the_mill_are_those_of_exudyn(mounting, profile):
    mill, first, drive, ours = our_mill(mounting, profile)
    theirs = exudyn_mill(mill, first, drive, STEP, round(END / STEP), round(END / ROWS / STEP))
    assert np.allclose(theirs["time"], np.linspace(0.0, END, ROWS + 1), rtol=0, atol=1e-9)

    def error(name, sign=1.0):
        """Largest difference over the largest reading; the first is left out, Exudyn writes it before it has
        solved for forces.
        """
        return np.abs(sign * theirs[name][1:] - ours[name][1:]).max() / np.abs(ours[name][1:]).max()

    # both of second order: (w dt)^2 = 1e-6 of what swings at crank speed, more of what swings with mounts and
    # coupling
    for joint in mill.joints:
        assert error(joint.name, -1.0) < 1e-4, joint.name
    assert error("torque") < 1e-4
    for body in mill.bodies:
        moved = np.ptp(ours[f"body {body.name}"], axis=0).max()
        if moved > 1e-9:  # the shafts and, on rigid mounts, the frame stay where they are
            assert np.abs(theirs[f"body {body.name}"] - ours[f"body {body.name}"]).max() < 1e-4 * moved, (
                body.name
            )
