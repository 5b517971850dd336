"""Any machine with a charge: the mill as bodies and joints, a piston on a spring, and what is refused."""

import os
import signal
import time

import numpy as np
import pytest
from steel import STEEL

import nutamill as nm
from nutamill.analysis.values import default_readings, reading_of
from nutamill.base.errors import CaseError, StepError
from nutamill.case import Machine, load_case
from nutamill.case.charge_checks import Vessel
from nutamill.design.machine_sheet import machine_sheet
from nutamill.design.modes import machine_modes
from nutamill.simulation import march, runs
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.particles import particle_count
from nutamill.simulation.setup.regions import free_volume, walls_within

PISTON = (
    """
schema = 1
title  = "piston"

[[bodies]]
name     = "piston"
mass     = "0.2 kg"
inertia  = ["1e-4 kg m^2", "1e-4 kg m^2", "1e-4 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]

[[joints]]
name    = "guide"
kind    = "prismatic"
between = ["ground", "piston"]
point   = ["0 mm", "0 mm", "0 mm"]
axis    = [0, 0, 1]

[[springs]]
name        = "coil"
between     = ["ground", "piston"]
point_a     = ["0 mm", "0 mm", "-100 mm"]
point_b     = ["0 mm", "0 mm", "0 mm"]
stiffness   = "2 N/mm"
damping     = "2 N s/m"
free_length = "100 mm"

[[walls]]
name     = "crown"
body     = "piston"
shape    = "plane"
material = "steel"

[[walls]]
name     = "liner"
shape    = "cylinder"
radius   = "30 mm"
material = "steel"

[[regions]]
name   = "inside"
radius = "30 mm"
height = "300 mm"
point  = ["0 mm", "0 mm", "5 mm"]

[charge]
kind     = "spheres"
diameter = "6 mm"
count    = 20
material = "steel"
"""
    + STEEL
    + """
[run]
until      = "30 ms"
checkpoint = "10 ms"
threads    = 1
"""
)
"""A piston on a spring under twenty balls in a cylinder that stands on the ground."""

SHELF = """[[walls]]
name     = "shelf"
shape    = "box"
material = "steel"
point    = ["0 mm", "0 mm", "100 mm"]
size     = ["20 mm", "10 mm", "50 mm"]

[[regions]]"""

QUANTITIES = """[[sensors]]
name = "crown"
kind = "position"
of   = "piston"
at   = ["0 mm", "0 mm", "2 mm"]

[[quantities]]
name = "push"
of   = ["-piston_charge_force_z"]

[[quantities]]
name = "side"
of   = ["piston_charge_force_x", "piston_charge_force_y"]
take = "resultant"

[[quantities]]
name   = "lift"
of     = ["crown_position_z"]
zeroed = true

[materials.steel]"""

REFUSED = [
    ('body     = "piston"', 'body = "pistn"', r'walls.crown.body: no body is called "pistn". Did you mean'),
    ('radius   = "30 mm"', "", r'walls.liner.radius: is missing, with shape = "cylinder"'),
    ('"plane"', '"plane"\nradius = "1 mm"', r"walls.crown.radius: has no meaning with shape"),
    ('"plane"', '"plane"\nside = "inside"', r'a plane has the charge outside, got side = "inside"'),
    ('"plane"', '"plane"\naxis = [0, 0, 0]', r"walls.crown.axis: must have a length, got zero"),
    (
        '"plane"',
        '"box"\nsize = ["1 mm", "1 mm", "1 mm"]\nacross = [0, 0, 1]',
        r"must not be parallel to axis",
    ),
    ("count    = 20", 'count = 20\nregion = "outside"', r'charge.region: no region is called "outside"'),
    ('shape    = "plane"\nmaterial = "steel"', 'shape = "plane"\nmaterial = "stel"', r'called "stel"'),
    ('diameter = "6 mm"', 'diameter = "80 mm"', r"must be less than the region inside's 60 mm, got 80 mm"),
    ('name   = "inside"', 'name = "inside"\nshape = "mesh"\nwall = "crown"', r"no mesh around a charge is"),
    ("[run]", '[fields]\nbody = "crank"\n\n[run]', r'fields.body: no body is called "crank"'),
]
"""What is written instead of what, and the message."""


