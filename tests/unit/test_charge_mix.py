"""What a charge consists of: parts, amounts, sizes and shapes in a case, and the particles they make."""

import importlib.util
import math
import pathlib
from types import SimpleNamespace

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.base.library import CHARGES, SHAPES
from nutamill.case import Case, load_case
from nutamill.charge.filling.fill import fill_cylinder, random_attitudes, random_fill
from nutamill.charge.filling.relax import near_pairs, size_octaves
from nutamill.charge.model import Status
from nutamill.charge.particles.particles import check_particles, clumps, joined, spheres
from nutamill.charge.particles.shapes import clump_shape
from nutamill.design.preflight import preflight
from nutamill.simulation.setup.charge import pair_laws
from nutamill.simulation.setup.clock import contact_facts, run_clock
from nutamill.simulation.setup.kinds import particle_kinds
from nutamill.simulation.setup.mechanism import assemble_machine
from nutamill.simulation.setup.model import bed_weight, build
from nutamill.simulation.setup.particles import charge_mass, charge_particles, particle_count, particle_masses

MIX = """base = "numill-2025"
[[charge.part]]
kind = "spheres"
material = "steel"
diameter = "4.99 mm"
count = 500
[[charge.part]]
set = "coarse-sand"
count = 2000
[contact.pairs.steel-sand]
normal_stiffness = "500 kN/m"
damping_ratio = 0.2
sliding_friction = 0.5
"""


@pytest.fixture
def sand():
    return load_case("numill-2025", ["charge.set=coarse-sand"])


def case_of(folder, text, *overrides):
    file = folder / "mill.toml"
    file.write_text(text, encoding="utf-8")
    return load_case(file, overrides)


def refused(folder, text, *overrides):
    with pytest.raises(CaseError) as error:
        case_of(folder, text, *overrides)
    return [line.removeprefix(f"{folder}/") for line in str(error.value).splitlines()]


# the sand of 2025 -------------------------------------------------------------------------------------------


def test_the_sand_is_as_many_clumps_of_three_spheres_as_the_paper_counts_and_weighs(sand):
    particles, masses = charge_particles(sand.machine), particle_masses(sand.machine)
    # SAIMM 2025 Table 3: 39534 clumps, 1.34 kg, so 33.9 mg each; the mean of the file is printed to a
    # nanometre of 2.8 mm: 1e-6 in volume
    assert (particles.number, particles.pebbles, len(particles.shapes)) == (39534, 118602, 10)
    assert masses.sum() == pytest.approx(1.34, rel=2e-6)
    assert 1e6 * masses.mean() == pytest.approx(33.9, abs=0.05)


def test_the_sand_has_aspect_ratios_about_one_point_four(sand):
    ratios = [shape.aspect_ratio for shape in charge_particles(sand.machine).shapes]
    # places and radii in the file have five digits of about 0.4
    assert ratios == pytest.approx(np.linspace(1.2, 1.6, 10), abs=1e-4)


def test_each_shape_of_the_sand_is_as_frequent_and_as_large_as_another(sand):
    particles = charge_particles(sand.machine)
    counts = np.bincount(particles.shape_of)
    assert set(counts) == {3953, 3954}
    means = np.array([particles.diameter[particles.shape_of == k].mean() for k in range(10)])
    # five standard errors of a mean of 3953
    assert np.abs(means - particles.diameter.mean()).max() < 5 * particles.diameter.std() / math.sqrt(3953)


def test_the_sand_is_flagged_as_a_stand_in(sand):
    (message,) = [str(warning) for warning in sand.warnings if warning.where == "charge.shapes"]
    assert message.startswith(
        'charge.shapes: "coarse-sand" is a stand-in: the scanned grains of SAIMM 2025 are not public'
    )


