"""Entries of a list of tables are addressed by name, or by number where they have none: after --set, in
Python, in files with a base, in sweeps and in fits.
"""

import pytest

from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.case.differences import swept_axis, values_by_key
from nutamill.case.toml.keys import held, si_at, unit_at
from nutamill.case.toml.schema import case_schema
from nutamill.studies.axes import axis_values, changed
from nutamill.studies.fit import _free
from nutamill.studies.fit_file import FreeKey

BODY = """
[[bodies]]
name     = "{}"
mass     = "2 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "1 kg m^2"]
position = ["0 m", "0 m", "0 m"]
"""
MOTOR = """
[[joints]]
name    = "pin"
kind    = "revolute"
between = ["ground", "box"]
point   = ["0 m", "0 m", "0 m"]
axis    = [0, 0, 1]
[[drives]]
name  = "motor"
joint = "pin"
speed = "10 rpm"
ramp  = "10 rpm/s"
"""
BOXES = 'title = "Boxes"\n' + BODY.format("box") + BODY.format("far__lid") + MOTOR + '[run]\nuntil = "1 s"\n'
PARTS = """base = "numill-2025"
[[charge.part]]
kind = "spheres"
material = "steel"
diameter = "4.99 mm"
count = 500
[[charge.part]]
kind = "spheres"
material = "steel"
diameter = "3 mm"
count = 200
"""


@pytest.fixture
def boxes(tmp_path):
    """A file of two bodies, a joint and its drive."""
    file = tmp_path / "boxes.toml"
    file.write_text(BOXES)
    return file


@pytest.fixture
def parts(tmp_path):
    """A file of a mill with a charge of two parts."""
    file = tmp_path / "parts.toml"
    file.write_text(PARTS)
    return file


def above(file, text):
    """A file with another as its base."""
    other = file.with_name("above.toml")
    other.write_text(f'base = "{file.name}"\n{text}')
    return other


def refusal(file, *overrides):
    """Return what `load_case` says, without the folder."""
    with pytest.raises(CaseError) as caught:
        load_case(file, overrides)
    return str(caught.value).replace(f"{file.parent}/", "")


@pytest.mark.parametrize("key", ["bodies.far__lid.mass", "bodies.1.mass", "bodies[1].mass"])
def test_a_body_is_addressed_by_name_or_number_on_every_way_in(boxes, key):
    case = load_case(boxes)
    typed = load_case(boxes, [f"{key}=3 kg"])
    for one in (typed, case.with_(key, "3 kg"), changed(case, {key: 3.0})):
        assert [body.mass for body in one.bodies] == [2.0, 3.0]
        assert one.title == "boxes with bodies.far__lid.mass = 3 kg"
        assert one.with_("bodies.far__lid.mass", 2.0).title == "Boxes"
    assert held(typed, key) == 3.0


LOADS = """
[[springs]]
name        = "coil"
between     = ["ground", "box"]
point_a     = ["0 m", "0 m", "1 m"]
point_b     = ["0 m", "0 m", "0 m"]
stiffness   = "50 N/m"
free_length = "1 m"
[[forces]]
name  = "push"
body  = "box"
force = ["1 N", "0 N", "0 N"]
[[unbalance_motors]]
name         = "shaker"
body         = "box"
point        = ["0 m", "0 m", "0 m"]
axis         = [0, 0, 1]
towards      = [1, 0, 0]
mass         = "1 kg"
eccentricity = "10 mm"
speed        = "60 rpm"
ramp         = "60 rpm/s"
"""


def test_a_later_one_of_two_ways_to_give_a_load_takes_the_place_of_the_earlier(boxes):
    boxes.write_text(BOXES.replace("[run]", f"{LOADS}[run]"))
    boxes.with_name("speed.csv").write_text("time [s], speed [rpm]\n0, 0\n1, 60\n")
    table = 'table = [["0 s", ["0 N", "0 N", "0 N"]], ["1 s", ["1 N", "0 N", "0 N"]]]\n'
    changes = f'[springs.coil]\npreload = "3 N"\n[forces.push]\n{table}'
    case = load_case(above(boxes, changes + '[unbalance_motors.shaker]\nprofile = "speed.csv"\n'))
    assert (case.springs[0].free_length, case.springs[0].preload) == (None, 3.0)
    assert (case.forces[0].force, len(case.forces[0].table)) == (None, 2)
    assert (case.unbalance_motors[0].ramp, case.unbalance_motors[0].profile.source) == (None, "speed.csv")


@pytest.mark.parametrize("key", ["charge.part.1.count", "charge.part[1].count"])
def test_a_part_of_a_charge_has_no_name_and_is_addressed_by_number(parts, key):
    case = load_case(parts, [f"{key}=7"])
    assert [part.count for part in case.charge.parts] == [500, 7]
    assert values_by_key(case)["charge.part.1.count"] == held(case, key) == 7


def test_a_file_changes_single_entries_of_its_base_or_replaces_the_list(boxes):
    one = load_case(above(boxes, '[bodies.box]\nmass = "5 kg"\n[drives]\nmotor.speed = "20 rpm"\n'))
    assert [(body.name, body.mass) for body in one.bodies] == [("box", 5.0), ("far__lid", 2.0)]
    assert one.title == "boxes with bodies.box.mass = 5 kg, drives.motor.speed = 20 rpm"
    other = load_case(above(boxes, BODY.format("box")))
    assert [body.name for body in other.bodies] == ["box"]


