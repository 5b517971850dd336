"""A small filmed run for all tests of pictures: a ring of pellets that circles in a nutating chamber. No test
waits for the trial of a case, unless it is about trials.
"""

import pathlib
import sys

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.case.drawing import BODIES
from nutamill.result import Recorder, open_result
from nutamill.result.fields import expand
from nutamill.simulation import trial

sys.path.insert(0, str(pathlib.Path(__file__).parent))  # the tests share the modules beside them

from nutating_chamber import SPEED, matrix, tilted, turned

RATE = 1000.0


@pytest.fixture(autouse=True)
def no_trials(monkeypatch):
    """Checks of cases forecast by the table."""
    monkeypatch.setattr(trial, "TRIAL_TIME", 0.0)


def write_film(path, snapshots=20, pellets=300, seed=1, changes=(), shakes=True, seconds=0.5):
    """Write a result of half a second at 60 rad/s with the last moments filmed at 200 Hz; `changes` of the
    case are in its text only.
    """
    case = load_case("numill", ["mechanism.mounting=rigid", *changes])
    names = expand(sensors=("frame_corner",))
    time = np.arange(round(seconds * RATE) + 1) / RATE
    angle = SPEED * time
    known = {
        "time": time,
        "crank_angle": angle,
        "driveshaft_speed": np.full_like(time, SPEED),
        "crank_pin_force_resultant": 700.0 + 20.0 * np.cos(2 * angle),
        "driveshaft_torque": 9.0 + np.sin(2 * angle),
        "driveshaft_power": 540.0 + 60.0 * np.sin(2 * angle),
        "frame_corner_acceleration_x": 3.0 * shakes * np.cos(angle),
        "frame_corner_acceleration_z": 1.0 * shakes * np.cos(2 * angle),
        "charge_mass_centre_x": 0.05 * np.cos(angle - 0.7),
        "charge_mass_centre_y": 0.05 * np.sin(angle - 0.7),
        "charge_mass_centre_z": np.full_like(time, -0.28),
        "motor_work": 540.0 * time,
        "pair_normal_loss": 540.0 * time,
    }
    recorder = Recorder.create(path, case.to_toml(), {"seed": 1, "version": "0"}, names, RATE)
    recorder.append(np.stack([known.get(name, np.zeros_like(time)) for name in names], axis=1))
    draw = np.random.default_rng(seed)
    around, up = draw.uniform(-0.8, 0.8, pellets), draw.uniform(0.005, 0.15, pellets)
    inwards = draw.uniform(0.0, 0.02, pellets)
    for k in range(snapshots):
        at = 0.5 - 0.005 * (snapshots - 1 - k)
        crank = SPEED * at
        chamber = tilted(crank)
        azimuth = crank - 0.7 + around
        own = np.column_stack(
            [(0.066 - inwards) * np.cos(azimuth), (0.066 - inwards) * np.sin(azimuth), up - 0.350]
        )
        places = own @ matrix(chamber).T
        attitudes = {
            "chamber": chamber,
            "driveshaft": turned(crank),
            "carriage": turned(crank),
            "intermediate_shaft": turned(crank),
        }
        recorder.snapshot(
            at,
            {
                "positions": places.astype(np.float32),
                "velocities": (SPEED * np.column_stack([-places[:, 1], places[:, 0], 0 * up])).astype(
                    np.float32
                ),
                "radii": np.full(pellets, 0.0025, np.float32),
                "chamber_floor": matrix(chamber) @ [0.0, 0.0, -0.350],
                "chamber_attitude": chamber,
                "body_positions": np.zeros((len(BODIES), 3)),
                "body_attitudes": np.array([attitudes.get(name, [1.0, 0.0, 0.0, 0.0]) for name in BODIES]),
            },
        )
    recorder.state("complete")
    recorder.close()
    return path


@pytest.fixture(scope="session")
def film():
    """Writes such a run: ``film(path, snapshots, pellets)``."""
    return write_film


@pytest.fixture
def filmed(tmp_path):
    """Half a second, 20 snapshots of 300 pellets."""
    with open_result(write_film(tmp_path / "filmed.h5")) as result:
        yield result


@pytest.fixture
def unfilmed(tmp_path):
    """The same without snapshots."""
    with open_result(write_film(tmp_path / "unfilmed.h5", snapshots=0)) as result:
        yield result