def test_the_files_of_the_sand_are_what_their_script_makes():
    script = pathlib.Path(__file__).parents[2] / "tools" / "coarse_sand.py"
    spec = importlib.util.spec_from_file_location("coarse_sand", script)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    assert made.shapes_text() == (SHAPES / "coarse-sand.toml").read_text(encoding="utf-8")
    assert made.charge_text() == (CHARGES / "coarse-sand.toml").read_text(encoding="utf-8")


def test_the_bed_of_the_sand_fills_what_the_paper_says(sand):
    # SAIMM 2025 Table 2 gives 0.27; 1.34 kg over 1403 kg/m^3 in 140 mm x 228 mm is 0.2721
    part = sand.charge.parts[0]
    assert charge_mass(sand.machine) / (2480 * part.packing * sand.chamber.free_volume) == pytest.approx(
        0.2721, abs=1e-4
    )


def test_turning_clumps_shorten_the_contact_that_rules_the_substep(sand):
    quickest = min(contact_facts(sand.machine), key=lambda facts: facts.time)
    whole = particle_masses(sand.machine).min()
    zeta = 0.212
    longest = math.pi * math.sqrt(whole / 2 / 500e3) / math.sqrt(1 - zeta**2)
    assert quickest.pair == "sand-sand"
    assert 0.5 * longest < quickest.time < longest
    assert run_clock(sand.machine).substep <= quickest.time / 20


# amounts ----------------------------------------------------------------------------------------------------


def test_a_fill_is_the_share_of_the_chamber_that_the_settled_bed_takes_up():
    case = load_case("numill", ["charge.fill=0.08", "charge.packing=0.6"])
    solid = 0.08 * 0.6 * math.pi / 4 * 0.14**2 * 0.228
    pellet = math.pi / 6 * 0.005**3
    assert particle_count(case.machine) == math.ceil(solid / pellet)


def test_a_count_is_exactly_that_many_whatever_the_sizes():
    law = (
        'charge.distribution={ law = "normal", by = "mass", mean = "5 mm", deviation = "1 mm", smallest '
        '= "3 mm", largest = "7 mm" }'
    )
    for sizes in (
        "charge.diameter=3 mm",
        'charge.sizes=[["3 mm", 0.21], ["4 mm", 0.33], ["5 mm", 0.46]]',
        law,
    ):
        assert particle_count(load_case("numill", [sizes, "charge.count=777"]).machine) == 777


def test_a_mass_is_met_by_a_law_of_sizes_within_one_particle():
    law = '{ law = "rosin_rammler", size = "4 mm", exponent = 4, smallest = "2 mm", largest = "6 mm" }'
    case = load_case("numill", [f"charge.distribution={law}", "charge.mass=0.5 kg"])
    masses = particle_masses(case.machine)
    assert 0.5 * (1 - 1e-6) <= masses.sum() < 0.5 + masses.max()
    assert (
        0.002
        < charge_particles(case.machine).diameter.min()
        < charge_particles(case.machine).diameter.max()
        < 0.006
    )


def test_the_later_of_two_amounts_takes_the_place_of_the_earlier():
    case = load_case("numill", ["charge.count=100"])
    assert (case.charge.mass, case.charge.count) == (None, 100)
    assert case.with_("charge.mass", 0.1).charge.count is None


# parts ------------------------------------------------------------------------------------------------------


def test_parts_follow_each_other_each_of_its_material(tmp_path):
    case = case_of(tmp_path, MIX)
    particles = charge_particles(case.machine)
    assert case.charge.materials == ("steel", "sand")
    assert particles.number == 2500
    assert (particles.material[:500] == 0).all() and (particles.material[500:] == 1).all()
    masses = particle_masses(case.machine)
    assert masses[:500] == pytest.approx(np.full(500, 7864 * math.pi / 6 * 0.00499**3), rel=1e-12)
    # the sizes of 2000 clumps are those of the 39534, but for half a particle at each end
    assert masses[500:].mean() == pytest.approx(1.34 / 39534, rel=1e-3)


