"""Each bad input is refused with file, line, key, what is wrong and what to write."""

import pytest

from nutamill.base.errors import CaseError
from nutamill.case import library_names, load_case

BASE = 'base = "numill"\n'


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def refused(text, overrides=(), name="mill.toml"):
    """Lines of the refusal of a case file."""
    with open(name, "w", encoding="utf-8") as file:
        file.write(text)
    with pytest.raises(CaseError) as error:
        load_case(name, overrides)
    return str(error.value).splitlines()


# keys and values --------------------------------------------------------------------------------------------

ONE_FAULT = {
    "typo": (
        "[chamber]\nrib_count = 12",
        'mill.toml:3: chamber.rib_count: unknown key. Did you mean "ribs"?',
    ),
    "key of another table": (
        "[mechanism]\nribs = 12",
        "mill.toml:3: mechanism.ribs: unknown key. It belongs in [chamber]",
    ),
    "misspelt table": ("[chambr]\nribs = 2", 'mill.toml:2: chambr: unknown key. Did you mean "chamber"?'),
    "number for a quantity": (
        "[drive]\nspeed = 700",
        'mill.toml:3: drive.speed: needs a unit: write "700 rpm" (a plain number is ambiguous)',
    ),
    "wrong kind": (
        '[charge]\ndiameter = "5 kg"',
        'mill.toml:3: charge.diameter: "5 kg" is a mass, this needs a length, e.g. "5 mm"',
    ),
    "unknown unit": (
        '[run]\nuntil = "3 sec"',
        'mill.toml:3: run.until: unknown unit "sec". Did you mean "s"?',
    ),
    "frequency for a speed": (
        '[drive]\nspeed = "11.7 Hz"',
        'mill.toml:3: drive.speed: "11.7 Hz" is a frequency; write "11.7 rev/s" or "702 rpm" (we do '
        "not guess between Hz and rad/s)",
    ),
    "negative length": (
        '[chamber]\nheight = "-1 mm"',
        'mill.toml:3: chamber.height: must be positive, got "-1 mm"',
    ),
    "zero mass": ('[carriage]\nmass = "0 kg"', 'mill.toml:3: carriage.mass: must be positive, got "0 kg"'),
    "quantity that is not a number": (
        '[drive]\nspeed = "nan rpm"',
        'mill.toml:3: drive.speed: must be a finite number with a unit, got "nan rpm". Write e.g. "700 rpm"',
    ),
    "not a number without a unit": (
        "[mechanism]\ngravity = inf",
        "mill.toml:3: mechanism.gravity: must be a finite number with a unit, got inf. Write e.g. "
        '"9.81 m/s^2"',
    ),
    "ratio that is not a number": (
        "[mechanism]\njoint_friction = nan",
        "mill.toml:3: mechanism.joint_friction: must be a finite number, got nan",
    ),
    "text for a ratio": (
        '[mechanism]\njoint_friction = "0.3"',
        'mill.toml:3: mechanism.joint_friction: must be a plain number, got "0.3"',
    ),
    "truth for a count": (
        "[chamber]\nribs = true",
        "mill.toml:3: chamber.ribs: must be a plain number, got true",
    ),
    "negative friction": (
        "[mechanism]\njoint_friction = -1",
        "mill.toml:3: mechanism.joint_friction: must be at least 0, got -1",
    ),
    "restitution of zero": (
        "[contact.pairs.steel-steel]\nrestitution = 0",
        "mill.toml:3: contact.pairs.steel-steel.restitution: must be greater than 0, got 0",
    ),
    "restitution above one": (
        "[contact.pairs]\nsteel-steel = { restitution = 1.2 }",
        "mill.toml:3: contact.pairs.steel-steel.restitution: must be at most 1, got 1.2",
    ),
    "unknown normal law": (
        '[contact]\nnormal = "herz"',
        'mill.toml:3: contact.normal: must be one of "linear", "hysteretic", "hertz", got "herz". '
        'Did you mean "hertz"?',
    ),
    "solid without Poisson's ratio": (
        '[materials.rubber]\ndensity = "1100 kg/m^3"\nyoung_modulus = "5 MPa"',
        "mill.toml:2: materials.rubber.poisson_ratio: is missing. "
        "Add e.g. poisson_ratio under [materials.rubber]",
    ),
    "half a window": ("[run]\nwindow = 2.5", "mill.toml:3: run.window: must be a whole number, got 2.5"),
    "no threads": (
        "[run]\nthreads = 0",
        'mill.toml:3: run.threads: must be "auto" or a whole number from 1 to 1000, got 0',
    ),
    "substep of a wrong kind": (
        '[run]\ndt = "3 mm"',
        'mill.toml:3: run.dt: "3 mm" is a length, this needs a time, e.g. "2 s"',
    ),
    "unknown coupling": (
        '[run]\ncoupling = "stagered"',
        'mill.toml:3: run.coupling: must be one of "prescribed", "staggered", "iterated", got '
        '"stagered". Did you mean "staggered"?',
    ),
    "scalar for a nested table": (
        "[run]\nsnapshots = 3",
        "mill.toml:3: run.snapshots: must be a table, got 3. Its keys: rate, last",
    ),
    "list for a quantity": (
        "[drive]\nspeed = [1, 2]",
        'mill.toml:3: drive.speed: must be text with a unit, got a list. Write e.g. "700 rpm"',
    ),
    "table for a quantity": (
        "[drive.speed]\nx = 1",
        'mill.toml:2: drive.speed: must be text with a unit, got a table. Write e.g. "700 rpm"',
    ),
    "scalar for the materials": (
        "[materials]\nsteel = 3",
        "mill.toml:3: materials.steel: must be a table, got 3. Its keys: density, young_modulus, "
        "poisson_ratio",
    ),
    "sensor on no part": (
        '[sensors]\nx = { body = "fram", at = ["1 mm", "2 mm", "3 mm"] }',
        'mill.toml:3: sensors.x.body: must be one of "frame", "chamber", "carriage", "driveshaft", '
        '"bearing_cross", '
        '"intermediate_shaft", got "fram". Did you mean "frame"?',
    ),
    "sensor with two coordinates": (
        '[sensors]\nx = { body = "frame", at = ["1 mm", "2 mm"] }',
        "mill.toml:3: sensors.x.at[2]: is missing. The list has 2 of its entries",
    ),
    "sensor with four coordinates": (
        '[sensors]\nx = { body = "frame", at = ["1 mm", "2 mm", "3 mm", "4 mm"] }',
        "mill.toml:3: sensors.x.at: must have 3 entries, got 4",
    ),
    "newer schema": (
        "schema = 2",
        "mill.toml:2: schema: must be 1, got 2. This version of the package reads schema 1; update "
        "it, or write schema = 1",
    ),
    "unknown mount set": (
        '[mounts]\nset = "34"',
        'mill.toml:3: mounts.set: no set of mounts is called "34". Did you mean "343"?',
    ),
}