def test_a_list_and_one_of_its_entries_may_be_typed_together(parts):
    tables = '[{ kind = "spheres", material = "steel", diameter = "5 mm", count = 1 }]'
    case = load_case("numill-2025", [f"charge.part={tables}", "charge.part.0.count=9"])
    assert [part.count for part in case.charge.parts] == [9]
    with pytest.raises(CaseError, match=r"charge.part.1: no such entry, got \"1\""):
        load_case("numill-2025", [f"charge.part={tables}", "charge.part.1.count=9"])


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            "bodies.bok.mass=1 kg",
            '--set bodies.bok: no such entry, got "bok". Did you mean "box"? Known: box, far__lid',
        ),
        ("bodies.2.mass=1 kg", '--set bodies.2: no such entry, got "2". Known: box, far__lid'),
        (
            "springs.coil.stiffness=1 N/m",
            "--set springs: must be a list of tables, got a table. It has no entry to change yet: add a "
            "table [[springs]]",
        ),
        ("bodies.box=3", "--set bodies.box: must be a table, got 3. Write bodies.box.KEY"),
        ("bodies.box.mass=-1 kg", '--set bodies.box.mass: must be zero or more, got "-1 kg"'),
        ("bodies[0].mass=-1 kg", '--set bodies.box.mass: must be zero or more, got "-1 kg"'),
        ("bodies[box].mass=1 kg", '--set: must be key=value, got "bodies[box].mass=1 kg"'),
        ("bodies.box.mas=1 kg", '--set bodies.box.mas: unknown key. Did you mean "mass"?'),
        ("drives.motor.joint=pim", '--set drives.motor.joint: no joint is called "pim". Did you mean "pin"?'),
    ],
)
def test_what_is_wrong_with_an_entry_is_refused_under_its_name(boxes, override, message):
    assert refusal(boxes, override).startswith(message)


def test_an_entry_without_a_name_that_is_not_there_is_refused_with_the_numbers_there_are(parts):
    assert refusal(parts, "charge.part.2.count=1") == (
        '--set charge.part.2: no such entry, got "2". The entries have no names. Write charge.part.0 to '
        "charge.part.1"
    )


def test_a_key_in_python_that_is_none_is_refused(boxes):
    with pytest.raises(CaseError, match=r'"drive speed": must be a dotted key. Write e.g. "drive.speed"'):
        load_case(boxes).with_("drive speed", 1.0)
    with pytest.raises(CaseError, match=r'^bodies.bok: no such entry, got "bok"'):
        load_case(boxes).with_("bodies.bok.mass", 1.0)


def test_a_fault_has_the_line_of_the_layer_that_wrote_the_entry(boxes):
    changes = above(boxes, '[bodies.box]\nmass = "-5 kg"\n')
    assert refusal(changes).startswith('above.toml:3: bodies.box.mass: must be zero or more, got "-5 kg"')
    unknown = above(boxes, '\n[bodies]\nbok.mass = "5 kg"\n')
    assert refusal(unknown).startswith('above.toml:4: bodies.bok: no such entry, got "bok"')
    # the list of the upper file has no mass: its place is that of the list, not that of the mass in the base
    lacks = above(boxes, "\n" + BODY.format("box").replace('mass     = "2 kg"\n', ""))
    assert refusal(lacks).startswith("above.toml:4: bodies.box.mass: is missing")


def test_a_fault_names_the_second_of_two_entries_of_one_name_by_its_number(boxes):
    boxes.write_text(BOXES.replace("far__lid", "box"))
    assert refusal(boxes).startswith('boxes.toml:10: bodies[1].name: is the name of two parts, got "box"')


def test_a_table_that_an_override_begins_leaves_the_place_of_what_a_file_lacks(tmp_path):
    file = tmp_path / "free.toml"
    file.write_text('base = "numill"\n[charge]\nkind = "clumps"\n')
    assert refusal(file, "charge.mass=1 kg").startswith("free.toml:2: charge.shapes: is missing")


def test_the_profile_of_a_drive_may_be_typed(boxes):
    boxes.with_name("speed.csv").write_text("time [s], speed [rpm]\n0, 0\n1, 60\n")
    case = load_case(above(boxes, 'drives.motor.profile = "speed.csv"\n'))
    assert len(case.drives[0].profile.points) == 2
    assert "nothing.csv" in refusal(boxes, "drives.motor.profile=nothing.csv")


def test_the_quantity_of_a_key_that_names_an_entry_is_known(boxes):
    assert (unit_at("bodies.box.mass"), unit_at("bodies[0].position")) == ("kg", "m")
    assert (unit_at("charge.part.1.diameter"), unit_at("charge.part.1.count")) == ("m", "1")
    assert si_at("bodies.box.mass", "500 g", "fit") == 0.5
    with pytest.raises(CaseError, match=r'must have a unit, got "1..3 / 3". Write e.g. "1..3 kg / 5"'):
        axis_values("bodies.box.mass", "1..3 / 3")


def test_the_number_in_which_cases_differ_is_named_by_its_entry(boxes):
    axis = swept_axis([load_case(boxes, [f"bodies.box.mass={mass} kg"]) for mass in (1, 3)])
    assert (axis.label, axis.values) == ("bodies.box.mass (kg)", [1.0, 3.0])


def test_a_free_key_of_a_fit_may_name_an_entry(boxes):
    given = FreeKey(start="2 kg", low="500 g", high="4 kg")
    free = _free("bodies.box.mass", given, load_case(boxes), "fit.toml:3: free")
    assert (free.start, free.low, free.high) == (2.0, 0.5, 4.0)
    with pytest.raises(CaseError, match=r'fit.toml:3: free: no such entry, got "bok". Did you mean'):
        _free("bodies.bok.mass", given, load_case(boxes), "fit.toml:3: free")


def test_the_schema_of_editors_lets_a_file_change_one_entry():
    listed, single = case_schema()["properties"]["walls"]["anyOf"]
    assert listed["items"] == single["additionalProperties"] == {"$ref": "#/$defs/MeshedWall"}
