"""Results of a nutating chamber with pellets in free flight or at a wall, written without a run."""

import numpy as np
from nutating_chamber import SPEED, TILT, matrix, tilted

from nutamill.case import load_case
from nutamill.case.drawing import BODIES, CHAMBER
from nutamill.result import Recorder, open_result
from nutamill.result.fields import expand
from nutamill.simulation.setup.carriers import carriers_of

GRAVITY = np.array([0.0, 0.0, -9.81])
SPIN = np.array([30.0, -20.0, 50.0])
CHANGES = ["mechanism.mounting=rigid", "charge.mass=0.01 kg", "run.dt=2 us"]


def mass_centre(machine):
    """Mass centre of the chamber in its own axes, from the nutation point [m] (3,)."""
    carrier = carriers_of(machine)[0]
    return carrier.rotation.T @ carrier.position


def write_flight(path, place, velocity, speed=SPEED, snapshots=21, interval=1e-3, changes=()):
    """Write a result with one pellet that falls freely from `place` [m] with `velocity` [m/s], world, in a
    chamber that nutates at `speed` [rad/s]; return it opened.
    """
    case = load_case("numill", [*CHANGES, *changes])
    names = expand(sensors=("frame_corner",))
    recorder = Recorder.create(path, case.to_toml(), {"seed": 1, "version": "0"}, names, 1000.0)
    recorder.append(np.zeros((1, len(names))))
    centre = mass_centre(case.machine)
    for k in range(snapshots):
        t = k * interval
        attitude = tilted(speed * t)
        poses = np.tile([1.0, 0.0, 0.0, 0.0], (len(BODIES), 1))
        origins = np.zeros((len(BODIES), 3))
        n = BODIES.index(CHAMBER)
        poses[n], origins[n] = attitude, matrix(attitude) @ centre
        recorder.snapshot(
            t,
            {
                "positions": np.array([place + t * velocity + 0.5 * t * t * GRAVITY], np.float32),
                "velocities": np.array([velocity + t * GRAVITY], np.float32),
                "spins": np.array([SPIN], np.float32),
                "radii": np.full(1, 0.0025, np.float32),
                "materials": np.zeros(1, np.int16),
                "body_positions": origins,
                "body_attitudes": poses,
            },
        )
    recorder.state("complete")
    recorder.close()
    return open_result(path)


def seen_from_chamber(machine, t, place, velocity, spin, speed=SPEED):
    """Return position, velocity and spin (9,) of a particle as the nutating chamber sees them, from the mass
    centre of the chamber.
    """
    rotation = matrix(tilted(speed * t))
    turning = speed * np.array(
        [np.sin(TILT) * np.cos(speed * t), np.sin(TILT) * np.sin(speed * t), 1 - np.cos(TILT)]
    )
    arm = place - rotation @ mass_centre(machine)
    own = velocity - np.cross(turning, place)
    return np.concatenate([rotation.T @ arm, rotation.T @ own, rotation.T @ (spin - turning)])