@pytest.mark.parametrize("name", ONE_FAULT)
def test_a_wrong_key_or_value_is_located_and_named(name):
    text, message = ONE_FAULT[name]
    assert refused(BASE + text) == [message]


# what contradicts -------------------------------------------------------------------------------------------

CONTRADICTIONS = {
    "Hertz with a direct stiffness": (
        '[contact]\nnormal = "hertz"\nstiffness = "direct"\n[contact.pairs]\n'
        'steel-steel = { normal_stiffness = "500 kN/m" }\nsteel-acrylic = { normal_stiffness = "16 kN/m" }',
        'mill.toml:4: contact.stiffness: must be "young" with normal = "hertz", got "direct". '
        "Hertz takes young_modulus and poisson_ratio of the materials; contact.softening makes them softer",
    ),
    "hysteretic with a damping ratio": (
        '[contact]\nnormal = "hysteretic"\ndamping = "ratio"\n[contact.pairs]\n'
        "steel-steel = { damping_ratio = 0.2 }\nsteel-acrylic = { damping_ratio = 0.2 }",
        'mill.toml:4: contact.damping: must be "restitution" with normal = "hysteretic", got "ratio". '
        "It has no dashpot: its unloading stiffness follows from the restitution of each pair",
    ),
    "pressure without cohesion": (
        '[contact.pairs]\nsteel-steel = { cohesive_pressure = "1 MPa" }',
        "mill.toml:3: contact.pairs.steel-steel.cohesive_pressure: has no effect with "
        'contact.cohesion = "none". '
        'Write cohesion = "area" in [contact], or leave it out',
    ),
    "viscosity without a film": (
        '[contact.pairs]\nsteel-steel = { liquid_viscosity = "50 mPa s" }',
        "mill.toml:3: contact.pairs.steel-steel.liquid_viscosity: has no effect with "
        'contact.film = "none". '
        'Write film = "viscous" in [contact], or leave it out',
    ),
    "bridges without their film": (
        '[contact.pairs]\nsteel-steel = { bridge_volume = "1 nL" }',
        "mill.toml:3: contact.pairs.steel-steel.bridge_volume: has no effect with "
        'contact.film = "none". '
        'Write film = "capillary" in [contact], or leave it out',
    ),
    "nutation angle": (
        '[chamber]\nnutation_angle = "9 deg"',
        "mill.toml:3: chamber.nutation_angle: crank_radius 39 mm and nutation_point_to_crank 366 mm "
        "give 6.08 deg, but nutation_angle "
        'is 9 deg. One of the three is wrong; with these lengths write nutation_angle = "6.082 deg"',
    ),
    "ceiling above the nutation point": (
        '[chamber]\nheight = "400 mm"',
        "mill.toml:3: chamber.height: must be less than floor_depth 350 mm, got 400 mm. The ceiling "
        "has to lie below the nutation point",
    ),
    "rib deeper than the bore": (
        '[chamber]\nribs = 12\n[chamber.rib]\ndepth = "80 mm"',
        "mill.toml:5: chamber.rib.depth: must be less than the radius of the bore 70 mm, got 80 mm",
    ),
    # 40 ribs: half the pitch angle is 4.5 deg; 2 x 60 mm x tan(4.5 deg) = 9.444 mm
    "too many ribs": (
        "[chamber]\nribs = 40",
        "mill.toml:3: chamber.ribs: 40 ribs of 10 mm by 10 mm do not fit: there is room for 9.444 mm "
        "each. Fewer or narrower ribs",
    ),
    "parts heavier than the whole": (
        '[mechanism]\ntotal_mass = "10 kg"',
        "mill.toml:3: mechanism.total_mass: must exceed the 12.13 kg of chamber, carriage, "
        "driveshaft and bearing cross, got 10 kg. "
        "The frame takes what the other parts leave",
    ),
    # 5.29 kg x (0.24 m)^2 = 0.3047 kg m^2
    "inertia below its mass's share": (
        '[chamber]\ninertia_transverse = "0.3 kg m^2"',
        "mill.toml:3: chamber.inertia_transverse: must exceed mass x mass_centre_depth^2 = 0.3047 kg "
        "m^2, got 0.3 kg m^2. "
        "It is taken about the nutation point",
    ),
    "inertia no body has": (
        '[driveshaft]\ninertia_axial = "0.05 kg m^2"',
        "mill.toml:3: driveshaft.inertia_axial: must be at most twice inertia_transverse, 0.04 kg "
        "m^2, got 0.05 kg m^2",
    ),
    "unknown material": (
        '[charge]\nmaterial = "stel"',
        'mill.toml:3: charge.material: no material is called "stel". Did you mean "steel"?',
    ),
    "pair of an unknown material": (
        "[contact.pairs.steel-sand]\nsliding_friction = 0.5",
        "mill.toml:2: contact.pairs.steel-sand: must name two materials of the file. Did you mean "
        '"steel-steel"?',
    ),
    "missing pair": (
        '[chamber]\nmaterial = "rubber"\n[materials.rubber]\ndensity = "1100 kg/m^3"\nyoung_modulus '
        '= "5 MPa"\npoisson_ratio = 0.4',
        "numill-2026.toml: contact.pairs.steel-rubber: is missing: the charge is steel and touches rubber. "
        "Add a table [contact.pairs.steel-rubber]",
    ),
    "pair given twice": (
        "[contact.pairs.acrylic-steel]\nsliding_friction = 0.5\nrestitution = 0.5",
        "numill-2026.toml: contact.pairs.steel-acrylic: this pair appears twice, also as "
        "acrylic-steel. Keep one of the two",
    ),
    "limits of the overlap": (
        "[contact.pairs.steel-steel]\noverlap_warn = 0.2",
        "mill.toml:3: contact.pairs.steel-steel.overlap_warn: must be less than overlap_stop 0.1, got 0.2",
    ),
    # 20 kg / (7863.7 kg/m^3 x 0.58) = 4.385 L; pi/4 (0.14 m)^2 0.228 m - 12 x 0.01 x 0.01 x 0.228 m^3 = 3.236
    # L, 14.76 kg
    "too much charge": (
        '[charge]\nmass = "20 kg"\n[chamber]\nribs = 12',
        "mill.toml:3: charge.mass: 20 kg needs 4.39 L loose, the ribbed chamber holds 3.24 L. "
        "Largest mass that settles: 14.76 kg",
    ),
    "no charge": (
        '[charge]\nmass = "0 kg"',
        'mill.toml:3: charge.mass: must be positive. For an empty chamber write kind = "none"',
    ),
    "balls wider than the chamber": (
        '[charge]\ndiameter = "150 mm"',
        "mill.toml:3: charge.diameter: must be less than the chamber's 140 mm, got 150 mm",
    ),
    "shares that do not sum to one": (
        '[charge]\nsizes = [["3 mm", 0.3], ["5 mm", 0.5]]',
        "mill.toml:3: charge.sizes: the shares of the mass must sum to 1, got 0.8",
    ),
}


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_keys_that_contradict_each_other_are_named_with_the_cure(name):
    text, message = CONTRADICTIONS[name]
    line = refused(BASE + text)
    if message.startswith("numill-2026.toml: "):  # of the base, whose line numbers may change
        line = [":".join([line[0].split(":", 2)[0], line[0].split(":", 2)[2]]), *line[1:]]
    assert line == [message]