@pytest.fixture
def file(tmp_path):
    """The file of a piston on a spring under a few balls."""
    path = tmp_path / "piston.toml"
    path.write_text(PISTON)
    return path


@pytest.fixture
def dropped(monkeypatch):
    """Beds of balls that stand apart above the piston: a settled bed would take longer than the runs."""

    def bed(machine, *_):
        n = sum(part.count for part in machine.charge.parts)
        rows = np.arange(4) * 0.0065 - 0.00975
        heights = 0.004 + 0.0065 * np.arange(2)
        grid = np.stack(np.meshgrid(heights, rows, rows, indexing="ij"), axis=-1).reshape(-1, 3)[:, [1, 2, 0]]
        return grid[:n]

    monkeypatch.setattr(runs, "settled_bed", bed)


def series_of(case, path):
    with nm.run(case, to=path) as result:
        return {str(name): values.values for name, values in result.series.data_vars.items()}


# ---- the drawing of a mill is a machine


@pytest.mark.parametrize(
    "overrides", [["mechanism.mounting=rigid"], ["chamber.ribs=12", "drive.motor.power=370 W"]]
)
def test_the_mill_part_by_part_runs_to_the_same_bits_as_its_drawing(overrides, tmp_path):
    case = load_case("numill", ["charge.kind=none", "run.until=20 ms", *overrides])
    parts = Machine.from_toml(case.machine.to_toml())
    drawn, listed = series_of(case, tmp_path / "a.h5"), series_of(parts, tmp_path / "b.h5")
    assert list(drawn) == list(listed)
    assert all(np.array_equal(drawn[name], listed[name]) for name in drawn)


def test_the_mill_with_its_charge_runs_to_the_same_bits_as_its_drawing(tmp_path, monkeypatch):
    def layer(machine, *_):
        rows = np.arange(10) * 0.0055 - 0.02475
        return np.stack(np.meshgrid(rows, rows, [0.240 - 0.3475]), axis=-1).reshape(-1, 3)[
            : particle_count(machine)
        ]

    monkeypatch.setattr(runs, "settled_bed", layer)
    keys = ["charge.mass=0.03 kg", "run.until=10 ms", "drive.ramp=10000 rpm/s", "run.threads=1"]
    case = load_case("numill", keys)
    parts = Machine.from_toml(case.machine.to_toml())
    drawn, listed = series_of(case, tmp_path / "a.h5"), series_of(parts, tmp_path / "b.h5")
    assert np.abs(drawn["charge_force_z"]).max() > 0.1
    assert all(np.array_equal(drawn[name], listed[name]) for name in drawn)


@pytest.mark.parametrize("keys", [[], ["chamber.ribs=12"], ["charge.set=coarse-sand"]])
def test_every_number_of_the_parts_is_read_back_as_it_was(keys):
    machine = load_case("numill-2025", keys).machine
    assert Machine.from_toml(machine.to_toml()).model_dump() == machine.model_dump()


# ---- a charge on any machine


def test_a_piston_driven_by_grains_alone_keeps_momentum_and_energy(file, dropped, tmp_path):
    series = series_of(load_case(file), tmp_path / "a.h5")
    # 20 balls of 6 mm weigh 20 x 7800 pi/6 d^3 = 17.6 g and fall some centimetres
    weight = 20 * 7800 * np.pi / 6 * 0.006**3 * 9.81
    pushed = series["piston_charge_force_z"]
    assert pushed.min() < -2 * weight
    assert np.abs(series["interface_impulse_defect"]).max() < 1e-9
    assert {"ground_charge_force_x", "spring_coil_loss", "coordination_number"} <= set(series)


