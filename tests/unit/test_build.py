"""From a case to numbers: what is refused, and what the parts of a mill weigh, measure and share."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.case.drawing import CHAMBER, CROSS, SHAFT
from nutamill.case.rigid_parts import RigidPart, compose, remove, rib_ring
from nutamill.charge.kernels.team import MOST_THREADS
from nutamill.charge.model import Status
from nutamill.charge.walls.surface import SurfaceKind
from nutamill.design.preflight import preflight
from nutamill.simulation.setup.bed import joined_fills, settled_bed
from nutamill.simulation.setup.clock import contact_facts, run_clock
from nutamill.simulation.setup.mechanism import machine_sensors
from nutamill.simulation.setup.model import bed_weight, build
from nutamill.simulation.setup.particles import particle_count
from nutamill.simulation.setup.regions import _share_free, free_volume, walls_within
from nutamill.simulation.setup.statistics import charge_survey, field_grid, statistics_axes
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.walls import wall_surfaces


def mill(*overrides):
    return load_case("numill", list(overrides))


def layer(case):
    """Pellets 5.5 mm apart on the chamber's floor, rows of ten, layer on layer, in chamber axes from the
    mass centre of the chamber, 240 mm below the nutation point.
    """
    rows = np.arange(10) * 0.0055 - 0.02475
    heights = 0.240 - 0.3475 + 0.0055 * np.arange(20)
    places = np.stack(np.meshgrid(heights, rows, rows, indexing="ij"), axis=-1).reshape(-1, 3)[:, [1, 2, 0]]
    return places[: particle_count(case.machine)]


SMALL = "charge.mass=0.05 kg"


# ---- refusals


def test_bed_with_pellets_in_each_other_is_refused_by_name():
    case = mill(SMALL)
    bed = layer(case)
    bed[7] = bed[3] + (0.0, 0.004, 0.0)  # 1 mm of overlap in 5 mm, limit 10 %
    with pytest.raises(CaseError, match=r"must not overlap beyond overlap_stop.*3-7 \(20 %\)"):
        build(case.machine, bed)


def test_bed_that_reaches_through_the_chamber_is_refused_by_surface_and_pellet():
    case = mill(SMALL)
    bed = layer(case)
    bed[5] = (0.0, 0.0, -0.354 + 0.240)
    bed[6] = (0.0, 0.071, -0.30 + 0.240)
    with pytest.raises(CaseError) as refused:
        build(case.machine, bed)
    wrong = {fault.where: fault.what for fault in refused.value.faults}
    assert set(wrong) == {'surface "floor"', 'surface "bore"'}
    assert wrong['surface "floor"'].endswith("behind it: 5") and wrong['surface "bore"'].endswith(
        "behind it: 6"
    )


def test_substep_too_long_for_the_contacts_is_refused_with_what_would_do():
    # steel on steel: k = 1e-3 x 200 GPa x 5 mm / 2 = 5e5 N/m, half a pellet's mass 2.57e-4 kg: contact pi
    # sqrt(m/k)/sqrt(1 - z^2)
    # with z = ln 2/hypot(pi, ln 2) lasts 73 us; 10 us are 7.3 substeps
    zeta = math.log(2) / math.hypot(math.pi, math.log(2))
    mass = 7863.7 * math.pi * 0.005**3 / 6
    contact = math.pi * math.sqrt(mass / 2 / 5e5) / math.sqrt(1 - zeta**2)
    with pytest.raises(CaseError) as refused:
        run_clock(mill(SMALL, "run.dt=10 us").machine)
    message = str(refused.value)
    assert message.startswith("run.dt = 10 us: a steel-steel contact lasts")
    assert (
        f"lasts {contact * 1e6:.3g} us, {contact / 10e-6:.2g} substeps; it needs 10, better 20 "
        f"({contact / 20 * 1e6:.2g} us)" in message
    )
    assert 'Use dt = "auto"' in message
    run_clock(mill(SMALL, f"run.dt={contact / 10.01 * 1e6} us").machine)


def test_radii_of_gyration_that_leave_the_frame_no_inertia_are_refused():
    with pytest.raises(
        CaseError,
        match=r"radii of gyration of the whole machine leave the frame moments of inertia of .* no body has",
    ):
        mill("frame.gyration_yaw=10 mm").machine  # noqa: B018


# ---- the clock


@pytest.mark.parametrize(
    "overrides", [["charge.kind=none"], [SMALL], [SMALL, "run.window=7"], [SMALL, "run.series_rate=44100 Hz"]]
)
def test_row_of_the_record_is_a_whole_number_of_windows(overrides):
    case = mill(*overrides)
    clock = run_clock(case.machine)
    assert clock.window * clock.windows_per_row == pytest.approx(1 / case.run.series_rate, rel=1e-15)


def test_automatic_substep_is_a_twentieth_of_the_shortest_contact_or_a_little_less():
    zeta = math.log(2) / math.hypot(math.pi, math.log(2))
    mass = 7863.7 * math.pi * 0.005**3 / 6
    longest = math.pi * math.sqrt(mass / 2 / 5e5) / math.sqrt(1 - zeta**2) / 20
    clock = run_clock(mill(SMALL).machine)
    assert clock.substeps == 10
    # a row of 1/4800 s is cut into whole windows: at most one window more than needed
    needed = 1 / 4800 / (10 * longest)
    assert longest * needed / (needed + 1) < clock.substep <= longest


def test_hysteretic_substep_resolves_the_unloading_spring():
    # unloading is 1/e times quicker than loading, pi sqrt(m*/K_u) for a half period
    mass = 7863.7 * math.pi * 0.005**3 / 6
    shortest = math.pi * math.sqrt(mass / 2 / (5e5 / 0.5**2))
    assert contact_facts(mill(SMALL, "contact.normal=hysteretic").machine)[0].resolve == pytest.approx(
        shortest, rel=1e-12
    )
    assert run_clock(mill(SMALL, "contact.normal=hysteretic").machine).substep <= shortest / 20


def test_hertz_contact_takes_the_modulus_and_poissons_ratio_of_the_softened_solids():
    # 2.868 (m*^2/(R* E*^2 v))^(1/5) for e = 1 at the speed of the crank circle, E* = E/(2 (1 - nu^2)) of two
    # equal solids
    facts = contact_facts(
        mill(SMALL, "contact.normal=hertz", "contact.pairs.steel-steel.restitution=1.0").machine
    )[0]
    mass, modulus, v = 7863.7 * math.pi * 0.005**3 / 12, 2e8 / (2 * (1 - 0.25**2)), 700 * math.pi / 30 * 0.039
    assert facts.time == pytest.approx(2.8683 * (mass**2 / (0.00125 * modulus**2 * v)) ** 0.2, rel=1e-4)


@pytest.mark.parametrize("normal", ["linear", "hysteretic", "hertz"])
def test_substep_too_long_for_the_stiffest_pair_is_refused_with_what_would_do(normal):
    with pytest.raises(CaseError, match=r"steel-steel contact lasts .* it needs 10.*would do"):
        run_clock(mill(SMALL, f"contact.normal={normal}", "run.dt=50 us").machine)


def test_softening_that_the_refusal_of_a_substep_asks_for_would_do():
    case = mill(SMALL, "contact.normal=hertz", "run.dt=50 us")
    with pytest.raises(CaseError) as refused:
        run_clock(case.machine)
    hint = str(refused.value).split("softening = ")[1]
    assert run_clock(case.with_("contact.softening", float(hint.split(" ")[0])).machine).substep <= 50e-6


def test_cohesion_stronger_than_the_spring_is_refused():
    pressure = [f"contact.pairs.{name}.cohesive_pressure=1 MPa" for name in ("steel-steel", "steel-acrylic")]
    with pytest.raises(
        CaseError,
        match=r"steel-acrylic: cohesion takes 31\.4 kN/m from a spring of 15\.7 kN/m: .* below 0\.501 MPa",
    ):
        run_clock(mill(SMALL, "contact.cohesion=area", *pressure).machine)


# ---- parts


def test_part_taken_out_of_a_composed_body_leaves_the_other():
    random = np.random.default_rng(2)
    one, two = (RigidPart(m, random.standard_normal(3), np.diag(random.uniform(1, 2, 3))) for m in (3.0, 0.7))
    left = remove(compose(one, two), two)
    assert left.mass == pytest.approx(one.mass, rel=1e-14)
    assert left.mass_centre == pytest.approx(one.mass_centre, abs=1e-14)
    assert left.inertia == pytest.approx(one.inertia, abs=1e-13)


def test_two_balls_on_a_rod_compose_to_the_reduced_mass_times_distance_squared():
    part = compose(
        RigidPart(2.0, np.zeros(3), np.zeros((3, 3))),
        RigidPart(3.0, np.array([0.5, 0.0, 0.0]), np.zeros((3, 3))),
    )
    assert part.mass_centre == pytest.approx((0.3, 0.0, 0.0), abs=1e-15)
    assert part.inertia == pytest.approx(np.diag([0.0, 0.3, 0.3]), abs=1e-15)  # 2 x 3/5 x 0.25


def test_ribs_weigh_and_turn_like_a_sum_of_boxes():
    case = mill("chamber.ribs=12")
    total = []
    for k in range(12):
        angle = 2 * math.pi * k / 12
        turn = np.array(
            [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]]
        )
        m, a, l = 7450 * 0.01 * 0.01 * 0.23, 0.01, 0.23
        box = m / 12 * np.diag([a**2 + l**2, a**2 + l**2, 2 * a**2])
        total.append(RigidPart(m, turn @ np.array([0.065, 0.0, -0.350 + 0.115]), turn @ box @ turn.T))
    whole, ring = compose(*total), rib_ring(case.chamber)
    assert ring.mass == pytest.approx(whole.mass, rel=1e-14)
    assert ring.mass_centre == pytest.approx(whole.mass_centre, abs=1e-15)
    assert ring.inertia == pytest.approx(whole.inertia, abs=1e-15)


def test_parts_on_the_mounts_weigh_the_published_total():
    parts = mill().machine.bodies
    assert sum(body.mass for body in parts if body.name != SHAFT) == pytest.approx(84.54, rel=1e-14)


def test_bars_add_to_the_total_and_leave_the_frame_alone():
    bare, barred = (mill(*more).machine.bodies for more in ([], ["chamber.bars.mass=1.347 kg"]))
    assert sum(b.mass for b in barred) - sum(b.mass for b in bare) == pytest.approx(1.347, rel=1e-13)
    assert barred[0].mass == bare[0].mass and barred[0].inertia == bare[0].inertia


# ---- charge in its chamber


def test_surfaces_of_the_chamber_are_where_the_file_says():
    # distances from the nutation point along the chamber axis; surfaces count from the mass centre, 240 mm
    # below it
    surfaces = {surface.name: surface for surface in wall_surfaces(mill().machine)}
    assert set(surfaces) == {"bore", "floor", "ceiling"}
    assert surfaces["floor"].origin == pytest.approx((0, 0, -0.350 + 0.240), abs=1e-15)
    assert surfaces["ceiling"].origin == pytest.approx((0, 0, -0.350 + 0.228 + 0.240), abs=1e-15)
    assert np.asarray(surfaces["ceiling"].rotation)[2, 2] == pytest.approx(-1, rel=1e-15)
    assert surfaces["bore"].kind == SurfaceKind.CYLINDER and surfaces["bore"].size[0] == 0.070


def test_mill_at_rest_carries_the_weight_of_its_charge():
    # static equilibrium holds the bed as a dead weight on the chamber: the mounts carry machine and charge
    case = mill(SMALL)
    model, state, _ = build(case.machine, layer(case))
    weight = bed_weight(case.machine, layer(case), state.mechanism)[1]
    pellets = 98 * 7863.7 * math.pi * 0.005**3 / 6
    assert weight[2] == pytest.approx(-pellets * 9.81, rel=1e-12)
    sag = state.mechanism.position[0, 2] - case.machine.bodies[0].position[2]
    # four mounts, and the coupling to the shaft on the ground, of axial stiffness 542 and 374 N/mm; tilts are
    # of second order
    assert sag == pytest.approx(-(84.54 + pellets) * 9.81 / (4 * 542e3 + 374e3), rel=1e-3)
    assert state.charge.status[0] == Status.OK and model.charge.n_particles == 98


def test_chamber_is_assembled_with_its_foot_towards_the_crank():
    bodies = {body.name: body for body in mill().machine.bodies}
    x, y, z = bodies[CHAMBER].position
    assert (x / -z, y) == pytest.approx((0.039 / 0.366, 0.0), abs=1e-15)
    assert tuple(bodies[CROSS].position) == (0.0, 0.0, 0.0)


def test_a_sensor_on_the_chamber_sits_where_the_chamber_axes_say():
    # the middle of the floor is 350 mm down the chamber's axis: R_WC (0, 0, -0.350), the axis tilted by
    # atan(39/366) towards +x
    case = mill("sensors={ floor = { body = 'chamber', at = ['0 mm', '0 mm', '-350 mm'] } }")
    tilt = math.atan2(0.039, 0.366)
    (sensor,) = [sensor for sensor, _ in machine_sensors(case.machine) if sensor.name == "floor_acceleration"]
    assert sensor.point == pytest.approx((0.350 * math.sin(tilt), 0.0, -0.350 * math.cos(tilt)), abs=1e-15)


def test_ribs_leave_the_fill_the_room_that_the_check_of_a_case_counts_with():
    case = mill("chamber.ribs=12")
    (region,) = case.machine.regions
    assert len(walls_within(case.machine, region)) == 12
    sampled = _share_free(case.machine, region, walls_within(case.machine, region)) * region.shape_volume
    assert free_volume(case.machine, region) == case.chamber.free_volume
    # 200 000 evenly spread points, of which the ribs hold 8 %: better than a random count, 0.1 %
    assert sampled == pytest.approx(case.chamber.free_volume, rel=1e-3)


def test_a_team_is_never_larger_than_its_work_space():
    assert team_size(mill("run.threads=64").machine) <= MOST_THREADS


# ---- where statistics are summed


def test_patches_cover_the_free_walls_and_cells_the_chamber():
    case = mill("chamber.ribs=12", SMALL)
    bore, height, rib = case.chamber.inner_diameter, case.chamber.height, case.chamber.rib
    axes = statistics_axes(case.machine, charge_survey(case.machine, *built_charge(case), 3e-6))
    area = {
        name: axes["patch_area"][axes["patch_surface"] == name].sum()
        for name in ("bore", "floor", "ceiling", "rib 7")
    }
    assert area["bore"] == pytest.approx(math.pi * bore * height)
    assert area["floor"] == area["ceiling"] == pytest.approx(math.pi * bore**2 / 4)
    long = min(rib.length, height)
    assert area["rib 7"] == pytest.approx(long * (rib.width + 2 * rib.depth) + rib.width * rib.depth)
    # cells: radius and height; the same in every sector
    assert axes["cell_volume"].sum() * len(axes["azimuth"]) == pytest.approx(math.pi * bore**2 / 4 * height)
    # a rib's lowest row begins at the floor, and the ceiling's azimuth is counted in chamber axes
    along = axes["patch_along"][axes["patch_surface"] == "rib 7"]
    assert along.min() == pytest.approx(long / field_grid(case.machine).cells[2] / 2)
    ceiling = axes["patch_azimuth"][axes["patch_surface"] == "ceiling"]
    assert ceiling[0] == pytest.approx(math.tau - math.pi / 36)


def built_charge(case):
    """Model and state of a small layer of pellets in the chamber of `case`."""
    model, state, _ = build(case.machine, layer(case))
    return model.charge, state.charge


@pytest.mark.parametrize("act", [preflight, settled_bed], ids=["check", "run"])
def test_a_bed_too_dense_to_be_placed_is_refused_alike_by_check_and_run(act):
    """Balls of 20 mm: 0.637 - 0.12 x 0.02 m x (4/0.14 + 2/0.228)/m = 0.547 of 3.51 L, against the 0.99 x 0.62
    of it asked for.
    """
    case = mill(
        "charge.fill=0.99", "charge.packing=0.62", "charge.diameter=20 mm", "mechanism.mounting=rigid"
    )
    with pytest.raises(
        CaseError,
        match=r"^charge: must be placed without overlaps, got 2157 cm\^3 of spheres where 1921 cm\^3 can be",
    ):
        act(case if act is preflight else case.machine)


def test_a_chamber_can_be_filled_to_the_brim_where_check_says_so():
    """Check accepts a whole chamber of bed, and one denser than 0.58, which run places; pellets of 5 mm up to
    0.62.
    """
    full = mill("charge.fill=1.0", "charge.diameter=15 mm", "charge.packing=0.55", "mechanism.mounting=rigid")
    assert preflight(full).charge.filling == pytest.approx(1.0, abs=1e-3)
    pellets = preflight(mill("charge.fill=0.99", "charge.packing=0.62", "mechanism.mounting=rigid"))
    assert pellets.charge.filling == pytest.approx(0.99, abs=1e-3)
    dense = mill(
        "charge.fill=0.99", "charge.packing=0.59", "charge.diameter=10 mm", "mechanism.mounting=rigid"
    )
    particles = joined_fills(dense.machine)
    assert particles.volume.sum() > 0.584 * dense.chamber.free_volume
    assert len(cKDTree(particles.centre).query_pairs(0.010)) == 0