@pytest.mark.parametrize(
    ("key", "needs"),
    [
        ('stiffness = "direct"', "normal_stiffness"),
        ('damping = "ratio"', "damping_ratio"),
        ('tangential = "incremental_dashpot"', "tangential_damping"),
        ('rolling = "type_c_direct"', "rolling_stiffness"),
        ('cohesion = "area"', "cohesive_pressure"),
    ],
)
def test_the_number_that_a_contact_law_needs_is_asked_for_in_every_pair(key, needs):
    lines = refused(f"{BASE}[contact]\n{key}")
    assert [line.split(": ")[1] for line in lines] == [
        f"contact.pairs.{pair}.{needs}" for pair in ("steel-steel", "steel-acrylic")
    ]
    assert all(line.endswith(f"with contact.{key}. Add {needs} to the pair") for line in lines)


def test_a_film_asks_for_its_three_numbers_in_every_pair():
    lines = refused(f'{BASE}[contact]\nfilm = "viscous"')
    assert [line.split(": ")[1] for line in lines] == [
        f"contact.pairs.{pair}.{number}"
        for pair in ("steel-steel", "steel-acrylic")
        for number in ("liquid_viscosity", "film_thickness", "film_roughness")
    ]
    assert lines[0].endswith('is missing, with contact.film = "viscous". Add liquid_viscosity to the pair')


