"""Every command on every machine of the package that is given part by part: it works, or says in one line
why it cannot.
"""

import math
import shutil
import types

import numpy as np
import pytest
from typer.testing import CliRunner

import nutamill as nm
from nutamill import cli
from nutamill.analysis.bearings import bearing_life, resting_axis, turns_per_second
from nutamill.analysis.load_paths import load_paths
from nutamill.analysis.orders import drive_angle
from nutamill.analysis.ratings import Bearing, load_ratings
from nutamill.analysis.values import reading_of
from nutamill.base.errors import CaseError, ResultError
from nutamill.base.library import library_file
from nutamill.case import load_case
from nutamill.case.machine import Machine
from nutamill.result import open_result
from nutamill.simulation import runs
from nutamill.simulation.setup.altered import supports, turning_drive
from nutamill.simulation.setup.quick import quick
from nutamill.studies.axes import members
from nutamill.studies.fit import read_fit
from nutamill.studies.measurand import refuse_unrecorded
from nutamill.studies.sweep_file import load_sweep

FEW = {
    "piston": ["charge.count=4"],
    "particle-damper": ["charge.count=4"],
    "tumbling-mill": ["charge.fill=0.002", "drives.motor.ramp=90000 rpm/s"],
    "vibratory-mill": ["charge.fill=0.002", "unbalance_motors.motor.ramp=9e5 rpm/s"],
    "planetary-mill": ["charge.part.0.count=2", "charge.part.1.count=2", "drives.motor.ramp=90000 rpm/s"],
}
"""The machines, and what leaves few balls in them."""
DRIVEN = ("tumbling-mill", "vibratory-mill", "planetary-mill")
"""Those that a drive turns."""
TINY = ["run.until=40 ms", 'run.snapshots={ rate = "100 Hz", last = "40 ms" }', "run.threads=1"]
RATED = {"tumbling-mill": "bearings", "vibratory-mill": "motor", "planetary-mill": "jar_1_bearing"}
"""Machines with a bearing."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run of 40 ms of each machine, and ratings."""
    place = tmp_path_factory.mktemp("machines")
    for name, few in FEW.items():
        runs.run(load_case(name, [*few, *TINY]), place / f"{name}.h5").close()
        rated = RATED.get(name, "guide")
        text = f'schema = 1\n[bearings.{rated}]\nkind = "ball"\ndynamic_rating = "10 kN"\n'
        (place / f"{name}-ratings.toml").write_text(text)
    return place


@pytest.fixture
def invoke(folder, monkeypatch):
    """Run a command in the folder with the results."""
    monkeypatch.chdir(folder)
    return lambda *words: CliRunner().invoke(cli.app, words)


WORKS = [
    ("show", "{name}"),
    ("show", "{name}.h5"),
    ("verify", "{name}.h5"),
    ("new", "{name}-new.toml", "--from", "{name}"),
    ("plot", "{name}.h5", "run", "power"),
    ("view", "{name}.h5"),
    ("export", "vtkhdf", "{name}.h5"),
    ("loads", "{name}.h5"),
    ("wear", "{name}.h5", "--hardness", "6 GPa", "--coefficient", "1e-4"),
]
"""Commands that answer on every machine."""


@pytest.mark.parametrize("name", FEW)
@pytest.mark.parametrize("words", WORKS, ids=lambda words: words[0])
def test_a_command_that_asks_for_no_mill_answers_on_every_machine(invoke, name, words):
    answer = invoke(*(word.format(name=name) for word in words))
    assert answer.exit_code == 0, answer.output
    assert answer.stdout.strip()


@pytest.mark.parametrize("name", FEW)
def test_a_moment_of_a_machine_is_too_short_to_grind_by_as_one_line_states(invoke, name):
    answer = invoke("breakage", f"{name}.h5", "--ore", "smc-sample-a")
    assert answer.exit_code == 2 and answer.stderr.count("\n") == 1
    assert answer.stderr.startswith(f"{name}.h5: ")


@pytest.mark.parametrize("name", ["piston", "planetary-mill"])
def test_a_report_of_a_machine_has_its_figures_and_its_view(invoke, folder, name):
    answer = invoke("report", f"{name}.h5", "--to", f"{name}.html")
    assert answer.exit_code == 0, answer.output
    page = (folder / f"{name}.html").read_text(encoding="utf-8")
    assert page.count("<figure>") >= 3 and "<iframe" in page