def test_every_pair_of_materials_has_its_law_and_its_facts(tmp_path):
    case = case_of(tmp_path, MIX)
    names = [kind.material for kind in particle_kinds(case.machine).kinds]
    assert list(dict.fromkeys(names)) == ["steel", "sand", "acrylic"]
    assert {(names[a], names[b]) for a, b in pair_laws(case.machine)} == {
        ("steel", "steel"),
        ("steel", "sand"),
        ("steel", "acrylic"),
        ("sand", "sand"),
        ("sand", "acrylic"),
    }
    facts = {one.pair: one for one in contact_facts(case.machine)}
    assert list(facts) == [
        "steel-steel",
        "steel-sand",
        "sand-sand",
        "steel-acrylic wall",
        "sand-acrylic wall",
    ]
    assert facts["steel-sand"].law.damping_ratio == 0.2
    steel = 7864 * math.pi / 6 * 0.00499**3
    assert facts["steel-acrylic wall"].time == pytest.approx(
        math.pi * math.sqrt(steel / 499e3) / math.sqrt(1 - 0.28**2), rel=1e-12
    )
    # a ball and a clump: reduced mass of each one's own, computed from the facts of the like pairs
    clump = 2 * 500e3 * (facts["sand-sand"].time / math.pi) ** 2 * (1 - 0.212**2)
    reduced = steel * clump / (steel + clump)
    assert facts["steel-sand"].time == pytest.approx(
        math.pi * math.sqrt(reduced / 500e3) / math.sqrt(1 - 0.2**2), rel=1e-12
    )


def test_a_bed_of_two_materials_weighs_where_its_mass_is(tmp_path):
    case = case_of(tmp_path, MIX)
    bed = np.zeros((2500, 7))
    bed[:500, :3], bed[500:, :3] = (0.01, 0.0, -0.06), (-0.02, 0.0, -0.06)
    bed[:, 3] = 1.0
    steel, sand = particle_masses(case.machine)[:500].sum(), particle_masses(case.machine)[500:].sum()
    wrench = bed_weight(case.machine, bed, assemble_machine(case.machine)[1])[1]
    assert wrench[2] == pytest.approx(-9.81 * (steel + sand), rel=1e-12)
    # moment about the mass centre of the chamber, 240 mm down its tilted axis: only the place along the
    # tilt's axis x counts
    tilt = math.atan2(39, 366)
    x = (steel * 0.01 - sand * 0.02) / (steel + sand)
    lever = x * math.cos(tilt) + 0.06 * math.sin(tilt)
    assert wrench[4] == pytest.approx(-lever * wrench[2], rel=1e-9)


def test_a_case_of_parts_written_out_is_the_same_case(tmp_path):
    case = case_of(tmp_path, MIX)
    text = case.to_toml()
    assert text.count("[[charge.part]]") == 2
    assert Case.from_toml(text) == case
    assert Case.from_toml(text).to_toml() == text


def test_one_key_of_a_part_may_be_changed_by_its_number(tmp_path):
    case = case_of(tmp_path, MIX, "charge.part.1.count=50")
    assert [part.count for part in case.charge.parts] == [500, 50]
    assert [part.count for part in case.with_("charge.part.0.count", 7).charge.parts] == [7, 50]


def test_a_charge_of_one_part_takes_the_place_of_parts_and_back(tmp_path):
    case = case_of(tmp_path, MIX)
    single = case.with_(
        charge__kind="spheres", charge__material="steel", charge__diameter=0.005, charge__count=10
    )
    assert (len(single.charge.parts), particle_count(single.machine)) == (1, 10)
    again = single.with_(
        "charge.part", [{"kind": "spheres", "material": "steel", "diameter": "5 mm", "fill": 0.05}]
    )
    assert again.charge.kind is None and len(again.charge.parts) == 1