def test_bridges_ask_for_their_three_numbers_and_not_for_those_of_a_film():
    lines = refused(f'{BASE}[contact]\nfilm = "capillary"')
    assert [line.split(": ")[1] for line in lines] == [
        f"contact.pairs.{pair}.{number}"
        for pair in ("steel-steel", "steel-acrylic")
        for number in ("bridge_volume", "surface_tension", "contact_angle")
    ]


# the text ---------------------------------------------------------------------------------------------------

SYNTAX = {
    "unit without quotes": (
        "[charge]\ndiameter = 5 mm",
        'mill.toml:3:14: units need quotes. Write diameter = "5 mm"',
    ),
    "text without quotes": (
        "[charge]\nkind = spheres",
        'mill.toml:3:8: text needs quotes. Write kind = "spheres"',
    ),
    "no value": ("[charge]\ndiameter =", "mill.toml:3:11: no value after ="),
    "key twice": (
        '[charge]\nmass = "1 kg"\nmass = "2 kg"',
        "mill.toml:4:14: mass appears twice. Keep one of the two",
    ),
    "table twice": ("[charge]\n[run]\n[charge]", "mill.toml:4:8: charge appears twice. Keep one of the two"),
    "open bracket": ("[charge\n", "mill.toml:2:8: expected ']' at the end of a table declaration"),
}


@pytest.mark.parametrize("name", SYNTAX)
def test_a_slip_of_syntax_is_shown_with_line_and_column(name):
    text, message = SYNTAX[name]
    assert refused(BASE + text) == [message]


def test_all_faults_are_reported_at_once():
    lines = refused(
        f'{BASE}[drive]\nspeed = 700\n[charge]\ndiameter = "5 kg"\n[run]\nseed = -1',
        ["chamber.rib=3", "nothing"],
    )
    assert [line.split(": ")[0:2] for line in lines] == [
        ["--set", 'must be key=value, got "nothing". Write e.g. --set drive.speed="500 rpm"'],
        ["--set chamber.rib", "must be a table, got 3. Its keys"],
        ["mill.toml:3", "drive.speed"],
        ["mill.toml:5", "charge.diameter"],
        ["mill.toml:7", "run.seed"],
    ]