@pytest.mark.parametrize("name", ["piston", "planetary-mill"])
def test_a_resumed_machine_ends_with_the_bits_of_a_whole_run(invoke, folder, name):
    # the piston's crown has moved away from where it was assembled, past the balls' first places
    shutil.copy(folder / f"{name}.h5", folder / f"{name}-longer.h5")
    answer = invoke("resume", f"{name}-longer.h5", "--until", "60 ms")
    assert answer.exit_code == 0, answer.output
    case = load_case(name, [*FEW[name], *TINY, "run.until=60 ms"])
    runs.run(case, folder / f"{name}-whole.h5").close()
    with (
        open_result(folder / f"{name}-longer.h5") as longer,
        open_result(folder / f"{name}-whole.h5") as whole,
    ):
        assert longer.series.equals(whole.series)


@pytest.mark.parametrize("name", FEW)
def test_a_sweep_and_a_fit_begun_from_a_machine_name_what_it_has(invoke, folder, name):
    for kind in ("sweep", "fit"):
        assert invoke("new", f"{kind}-{name}.toml", "--kind", kind, "--from", name).exit_code == 0
    case, fixed, axes, readings = load_sweep(str(folder / f"sweep-{name}.toml"))
    planned = members(
        axes, lambda values: load_case(case, [*fixed, *(f"{k}={v}" for k, v in values.items())])
    )
    assert len(planned) == 2 and planned[0].case.digest != planned[1].case.digest
    refuse_unrecorded([reading_of(text) for text in readings], [planned[0].case.machine], "readings")
    read_fit(folder / f"fit-{name}.toml")


def test_a_swept_machine_reads_its_own_series_and_refuses_others(invoke, folder):
    text = 'case = "piston"\nreadings = ["{}"]\n[set]\n"charge.count" = 4\n"run.until" = "20 ms"\n'
    text += '[sweep]\n"bodies.piston.mass" = ["100 g", "200 g"]\n'
    (folder / "masses.toml").write_text(text.format("driveshaft_torque"))
    refused = invoke("sweep", "masses.toml")
    assert refused.exit_code == 2 and not (folder / "sweeps").exists()
    assert 'readings: the machine records no series "driveshaft_torque"' in refused.stderr
    (folder / "masses.toml").write_text(text.format("swing piston_position_z"))
    answer = invoke("sweep", "masses.toml")
    assert answer.exit_code == 0, answer.output
    table = (folder / "sweeps/masses/table.csv").read_text()
    assert "piston_position_z" in table and "nan" not in table


def test_the_fields_of_a_machine_are_the_series_of_its_run(invoke, folder):
    of_case, of_file = (invoke("info", "fields", name).stdout for name in ("piston", "piston.h5"))
    assert of_case == of_file and "piston_position_z" in of_case and "driveshaft" not in of_case


def test_a_test_of_any_machine_is_imported_and_compared_with_its_run(invoke, folder):
    # the run itself as measured data: every error is that of the printed digits
    (folder / "turned.toml").write_text('schema = 1\nbase = "tumbling-mill"\n[run]\nperiod = "motor"\n')
    for name, series in (("tumbling-mill", "drive_motor_torque"), ("piston", "piston_position_z")):
        with open_result(folder / f"{name}.h5") as result:
            values = result.series[series].values.tolist()
            rows = list(zip(result.series["time"].values.tolist(), values, strict=True))
            unit = result.field(series).unit
        (folder / "test.csv").write_text("t,a\n" + "".join(f"{t!r},{v!r}\n" for t, v in rows))
        case = "turned.toml" if name == "tumbling-mill" else name
        text = f'case = "{case}"\ntime = "t"\nspeed = "470 rpm"\n[channel.{series}]\ncolumn = "a"\n'
        (folder / "map.toml").write_text(f'{text}unit = "{unit}"\n')
        imported = invoke("import", "test.csv", "--map", "map.toml", "--to", f"{name}-test.h5")
        assert imported.exit_code == 0, imported.output
        with open_result(folder / f"{name}-test.h5") as test:
            assert np.allclose(test.series[series], values, rtol=1e-12, atol=1e-15)
            assert ("drive_motor_angle" in test.series) == (name == "tumbling-mill")
    compared = invoke("compare", "piston.h5", "piston-test.h5")
    assert compared.exit_code == 0, compared.output
    assert "piston position, z (m)" in compared.stdout and "+0.0 %" in compared.stdout


