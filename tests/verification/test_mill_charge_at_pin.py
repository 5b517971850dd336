"""The charge's force at the pin, from its wrench on the chamber, against the load cell's reaction with and
without the charge.
"""

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.simulation import runs
from nutamill.simulation.setup.particles import particle_count
from nutamill.studies.papers.quantities import charge_at_pin, superposed

SETUP = [
    "mechanism.mounting=rigid",
    "mechanism.joint_friction=0.0",
    "mechanism.joint_friction_viscous=0 N m s/rad",
    "drive.ramp=60000 rpm/s",
    "run.until=40 ms",
    "run.window=1",
    "run.threads=1",
]
SIZE = 0.05
"""Charge [kg]: 98 pellets."""


def record(tmp_path, monkeypatch, name, *changes):
    """A run whose pellets start as one layer on the floor."""

    def bed(case, *_):
        rows = np.arange(10) * 0.0055 - 0.02475
        places = np.stack(np.meshgrid(rows, rows, [0.240 - 0.3475]), axis=-1).reshape(-1, 3)
        return places[: particle_count(case.machine)] if case.charge.parts else None

    monkeypatch.setattr(runs, "settled_bed", bed)
    return runs.run(load_case("numill", [*SETUP, *changes]), to=tmp_path / f"{name}.h5")


@pytest.fixture
def recorded(tmp_path, monkeypatch):
    charge = f"charge.mass={SIZE} kg"
    results = [
        record(tmp_path, monkeypatch, "coupled", charge),
        record(tmp_path, monkeypatch, "empty", "charge.kind=none", "run.dt=3.5 us"),
        record(tmp_path, monkeypatch, "alone", charge, "run.coupling=prescribed"),
    ]
    yield results
    for result in results:
        result.close()


def test_on_rigid_mounts_the_charge_adds_its_force_at_the_pin_to_that_of_the_empty_mill(recorded):
    # Rigid mounts and an imposed speed leave the chamber no freedom: its motion is the same with and without
    # the charge, and without
    # joint friction so are all forces but the charge's. A reaction is that of an instant and the charge's
    # wrench a mean over the substep
    # before, of contacts that come and go, so that means over the 182 rows agree, within three standard
    # errors of their difference.
    coupled, empty, _ = recorded
    charge = charge_at_pin(coupled)
    for part in ("radial", "tangential"):
        added = (
            coupled.series[f"crank_pin_force_{part}"].values - empty.series[f"crank_pin_force_{part}"].values
        )[10:]
        difference = added - getattr(charge, part)[10:]
        doubt = 3.0 * difference.std() / np.sqrt(len(difference))
        assert abs(difference.mean()) < doubt < 0.2 * abs(added.mean())


def test_on_rigid_mounts_superposition_of_empty_mill_and_charge_is_the_coupled_run(recorded):
    # as above; and the coupled run's force was zeroed at rest with the charge in it, the other without: m g d
    # sin(6.08 deg)/L01 apart
    coupled, _, alone = recorded
    together = superposed(alone)
    apart = {"radial": SIZE * 9.81 * 0.347 * np.sin(np.arctan2(39, 366)) / 0.366, "tangential": 0.0}
    for part, zero in apart.items():
        difference = (
            coupled.series[f"crank_pin_force_{part}_tared"].values[10:] - getattr(together, part)[10:]
        )
        assert abs(difference.mean() - zero) < 3.0 * difference.std() / np.sqrt(len(difference))