def test_shapes_may_be_a_file_beside_the_case_or_stand_in_it(tmp_path):
    (tmp_path / "grains.toml").write_text("clumps = [[[0, 0, 0, 1], [1, 0, 0, 0.8]]]")
    text = 'base = "numill"\n[charge]\nkind = "clumps"\nshapes = {}\ncount = 3\n'
    one = case_of(tmp_path, text.format('"grains.toml"'))
    two = case_of(tmp_path, text.format("[[[0, 0, 0, 1], [1, 0, 0, 0.8]]]"))
    for case in (one, two):
        # the sizes of the case rule, whatever the unit of the shapes
        assert charge_particles(case.machine).diameter == pytest.approx([0.005] * 3, rel=1e-12)
    assert (one.charge.shapes.source, one.charge.shapes.clumps) == ("grains.toml", two.charge.shapes.clumps)


PELLETS = 'base = "numill"\n[charge]\n'
FAULTS = {
    "two sizes": (
        'diameter = "5 mm"\nsizes = [["4 mm", 1.0]]',
        "mill.toml:4: charge.sizes: needs one of diameter, sizes, distribution, got diameter and "
        'sizes. Write e.g. diameter = "5 mm"',
    ),
    "two amounts": (
        'mass = "1 kg"\nfill = 0.1',
        "mill.toml:4: charge.fill: needs one of mass, count, fill, got mass and fill. Write e.g. "
        'mass = "1 kg"',
    ),
    "clumps without shapes": (
        'kind = "clumps"',
        'mill.toml:2: charge.shapes: is missing, with kind = "clumps". Write e.g. shapes = "coarse-sand"',
    ),
    "spheres with shapes": (
        'kind = "spheres"\nshapes = "coarse-sand"',
        'mill.toml:4: charge.shapes: belongs to kind = "clumps", got kind = "spheres". Leave one of '
        "the two out",
    ),
    "unknown shapes": (
        'kind = "clumps"\nshapes = "coarse-sands"',
        'mill.toml:4: charge.shapes: no set of shapes and no file is called "coarse-sands". Did you '
        'mean "coarse-sand"?',
    ),
    "unknown set": (
        'set = "coarsesand"',
        'mill.toml:3: charge.set: no set of charges is called "coarsesand". Did you mean "coarse-sand"?',
    ),
    "shapes that fall apart": (
        'kind = "clumps"\nshapes = [[[0, 0, 0, 1], [3, 0, 0, 1]]]',
        "mill.toml:4: charge.shapes: clump 0, spheres: must hang together, no chain of overlaps "
        "leads from sphere 0 to 1. Move them closer",
    ),
    "key of the other law": (
        'distribution = { law = "normal", mean = "5 mm", deviation = "1 mm", by = "mass", size = "3 '
        'mm", smallest = "3 mm", '
        'largest = "7 mm" }',
        'mill.toml:3: charge.distribution: size does not belong to law = "normal". Its keys: mean, '
        "deviation, by",
    ),
    "number or mass": (
        'distribution = { law = "normal", mean = "5 mm", deviation = "1 mm", smallest = "3 mm", '
        'largest = "7 mm" }',
        'mill.toml:3: charge.distribution: by is missing, with law = "normal". Its keys: mean, deviation, by',
    ),
    "cuts the wrong way round": (
        'distribution = { law = "rosin_rammler", size = "5 mm", exponent = 3, smallest = "7 mm", '
        'largest = "3 mm" }',
        "mill.toml:3: charge.distribution: smallest must be less than largest, got 0.007 m and 0.003 m",
    ),
    "cuts beyond the law": (
        'distribution = { law = "rosin_rammler", size = "1 mm", exponent = 9, smallest = "6 mm", '
        'largest = "7 mm" }',
        "mill.toml:3: charge.distribution: the law has no share between the cuts. Move smallest and largest",
    ),
    # 100000 x pi/6 (5 mm)^3 / 0.58 = 11.28 L; pi/4 (140 mm)^2 x 228 mm = 3.51 L hold 31102.8 of them
    "too many": (
        "count = 100000",
        "mill.toml:3: charge.count: 100000 particles need 11.3 L loose, the chamber holds 3.51 L. "
        "Largest number that settles: 31102",
    ),
    # 1.347 kg / 7863.7 kg/m^3 / (pi/6 (1 um)^3) = 3.3e14
    "dust": (
        'diameter = "1 um"',
        "numill-2026.toml: charge.mass: makes 3.3e+14 particles, more than the limit of 2e+07. Take "
        "less, or coarser particles",
    ),
    "parts and keys of their own": (
        'material = "steel"\n[[charge.part]]\nkind = "spheres"\nmaterial = "steel"\ndiameter = "5 '
        'mm"\ncount = 1',
        "mill.toml:3: charge.material: a charge has either parts or keys of its own, got parts and material. "
        "Move it into a [[charge.part]]",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_charge_that_contradicts_itself_is_refused_with_the_cure(name, tmp_path):
    text, message = FAULTS[name]
    line = refused(tmp_path, PELLETS + text)
    if message.startswith("numill-2026.toml: "):  # of the base, whose line numbers may change
        line = [":".join([line[0].split(":", 2)[0], line[0].split(":", 2)[2]]), *line[1:]]
    assert line == [message]


def test_faults_of_parts_name_their_lines(tmp_path):
    text = MIX.replace("count = 500\n", "").replace("count = 2000\n[contact", 'material = "snad"\n[contact')
    assert refused(tmp_path, text) == [
        'mill.toml:8: charge.part[1].material: no material is called "snad". Did you mean "sand"?',
        "mill.toml:2: charge.part[0].mass: needs one of mass, count, fill, got none. Write e.g. mass "
        '= "1 kg"',
    ]
    assert refused(tmp_path, MIX.replace('kind = "spheres"', 'kind = "sphere"')) == [
        'mill.toml:3: charge.part[0].kind: must be one of "spheres", "clumps", got "sphere". Did you '
        'mean "spheres"?'
    ]
    assert refused(tmp_path, MIX.split("[contact")[0])[0].endswith(
        "contact.pairs.steel-sand: is missing: the charge is steel and touches sand. Add a table "
        "[contact.pairs.steel-sand]"
    )


# particles and their places ---------------------------------------------------------------------------------

DUMBBELL = clump_shape([[0, 0, 0], [1, 0, 0]], [0.8, 0.7])


def test_clumps_and_spheres_join_into_one_charge():
    both = joined([spheres(np.array([4e-3, 5e-3]), 1), clumps([DUMBBELL], np.array([3e-3]), 0)])
    assert both.number == 3 and both.pebbles == 4 and not both.spheres_only
    assert both.diameter == pytest.approx([4e-3, 5e-3, 3e-3], rel=1e-12)
    assert both.mass([2000.0, 3000.0]) == pytest.approx(
        np.array([3000, 3000, 2000]) * math.pi / 6 * both.diameter**3, rel=1e-12
    )
    assert both.bounding_radius[2] == pytest.approx(DUMBBELL.scaled(3e-3).bounding_radius, rel=1e-12)


def test_the_seed_decides_which_shape_goes_with_which_size():
    sizes = np.linspace(1e-3, 2e-3, 50)
    pair = [DUMBBELL, clump_shape([[0, 0, 0], [1.2, 0, 0]], [0.8, 0.7])]
    one, same, other = (clumps(pair, sizes, seed=seed).shape_of for seed in (3, 3, 4))
    assert (one == same).all() and (one != other).any() and np.bincount(other).tolist() == [25, 25]


def test_the_seed_of_the_run_mixes_shapes_and_leaves_sizes(sand):
    one, other = charge_particles(sand.machine), charge_particles(sand.with_(run__seed=2).machine)
    assert (one.shape_of != other.shape_of).any() and (one.scale == other.scale).all()


def test_filled_clumps_keep_clear_of_each_other_and_of_the_chamber():
    law = SimpleNamespace(radius=0.02, floor=-0.1, ceiling=-0.05)
    mixed = joined([spheres(np.full(40, 4e-3)), clumps([DUMBBELL], np.full(150, 3e-3))])
    boxes = [((0.018, 0.0, -0.09), np.eye(3), (0.002, 0.002, 0.01))]
    filled = fill_cylinder(mixed, law.radius, law.floor, law.ceiling, boxes, seed=3)
    r, x = filled.bounding_radius, filled.centre
    gap = np.linalg.norm(x[:, None] - x, axis=2) - r[:, None] - r + np.diag(np.full(len(r), 1.0))
    assert gap.min() >= 0.0
    assert (np.hypot(x[:, 0], x[:, 1]) + r).max() <= law.radius
    assert (x[:, 2] - r).min() >= law.floor and (x[:, 2] + r).max() <= law.ceiling
    centre, _, half = boxes[0]
    away = np.linalg.norm(np.maximum(np.abs(x - centre) - half, 0.0), axis=1)
    assert (away - r).min() >= 0.0
    assert np.linalg.norm(filled.attitude, axis=1) == pytest.approx(np.ones(190), rel=1e-12)
    again = fill_cylinder(mixed, law.radius, law.floor, law.ceiling, boxes, seed=3)
    assert (again.poses == filled.poses).all()
    check_particles(filled, [2500.0])


def test_random_attitudes_favour_no_direction():
    w, x, y, z = random_attitudes(20_000, seed=2).T
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    # a direction of no preference has mean 0 and mean square 1/3 in each axis; five standard errors, of
    # variances 1/3 and 1/5 - 1/9
    assert np.abs(up.mean(axis=1)).max() < 5 * math.sqrt(1 / 3 / 20_000)
    assert np.abs((up**2).mean(axis=1) - 1 / 3).max() < 5 * math.sqrt((1 / 5 - 1 / 9) / 20_000)


def test_near_pairs_of_any_sizes_miss_no_overlap():
    rng = np.random.default_rng(8)
    r, x = 1e-3 * rng.lognormal(0.0, 1.0, 400), 0.03 * rng.random((400, 3))
    i, j = near_pairs(x, size_octaves(r))
    pairs = {frozenset(pair) for pair in zip(i.tolist(), j.tolist(), strict=True)}
    assert len(pairs) == len(i) and (i != j).all()
    a, b = np.triu_indices(400, 1)
    touching = np.linalg.norm(x[a] - x[b], axis=1) < r[a] + r[b]
    assert touching.any()
    assert {frozenset(pair) for pair in zip(a[touching].tolist(), b[touching].tolist(), strict=True)} <= pairs


def test_a_fill_of_many_sizes_is_free_of_overlaps():
    radii = np.geomspace(0.4e-3, 4e-3, 600)
    x = random_fill(radii, 0.03, 0.0, 0.06, seed=2)
    gap = np.linalg.norm(x[:, None] - x, axis=2) - radii[:, None] - radii + np.diag(np.full(600, 1.0))
    assert gap.min() >= 0.0


SPOILED = {
    "no size": ("scale", [1e-3, 0.0, 1e-3], "particles.scale: must be positive, not so for particles 1"),
    "no such shape": (
        "shape_of",
        [0, 0, 5],
        "particles.shape_of: must be from 0 to 0, not so for particles 2",
    ),
    "no such material": (
        "material",
        [0, -1, 0],
        "particles.material: must be from 0 to 0, not so for particles 1",
    ),
    "nowhere": (
        "centre",
        [[0, 0, 0], [0, 0, 1], [0, math.nan, 0]],
        "particles.centre: must be finite, not so for particles 2",
    ),
    "no attitude": ("attitude", None, "particles.attitude: is missing, and not all particles are spheres"),
    "no unit quaternion": (
        "attitude",
        [[1, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0]],
        "must be unit quaternions, not so for particles 1",
    ),
    "too few": ("centre", [[0, 0, 0]], "particles.centre: must have shape (3, 3), got (1, 3)"),
}


@pytest.mark.parametrize("name", SPOILED)
def test_particles_that_cannot_be_are_refused_by_id(name):
    field, value, message = SPOILED[name]
    good = clumps([DUMBBELL], np.full(3, 1e-3)).placed(
        np.zeros((3, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    )
    check_particles(good, [2500.0])
    fields = {
        name: getattr(good, name)
        for name in ("shapes", "shape_of", "scale", "material", "centre", "attitude")
    }
    fields[field] = None if value is None else np.array(value)
    with pytest.raises(CaseError) as error:
        check_particles(type(good)(**fields), [2500.0])
    assert message in str(error.value)


def test_particles_without_mass_are_refused_by_id():
    with pytest.raises(CaseError, match=r"particles.density: must be positive, not so for particles 0, 1"):
        check_particles(spheres(np.full(2, 1e-3)).placed(np.zeros((2, 3))), [0.0])


# in the mill ------------------------------------------------------------------------------------------------

TWO_SIZES = """base = "numill-2025"
[[charge.part]]
kind = "spheres"
material = "steel"
distribution = { law = "rosin_rammler", size = "5 mm", exponent = 5, smallest = "3 mm", largest = "7 mm" }
mass = "0.1 kg"
[[charge.part]]
kind = "spheres"
material = "sand"
diameter = "3 mm"
fill = 0.01
[contact.pairs.steel-sand]
normal_stiffness = "500 kN/m"
damping_ratio = 0.2
sliding_friction = 0.5
"""


def test_spheres_of_two_materials_and_many_sizes_are_built_with_their_own_masses(tmp_path):
    case = case_of(tmp_path, TWO_SIZES)
    filled = fill_cylinder(charge_particles(case.machine), 0.07, 0.240 - 0.350, 0.240 - 0.122)
    model, state, _ = build(case.machine, filled.poses)
    n = particle_count(case.machine)
    masses = np.empty(n)
    masses[state.charge.ids[:n]] = state.charge.mass_props[1, :n]
    assert model.charge.n_particles == n and state.charge.status[0] == Status.OK
    assert masses == pytest.approx(particle_masses(case.machine), rel=1e-12)


def test_the_sheet_has_number_mass_sizes_and_fill_of_each_part(tmp_path):
    sheet = preflight(case_of(tmp_path, TWO_SIZES))
    steel, sand = sheet.charge.parts
    assert (steel.name, sand.name) == ("spheres of steel", "spheres of sand")
    # the fewest that weigh 0.1 kg; the largest weighs 7864 pi/6 (7 mm)^3 = 1.4 g
    assert 0.1 <= steel.mass < 0.1 + 7864 * math.pi / 6 * 0.007**3
    # half the mass below the median of the cut law, (d/5 mm)^5 = -ln(1 - F) with F half way between the cuts;
    # the
    # sample is off by three masses of the largest at most (as in the tests of sizes), the percentile by one
    below = [1 - math.exp(-((d / 5) ** 5)) for d in (3, 7)]
    median = 5e-3 * (-math.log(1 - sum(below) / 2)) ** 0.2
    slope = (below[1] - below[0]) / ((median / 5e-3) ** 4 * math.exp(-((median / 5e-3) ** 5)) / 1e-3)
    assert steel.sizes[1] == pytest.approx(median, abs=4 * 7864 * math.pi / 6 * 0.007**3 / 0.1 * slope)
    # 1 % of the chamber, up to one particle of 14 mm^3 at 0.58
    assert 0.01 <= sand.filling < 0.01 + 14.2e-9 / 0.58 / 3.5e-3
    assert sheet.charge.filling == steel.filling + sand.filling
    lines = [
        line for line in sheet.lines() if " of steel" in line or " of sand" in line or "together" in line
    ]
    assert (
        lines[0].startswith(f"charge    {steel.particles} spheres of steel, 0.1") and "d10/50/90" in lines[0]
    )
    assert (
        f"{sand.particles} spheres of sand" in lines[1]
        and "d 3 mm, fill 1.0 % loose at solids fraction 0.58" in lines[1]
    )
    assert f"together {steel.particles + sand.particles}, " in lines[2]