NO_DRIVE = "no drive turns this machine"
ON_BUSHINGS = "must stand on bushings"
STILL = "modes: nothing is free to vibrate with the drives held"
ROTOR = "turns a rotor of its own, to which no balance mass can be added"
UNDRIVEN, BOLTED = ("piston", "particle-damper"), ("tumbling-mill", "planetary-mill")
LACKING = [
    (("campbell", "{name}"), {**dict.fromkeys(UNDRIVEN, NO_DRIVE), **dict.fromkeys(BOLTED, STILL)}),
    (
        ("modes", "{name}", "--speed", "100 rpm"),
        {**dict.fromkeys(UNDRIVEN, NO_DRIVE), **dict.fromkeys(BOLTED, STILL)},
    ),
    (("isolation", "{name}"), dict.fromkeys((*UNDRIVEN, *BOLTED), ON_BUSHINGS)),
    (
        ("balance", "{name}", "--plane", "80 mm, 100 mm"),
        {
            **dict.fromkeys(UNDRIVEN, NO_DRIVE),
            **dict.fromkeys(BOLTED, ON_BUSHINGS),
            "vibratory-mill": ROTOR,
        },
    ),
    (("run", "{name}", "--quick"), dict.fromkeys(UNDRIVEN, NO_DRIVE)),
    (("modes", "{name}", "--charge"), dict.fromkeys(FEW, "chamber.bars: is missing")),
    (("plot", "{name}.h5", "orbit"), dict.fromkeys(FEW, "has no crank, with which the axes of this answer")),
    (
        ("loads", "{name}.h5", "--axes", "moon"),
        dict.fromkeys(FEW, "axes moon: must be those of a body whose attitude is recorded"),
    ),
]
"""Commands about what a machine may lack, and what they answer where it does."""
REFUSED = [(words, name, reason) for words, by_name in LACKING for name, reason in by_name.items()]


@pytest.mark.parametrize(("words", "name", "reason"), REFUSED, ids=lambda value: "-".join(value[::2])[:12])
def test_a_command_about_what_a_machine_lacks_says_so_in_one_line(invoke, words, name, reason):
    answer = invoke(*(word.format(name=name) for word in words))
    assert answer.exit_code != 0 and not isinstance(answer.exception, (KeyError, ValueError, TypeError))
    assert answer.stderr.count("\n") == 1 and reason in answer.stderr


@pytest.mark.parametrize(
    "words", [("modes", "--speed", "900 rpm"), ("isolation",)], ids=lambda words: words[0]
)
def test_a_mill_on_springs_of_rubber_has_modes_at_speed_and_isolation(invoke, words):
    answer = invoke(words[0], "vibratory-mill", *words[1:])
    assert answer.exit_code == 0, answer.output


@pytest.mark.parametrize(("name", "ramp"), [("tumbling-mill", "4 rpm/s"), ("vibratory-mill", "2000 rpm/s")])
def test_a_machine_with_a_drive_has_a_run_up(invoke, name, ramp):
    answer = invoke("runup", name, "--ramp", ramp)
    assert answer.exit_code == 0 and "1x" in answer.stdout


@pytest.mark.parametrize("name", DRIVEN)
def test_the_demonstration_of_a_machine_has_a_short_ramp_and_no_bushings(name):
    short = quick(load_case(name, FEW[name][:1]))
    assert short.run.until < 3.5 / (turning_drive(short).speed / math.tau) + 0.2
    assert turning_drive(short).ramp_end == pytest.approx(0.2)
    assert not supports(short) and short.title.startswith(f"demonstration of {name}: ")


@pytest.mark.parametrize("name", FEW)
def test_the_force_on_the_floor_is_read_from_what_connects_a_machine_with_the_ground(invoke, name):
    answer = invoke("mounts", f"{name}.h5")
    if name in ("piston", "particle-damper"):  # their springs are not
        assert "whose force on it in world axes is not known" in answer.stderr
    else:
        assert answer.exit_code == 0, answer.output
        assert "force on the floor (N)" in answer.stdout


def test_answers_in_python_take_a_machine_or_say_why_not():
    piston = nm.load_case("piston", ["charge.kind=none"])
    assert nm.check(piston).lines()[1].startswith("bodies    1, 0.2 kg in all")
    # 0.2 kg on 2 N/mm
    assert nm.machine_modes(piston).frequency == pytest.approx([math.sqrt(2000.0 / 0.2) / (2.0 * math.pi)])
    with pytest.raises(CaseError, match="modes: nothing is free to vibrate with the drives held"):
        nm.machine_modes(nm.load_case("planetary-mill", ["charge.kind=none"]))
    with pytest.raises(CaseError, match="piston: no drive turns this machine"):
        nm.run_up(piston, [1.0])


@pytest.mark.parametrize("name", FEW)
def test_orders_and_lives_need_a_drive(invoke, name):
    orders = invoke("orders", f"{name}.h5")
    life = invoke("life", f"{name}.h5", f"{name}-ratings.toml")
    if name in DRIVEN:
        # 40 ms hold less than the four turns that an order is taken of
        assert "must have 4 turns of the drive" in orders.stderr
        if name == "vibratory-mill":  # its motor sways with the tube
            assert "its axis turns with tube and motor, whose attitudes are not recorded" in life.stderr
        else:
            assert life.exit_code == 0 and "L10 (h)" in life.stdout
    else:
        assert "no drive of this machine turns" in orders.stderr
        assert life.exit_code == 2 and life.stderr.count("\n") == 1