def test_a_fault_behind_lists_and_texts_of_many_lines_names_its_line():
    text = 'title = """\n[drive]\nspeed = 1\n"""\n[charge]\nsizes = [\n  ["3 mm", 1.0],  # [\n]\nmass = 3'
    assert refused(BASE + text) == [
        r"mill.toml:2: title: must be one line of at most 1000 characters without control characters, "
        r'got "[drive]\nspeed = 1\n"'
    ]
    # in one line it is no fault, and the line behind it is still right
    text = text.replace('"""\n[drive]\nspeed = 1\n"""', '"""[drive] speed = 1"""')
    assert refused(BASE + text) == [
        'mill.toml:7: charge.mass: needs a unit: write "3 kg" (a plain number is ambiguous)'
    ]


def test_the_message_of_an_empty_file_names_a_base():
    (line,) = refused("")
    assert line.startswith("mill.toml: lacks the tables [mechanism], [chamber]")
    assert line.endswith('Begin the file with base = "numill" and write what differs')


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            'base = "numil"',
            'mill.toml:1: base: no mill and no file is called "numil". Did you mean "numill"?',
        ),
        (
            'base = "mill.toml"',
            'mill.toml:1: base: "mill.toml" leads back to this file. Remove one base of the circle',
        ),
        (
            "base = 3",
            f"mill.toml:1: base: must be a name or a file, got 3. Known: {', '.join(library_names())}",
        ),
    ],
)
def test_a_base_that_is_none_is_refused(text, message):
    assert refused(text) == [message]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("numil", 'numil: no mill and no file has this name. Did you mean "numill"?'),
        ("mil.toml", 'mil.toml: file not found. Did you mean "mill.toml"?'),
        (".", ".: must be a case of a mill, got a folder. It is for: nutamill report ."),
    ],
)
def test_a_name_that_is_no_case_is_refused(name, message, tmp_path):
    (tmp_path / "mill.toml").write_text(BASE)
    with pytest.raises(CaseError) as error:
        load_case(name)
    assert str(error.value) == message


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "mill.toml").write_bytes(b"ok = 1\n\xff")
    with pytest.raises(CaseError, match=r"mill\.toml: must be UTF-8 text, got byte 0xff at 7"):
        load_case("mill.toml")


# the speed profile ------------------------------------------------------------------------------------------

HEAD = "time [s],speed [rpm]\n"
PROFILES = {
    "gap, NaN, sign": (
        f"{HEAD}0,0\n1,70\n2,\n3,nan\n4,-5\n",
        [
            'speed.csv:4: column "speed [rpm]" is empty. Interpolate or leave the row out',
            'speed.csv:5: column "speed [rpm]" must be a finite number, got "nan". Interpolate or '
            "leave the row out",
            'speed.csv:6: column "speed [rpm]" must be zero or more, got -5',
        ],
    ),
    "time stands still": (
        f"{HEAD}0,0\n1,70\n1,80\n",
        ["speed.csv:4: times must rise, got 1 s after 1 s. Sort the rows and let the time begin at 0"],
    ),
    "late start": (
        f"{HEAD}2,0\n3,70\n",
        ["speed.csv:2: must begin at 0 s, got 2 s. Sort the rows and let the time begin at 0"],
    ),
    "no header": (
        "0,0\n1,70\n",
        ['speed.csv:1: must name two columns with their units, got "0,0". Write "time [s],speed [rpm]"'],
    ),
    "unit of another kind": (
        "time [s],speed [Hz]\n0,0\n",
        [
            'speed.csv:1: must name two columns with their units, got "time [s],speed [Hz]". Write '
            '"time [s],speed [rpm]"'
        ],
    ),
    "decimal commas": (
        f"{HEAD}0,0\n1,5,70,2\n",
        ["speed.csv:3: must have 2 cells, got 4. Write numbers with a decimal point, cells apart by a comma"],
    ),
    "header only": (
        HEAD,
        ["speed.csv:1: needs at least two points, got 0. Sort the rows and let the time begin at 0"],
    ),
}


@pytest.mark.parametrize("name", PROFILES)
def test_a_wrong_speed_profile_is_refused_with_its_line(name, tmp_path):
    text, messages = PROFILES[name]
    (tmp_path / "speed.csv").write_text(text)
    assert refused(f'{BASE}[drive]\nprofile = "speed.csv"') == messages


def test_a_missing_speed_profile_is_refused_with_similar_names(tmp_path):
    (tmp_path / "speeds.csv").write_text(HEAD)
    (line,) = refused(f'{BASE}[drive]\nprofile = "speed.csv"')
    assert (
        line == f"mill.toml:3: drive.profile: speed.csv not found (looked in {tmp_path}). Similar: speeds.csv"
    )