def test_the_ledger_of_a_piston_among_grains_closes_with_the_square_of_the_window(file, dropped, tmp_path):
    # windows of ten substeps of 4 us and of 2 us: a quarter at second order, and here the light piston rules
    case, residual = load_case(file), []
    for substep in (4e-6, 2e-6):
        series = series_of(case.with_("run.dt", substep), tmp_path / f"{substep}.h5")
        residual.append(np.abs(series["ledger_residual"]).max())
    assert residual[1] < residual[0] / 3


def test_a_resumed_machine_with_a_charge_is_the_one_that_never_stopped(file, dropped, tmp_path, monkeypatch):
    monkeypatch.setattr("nutamill.simulation.progress.PAUSE", 0.0)
    case, begun = load_case(file), []

    def stop(progress):
        if progress.phase != "settle" and not begun:
            begun.append(progress)
            os.kill(os.getpid(), signal.SIGINT)

    whole = series_of(case, tmp_path / "whole.h5")
    monkeypatch.setattr(march, "ROWS_PER_ENTRY", 4)
    with pytest.raises(KeyboardInterrupt):
        nm.run(case, to=tmp_path / "parts.h5", progress=stop)
    with nm.resume(tmp_path / "parts.h5") as result:
        assert all(np.array_equal(result.series[name].values, values) for name, values in whole.items())


def test_bodies_and_ground_carry_walls(file):
    assert [carrier.name for carrier in carriers_of(load_case(file))] == ["piston", "ground"]


def test_a_box_in_a_region_takes_its_share_of_the_room(file):
    file.write_text(PISTON.replace("[[regions]]", SHELF))
    case = load_case(file)
    (region,) = case.regions
    assert [surface.name for surface in walls_within(case, region)] == ["shelf"]
    # 200 000 points spread over the box around the region, 157 000 of them in it, 1850 in the shelf: three
    # standard deviations of a random count are 7 %
    taken = region.shape_volume - free_volume(case, region)
    assert taken == pytest.approx(0.02 * 0.01 * 0.05, rel=0.07)


# ---- quantities


def test_quantities_are_taken_of_series(file, dropped, tmp_path):
    file.write_text(PISTON.replace("[materials.steel]", QUANTITIES))
    series = series_of(load_case(file), tmp_path / "a.h5")
    assert np.array_equal(series["push"], -series["piston_charge_force_z"])
    sides = series["piston_charge_force_x"], series["piston_charge_force_y"]
    assert series["side"] == pytest.approx(np.hypot(*sides), rel=1e-15)
    assert series["lift"][0] == 0.0
    assert series["lift"] == pytest.approx(
        series["crown_position_z"] - series["crown_position_z"][0], abs=0.0
    )


def test_a_recorded_series_that_is_none_is_refused_with_the_nearest(file, dropped, tmp_path):
    case = load_case(file).with_("run.series", ["time", "piston_charge_forcez"])
    with pytest.raises(
        CaseError, match=r'run.series: no series is called "piston_charge_forcez". Did you mean'
    ):
        nm.run(case, to=tmp_path / "a.h5")


def test_a_campaign_of_a_machine_reads_its_quantities_or_the_forces_of_its_charge(file):
    plain = load_case(file)
    assert [reading.name for reading in default_readings(plain)][:2] == [
        "piston_charge_force_z_rms",
        "piston_charge_force_x_rms",
    ]
    file.write_text(PISTON.replace("[materials.steel]", QUANTITIES))
    assert [reading.name for reading in default_readings(load_case(file))] == ["push", "side", "lift"]
    machine = load_case(file)
    # its force is in newtons, a position in metres, as what they are taken of
    units = {name: reading_of(f"rms {name}", machine=machine).field.unit for name in ("push", "side", "lift")}
    assert units == {"push": "N", "side": "N", "lift": "m"}


# ---- light carriers


