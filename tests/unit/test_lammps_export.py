"""The charge of a result as input of LAMMPS: the moving frame, the files, and what is refused."""

import numpy as np
import pytest
from flight_result import SPIN, seen_from_chamber, write_flight
from nutating_chamber import SPEED, TILT, tilted

from nutamill.analysis.source import any_case_of
from nutamill.base.errors import CaseError, ResultError
from nutamill.case import load_case
from nutamill.export.lammps.motion import TURN, ChamberMotion, stretches
from nutamill.export.lammps.write import export_charge, refuse_without_counterpart
from nutamill.simulation.setup.clock import run_clock

PLACE, VELOCITY = np.array([0.01, 0.02, -0.25]), np.array([0.5, -0.3, 0.4])


@pytest.fixture
def nutation():
    """A nutating body in 41 snapshots of 1 ms, its mass centre 0.2 m below the nutation point."""
    time = 1e-3 * np.arange(41)
    attitude = np.array([tilted(SPEED * t) for t in time])
    axis = np.column_stack([-np.sin(TILT) * np.cos(SPEED * time), -np.sin(TILT) * np.sin(SPEED * time)])
    centre = -0.2 * np.column_stack([axis, np.full(41, np.cos(TILT))])
    return ChamberMotion(time, centre, attitude)


def test_the_angular_velocity_of_a_nutation_is_that_of_its_closed_form(nutation):
    middle = np.array([0.0203])
    _, rotation = nutation.pose(middle)
    _, spin = nutation.twist(middle)
    angle = SPEED * middle[0]
    known = SPEED * np.array([np.sin(TILT) * np.cos(angle), np.sin(TILT) * np.sin(angle), 1.0 - np.cos(TILT)])
    # fourth order and higher: (0.06 rad)^5 of the spin, and a margin of ten for the spline's constant
    assert np.allclose(rotation[0] @ spin[0], known, atol=10 * 0.06**5 * SPEED)


def test_the_acceleration_of_a_nutating_mass_centre_is_centripetal(nutation):
    middle = np.array([0.0203])
    acceleration, _ = nutation.acceleration(middle)
    place, _ = nutation.pose(middle)
    known = -(SPEED**2) * place[0] * [1.0, 1.0, 0.0]
    assert np.allclose(acceleration[0], known, atol=10 * 0.06**4 * SPEED**2 * 0.2 * np.sin(TILT))


def test_stretches_are_short_against_a_turn_and_cover_the_motion(nutation):
    cut = stretches(nutation, np.array([0.0, 0.0, -9.81]), 2e-6)
    assert cut.steps.sum() == 20000
    assert cut.steps.max() * 2e-6 * SPEED <= TURN * (1.0 + 1e-6)
    ends = cut.at_start[:-1] + cut.slope[:-1] * cut.steps[:-1, None]
    assert np.allclose(ends, cut.at_start[1:], rtol=1e-9, atol=1e-9)


def test_snapshots_twice_as_far_apart_have_a_larger_estimate_of_the_error(nutation):
    time = nutation.time[::3]
    coarse = ChamberMotion(time, nutation.pose(time)[0], np.array([tilted(SPEED * t) for t in time]))
    assert coarse.error(0.2) > 50.0 * nutation.error(0.2)


def test_the_data_file_holds_the_pellet_as_the_chamber_sees_it(tmp_path):
    with write_flight(tmp_path / "a.h5", PLACE, VELOCITY) as result:
        machine = any_case_of(result).machine
        data, motion, script = export_charge(result, tmp_path / "out")
    atoms, velocities = (data.read_text().split(word)[1].split("\n")[2] for word in ("sphere", "Velocities"))
    number, kind, diameter, density, *place = atoms.split()
    assert (number, kind, float(density)) == ("1", "1", machine.materials["steel"].density)
    assert float(diameter) == pytest.approx(0.005, rel=1e-6)
    seen = np.array([*place, *velocities.split()[1:]], float)
    assert np.allclose(seen, seen_from_chamber(machine, 0.0, PLACE, VELOCITY, SPIN), rtol=1e-4, atol=1e-5)
    assert "include motion.in" in script.read_text()
    steps = sum(int(line.split()[1]) for line in motion.read_text().splitlines() if line.startswith("run "))
    assert steps == round(0.02 / run_clock(machine).substep)


def test_the_script_has_a_wall_for_each_surface(tmp_path):
    with write_flight(tmp_path / "a.h5", PLACE, VELOCITY, changes=["chamber.ribs=4"]) as result:
        *_, script = export_charge(result, tmp_path / "out")
    lines = script.read_text().splitlines()
    shapes = [line.split()[2] for line in lines if line.startswith("region ")]
    assert shapes == ["cylinder", "plane", "plane", "block", "block", "block", "block"]
    assert sum("wall/gran/region granular" in line for line in lines) == len(shapes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["charge.kind=none"], "charge: the chamber is empty"),
        (["contact.rolling=type_a"], "LAMMPS lacks type A rolling"),
        (["contact.normal=hysteretic"], "LAMMPS lacks hysteretic linear spring"),
        (
            ['charge.sizes=[["4 mm", 0.5], ["5 mm", 0.5]]', "contact.stiffness=young"],
            "a stiffness that grows with the diameter is not handed to LAMMPS for several sizes",
        ),
    ],
)
def test_what_the_script_cannot_hold_is_refused_by_name(changes, words):
    with pytest.raises(CaseError, match=words):
        refuse_without_counterpart(load_case("numill", changes).machine)


def test_a_wall_without_a_region_is_refused_by_its_shape():
    machine = load_case("tumbling-mill", ["walls.shell.shape=tube", "walls.shell.height=0.2 m"]).machine
    with pytest.raises(CaseError, match=r"walls\.shell: LAMMPS has no region like a tube"):
        refuse_without_counterpart(machine)


def test_walls_on_several_bodies_are_refused():
    with pytest.raises(
        CaseError, match="walls: walls on several bodies are not exported to LAMMPS, got jar_1"
    ):
        refuse_without_counterpart(load_case("planetary-mill").machine)


@pytest.mark.parametrize(
    ("snapshots", "interval", "words"),
    [(8, 1e-3, "its 8 snapshots are too few"), (14, 1.4e-2, "its snapshots are too far apart")],
)
def test_snapshots_that_do_not_resolve_the_motion_are_refused(tmp_path, snapshots, interval, words):
    flight = write_flight(tmp_path / "a.h5", PLACE, VELOCITY, snapshots=snapshots, interval=interval)
    with flight as result, pytest.raises(ResultError, match=words):
        export_charge(result, tmp_path / "out")