def test_the_load_of_a_joint_without_a_drive_has_no_orders(folder):
    with open_result(folder / "piston.h5") as result:
        guide = load_paths(result).sel(joint="guide", axes="ground", part="force")
    assert np.isfinite(guide.sel(statistic=["mean", "rms", "peak"])).all()
    assert np.isnan(guide.sel(statistic="1x"))


def test_the_bearing_of_a_jar_turns_by_the_ratio_of_its_belt(folder):
    # -2 : 1 from the sun, whose bearing has the drive: twice as often, and its axis stays upright
    bearing = Bearing(kind="ball", dynamic_rating=1e4)
    with open_result(folder / "planetary-mill.h5") as result:
        machine = load_case("planetary-mill")
        sun, jar = (turns_per_second(result, f"{name}_bearing", bearing) for name in ("sun", "jar_1"))
        axes, axis = resting_axis(result, machine.joints[1])
    assert jar == pytest.approx(2.0 * sun) and sun > 0.0
    assert axes == "ground" and axis == pytest.approx([0.0, 0.0, 1.0])


def test_life_of_a_bearing_is_that_of_the_mean_of_the_load_to_the_third(folder):
    with open_result(folder / "tumbling-mill.h5") as result:
        life = bearing_life(result, "bearings", load_ratings(folder / "tumbling-mill-ratings.toml", result))
        force = np.column_stack([result.series[f"joint_bearings_force_{axis}"] for axis in "xyz"])
    # without axial factor the load is the radial one; at rest already the weight of the drum, steady to 1 %
    axial = np.asarray(load_case("tumbling-mill").joints[0].axis)
    radial = np.linalg.norm(force - (force @ axial)[:, None] * axial / (axial @ axial), axis=1)
    assert life.turns == pytest.approx(1e6 * (1e4 / np.mean(radial)) ** 3, rel=0.03)
    assert math.isfinite(life.time)


def test_a_bearing_whose_axis_nothing_recorded_keeps_is_refused_with_the_sensor_to_add(folder):
    machine = load_case("planetary-mill")
    tilted = machine.joints[1].model_copy(update={"axis": (1.0, 0.0, 0.0)})
    message = r"its axis turns with sun and jar_1.*Add \[\[sensors\]\]"
    with open_result(folder / "planetary-mill.h5") as result, pytest.raises(CaseError, match=message):
        resting_axis(result, tilted)


def test_of_several_drives_one_must_be_chosen():
    text = library_file("planetary-mill").read_text(encoding="utf-8")
    second = '[[drives]]\nname = "second"\njoint = "jar_1_bearing"\nspeed = "1 rpm"\nramp = "1 rpm/s"\n'
    series = {"drive_motor_angle": [], "drive_second_angle": []}
    result = types.SimpleNamespace(path="a.h5", case_text=text + second, series=series)
    with pytest.raises(
        ResultError, match=r"several drives turn: motor, second. Choose one with --drive NAME"
    ):
        drive_angle(result)
    assert drive_angle(result, "second") == "drive_second_angle"
    with pytest.raises(CaseError, match=r'no drive is called "secnd". Did you mean "second"'):
        drive_angle(result, "secnd")


def test_a_quantity_whose_unit_no_key_has_is_no_target_of_a_fit(tmp_path):
    (tmp_path / "a.toml").write_text(
        'schema = 1\nbase = "piston"\n[[quantities]]\nname = "odd"\ntake = "product"\n'
        'of = ["piston_position_z", "piston_position_z"]\n'
    )
    (tmp_path / "fit.toml").write_text(
        'case = "a.toml"\n[free."bodies.piston.mass"]\nstart = "0.2 kg"\nlow = "0.1 kg"\n'
        'high = "1 kg"\n[[target]]\nquantity = "odd"\nvalue = "1 mm"\nuncertainty = "1 mm"\n'
    )
    with pytest.raises(CaseError, match=r"has a unit that no key has, m\*m. Take one of its factors"):
        read_fit(tmp_path / "fit.toml")


@pytest.mark.parametrize("name", FEW)
def test_a_file_begun_from_a_machine_is_that_machine(invoke, folder, name):
    assert invoke("new", f"again-{name}.toml", "--from", name).exit_code == 0
    begun, base = (load_case(one).with_("title", "") for one in (folder / f"again-{name}.toml", name))
    assert isinstance(begun, Machine)
    assert begun.with_("title", "").to_toml() == base.with_("title", "").to_toml()