def test_check_warns_of_a_piston_lighter_than_fifty_balls_and_of_a_window_too_long_for_it(file):
    # a ball of 6 mm weighs 7800 pi/6 d^3 = 0.882 g: 20 g are 22.7 of them
    sheet = "\n".join(machine_sheet(load_case(file, ["bodies.piston.mass=20 g"])).lines())
    assert "warning: bodies.piston: weighs 22.7 particles where they touch it, less than 50" in sheet
    assert "bodies.piston" not in "\n".join(machine_sheet(load_case(file)).lines()[:3])
    # k = 1e-3 x 210 GPa x 6 mm/2 = 630 kN/m on 10 g: 7937 rad/s; seven windows to a row of 1 ms: 1.13 rad
    long = load_case(file, ["bodies.piston.mass=10 g", "run.window=40", "run.dt=4 us"])
    message = r'bodies.piston: moves on its contacts by 1.13 rad in a window of .* unstable.*"iterated"'
    with pytest.raises(CaseError, match=message):
        nm.run(long, to=file.with_suffix(".h5"))


# ---- what is refused


@pytest.mark.parametrize(("old", "new", "message"), REFUSED)
def test_a_machine_that_cannot_hold_its_charge_is_refused_in_words(file, old, new, message):
    assert old in PISTON
    file.write_text(PISTON.replace(old, new, 1))
    with pytest.raises(CaseError, match=message):
        load_case(file)


def test_a_charge_without_walls_or_a_region_is_refused_with_what_is_missing(file):
    begin, end = PISTON.index("[[walls]]"), PISTON.index("[charge]")
    file.write_text(PISTON[:begin] + PISTON[end:])
    with pytest.raises(CaseError) as refused:
        load_case(file)
    messages = [str(fault) for fault in refused.value.faults]
    assert any("walls: is missing: nothing holds the charge" in message for message in messages)
    assert any("regions: is missing: the charge has no place at the start" in message for message in messages)


def test_the_substep_of_a_machine_without_a_charge_is_refused_with_the_key_of_its_step(file):
    begin, end = PISTON.index("[charge]"), PISTON.index("[materials.steel]")
    file.write_text((PISTON[:begin] + PISTON[end:]).replace("threads    = 1", 'dt = "1 us"'))
    with pytest.raises(CaseError, match=r"run.dt: is the substep of a charge, and this machine has none"):
        load_case(file)


def test_a_vessel_says_whose_it_is():
    assert Vessel("ribbed chamber", 1.0, 1.0).owner == "chamber's"


# ---- messages


def test_a_body_that_nothing_holds_is_named_at_once(file):
    text = PISTON.partition("[[joints]]")[0] + PISTON[PISTON.index("[[walls]]") :]
    file.write_text(text)
    begun = time.perf_counter()
    sheet = "\n".join(machine_sheet(load_case(file)).lines())
    assert "modes     none: nothing holds piston" in sheet
    assert time.perf_counter() - begun < 10.0  # the search for an equilibrium took a minute
    with pytest.raises(
        StepError, match=r"static equilibrium: nothing holds piston. Connect it to the ground"
    ):
        machine_modes(load_case(file))


def test_a_wall_is_called_by_its_name_in_messages(file):
    assert load_case(file).key_of_wall("liner") == "walls.liner"
    assert load_case("numill", ["chamber.ribs=0"]).machine.key_of_wall("bore") == "walls.bore"


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('of = ["piston_charge_farce_z"]', r"quantities.odd.of: no series is called .*Did you mean"),
        ('of = ["odd"]', r'quantities.odd.of: must be recorded or stand above it, got "odd"'),
        ('of = ["time"]\ntake = "lag"', r'must be 5 series with take = "lag", got 1'),
    ],
)
def test_a_quantity_of_a_series_that_is_not_there_is_refused_before_a_run(file, entry, message):
    file.write_text(
        PISTON.replace("[materials.steel]", f'[[quantities]]\nname = "odd"\n{entry}\n[materials.steel]')
    )
    with pytest.raises(CaseError, match=message):
        machine_sheet(load_case(file))
