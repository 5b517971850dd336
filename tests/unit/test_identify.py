"""Identification: emulators, posterior and indices against closed forms, and files from faults to results."""

import json
from pathlib import Path

import numpy as np
import pytest

from nutamill.analysis.measured_import import import_test
from nutamill.analysis.values import Reading
from nutamill.base.errors import CaseError
from nutamill.base.steady import Estimate
from nutamill.case import load_case
from nutamill.studies.identify import identify as room
from nutamill.studies.identify import members as ran
from nutamill.studies.identify.emulator import emulator_of_draws, fit_emulator
from nutamill.studies.identify.identification import identification_of
from nutamill.studies.identify.indices import settled, total_effects
from nutamill.studies.identify.inputs import Inputs
from nutamill.studies.identify.points import _file
from nutamill.studies.identify.posterior import Evidence, implausibility, sample_posterior
from nutamill.studies.identify.problem import read_problem
from nutamill.studies.identify.sample import filling_points, points_left
from nutamill.studies.table import Outcome

EXAMPLES = Path(__file__).parents[2] / "examples"
NO_GAINS = np.array([], dtype=int), np.zeros((0, 2))
TORQUE = Reading("driveshaft_torque")


class Formula:
    """A closed form in place of an emulator."""

    def __init__(self, function, error=0.0):
        self.function, self.error = function, error

    def predict(self, points):
        return self.function(points), np.full(len(points), self.error)


def emulated(function, count, unknowns=2, doubt=0.0):
    points = filling_points(unknowns, count, 3)
    return fit_emulator(points, function(points), Inputs(np.eye(unknowns)), *NO_GAINS, "row", doubt)


def wave(points):
    return 5.0 + np.sin(3.0 * points[:, 0]) * (1.0 + points[:, 1])


def test_emulator_of_a_smooth_row_is_near_it_and_knows_how_near():
    emulator = emulated(wave, 30)
    there = np.random.default_rng(1).random((500, 2))
    mean, error = emulator.predict(there)
    off = np.abs(mean - wave(there))
    assert off.max() < 0.01 * np.ptp(wave(there))
    assert np.mean(off < 3.0 * error) > 0.95
    assert emulator.check.error < 0.05 * emulator.check.spread


def test_row_with_a_resonance_is_emulated_by_its_logarithm():
    def resonant(points):
        return 1.0 / np.hypot(1.0 - (0.5 + 0.7 * points[:, 0]) ** 2, 0.05) * (1.0 + points[:, 1])

    there = np.random.default_rng(1).random((500, 2))
    emulator = emulated(resonant, 60)
    mean, error = emulator.predict(there)
    off = np.abs(mean - resonant(there)) / resonant(there)
    assert emulator.logarithmic and np.median(off) < 0.01
    assert np.mean(np.abs(mean - resonant(there)) < 3.0 * error + 1e-6) > 0.9
    assert not emulated(wave, 30).logarithmic


def test_gain_multiplies_a_row_without_a_run_of_its_own():
    points = filling_points(2, 20, 3)
    alone = Inputs(np.array([[1.0], [0.0]])), np.array([1]), np.array([[0.5, 1.5]])
    emulator = fit_emulator(points, 4.0 + points[:, 0], *alone, "row", 0.0)
    mean, _ = emulator.predict(np.array([[0.3, 0.0], [0.3, 1.0]]))
    assert mean == pytest.approx([0.5 * 4.3, 1.5 * 4.3], rel=1e-4)


def test_what_the_inputs_leave_out_is_part_of_the_error():
    points = filling_points(2, 60, 3)
    seen = Inputs(np.array([[1.0], [0.0]]))
    emulator = fit_emulator(
        points, 4.0 + points[:, 0] + 0.3 * points[:, 1], seen, *NO_GAINS, "row", 0.0, True
    )
    mean, error = emulator.predict(points)
    # the other unknown is even over a width of 0.3: 0.3/12^0.5, known from 60 members within some 20 %
    assert error.mean() == pytest.approx(0.3 / 12.0**0.5, rel=0.2)
    assert mean == pytest.approx(4.15 + points[:, 0], abs=0.06)


def test_row_is_emulated_through_a_row_of_an_earlier_stage():
    # twelve members cannot separate eight unknowns, but follow the one number that these make
    weights = np.linspace(0.5, 1.5, 8)
    earlier = emulated(lambda points: points @ weights, 60, 8)
    points = filling_points(8, 12, 5)
    through = Inputs(np.zeros((8, 0)), (earlier.score,))
    emulator = fit_emulator(points, (points @ weights) ** 2, through, *NO_GAINS, "row", 0.0, True)
    there = np.random.default_rng(1).random((200, 8))
    mean, _ = emulator.predict(there)
    assert np.abs(mean - (there @ weights) ** 2).max() < 0.02 * np.ptp((there @ weights) ** 2)


def test_row_that_depends_on_no_unknown_is_refused():
    with pytest.raises(CaseError, match="row: the row depends on no unknown: all of 20 members give 7"):
        emulated(lambda points: np.full(len(points), 7.0), 20)


def test_emulator_that_fails_its_check_is_refused_unless_its_error_does_no_harm():
    def noise(points):
        return np.random.default_rng(5).standard_normal(len(points))

    with pytest.raises(CaseError, match="the emulator does not predict the members that are left out"):
        emulated(noise, 20)
    assert emulated(noise, 20, doubt=10.0).check.error > 0.5


def test_implausibility_counts_all_three_errors():
    rows = [Evidence(Formula(lambda points: points[:, 0], error=3.0), 10.0, 4.0)]
    assert implausibility(rows, np.zeros((1, 1))) == pytest.approx(10.0 / 5.0)


def test_posterior_of_a_linear_row_is_its_normal():
    rows = [Evidence(Formula(lambda points: 10.0 * points[:, 0]), 5.0, 0.5)]
    posterior = sample_posterior(rows, 1, 1)
    assert posterior.converged
    # standard deviation 0.5/10; a chain of fifty memories of 32 walkers knows it within a few per cent
    assert posterior.points.mean() == pytest.approx(0.5, abs=0.005)
    assert posterior.points.std() == pytest.approx(0.05, rel=0.06)
    assert posterior.mode == pytest.approx(0.5, abs=1e-3)


def test_points_of_a_later_stage_are_those_that_are_left_and_far_apart():
    def plausible(points):
        return points[:, 0] < 0.25

    chosen = points_left(2, np.arange(2), 20, 1, plausible, "later", Inputs(np.eye(2)))
    assert plausible(chosen).all()
    apart = np.linalg.norm(chosen[:, None] - chosen[None], axis=2) + 9.0 * np.eye(20)
    assert apart.min() > 0.08  # twenty points of an even grid over 0.25 x 1 are 0.11 apart
    # one point in 2000: twenty are not among the first 32768, and are looked for further on
    scarce = points_left(
        2, np.arange(2), 20, 1, lambda points: points.max(axis=1) < 2000.0**-0.5, "later", Inputs(np.eye(2))
    )
    assert len(scarce) == 20 and scarce.max() < 2000.0**-0.5
    with pytest.raises(CaseError, match="stage later: the rows before it rule out all but 0 of 524288"):
        points_left(2, np.arange(2), 20, 1, lambda points: points[:, 0] < 0.0, "later", Inputs(np.eye(2)))


def test_total_effects_are_those_of_ishigami():
    def ishigami(points):
        x = np.pi * (2.0 * points - 1.0)
        return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    # T. Ishigami, T. Homma, ISUMA '90: a = 7, b = 0.1
    effects = total_effects([Formula(ishigami)], 3, 1)
    assert effects[0] == pytest.approx([0.5576, 0.4424, 0.2437], abs=0.03)


def test_measurement_settles_what_a_normal_posterior_leaves_open():
    points = np.random.default_rng(1).normal(0.5, 0.1, (4000, 2))
    shares = settled([Formula(lambda points: 2.0 * points[:, 0])], [0.2], points)
    assert shares[0] == pytest.approx([0.5, 0.0], abs=0.02)  # 4 x 0.01 of signal, 0.04 of noise


SPRING = """
schema  = 1
bodies  = [{ name = "bob", mass = "1 kg", inertia = ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"], position = ["0 m", "0 m", "0 m"] }]
joints  = [{ name = "guide", kind = "prismatic", between = ["ground", "bob"], point = ["0 m", "0 m", "0 m"], axis = [0, 0, 1] }]
springs = [
  { name = "spring", between = ["ground", "bob"], point_a = ["0 m", "0 m", "-1 m"], point_b = ["0 m", "0 m", "0 m"], stiffness = "1 N/mm", damping = "0 N s/m", free_length = "1 m" },
  { name = "known", between = ["ground", "bob"], point_a = ["0 m", "0 m", "-1 m"], point_b = ["0 m", "0 m", "0 m"], stiffness = "1 N/mm", damping = "0 N s/m", free_length = "1 m" },
]
gravity = ["0 m/s^2", "0 m/s^2", "0 m/s^2"]
[run]
until = "1 s"
"""  # noqa: E501
ON_A_SPRING = """
case = "spring.toml"
[unknown.mass]
keys = ["bodies.bob.mass"]
low = "0.5 kg"
high = "2 kg"
reason = "not weighed"
[unknown.stiffness]
keys = ["springs.spring.stiffness"]
low = "0.5 N/mm"
high = "4 N/mm"
reason = "a catalogue of springs"
[[stage]]
name = "modes"
members = 24
[[learn]]
quantity = "natural_frequency 1"
value = "{soft} Hz"
scatter = "0.05 Hz"
discrepancy = "0 Hz"
[[learn]]
quantity = "natural_frequency 1"
value = "{stiff} Hz"
scatter = "0.05 Hz"
discrepancy = "0 Hz"
set = {{ "springs.known.stiffness" = "3 N/mm" }}
[[predict]]
quantity = "natural_frequency 1"
value = "{predicted} Hz"
set = {{ "springs.known.stiffness" = "2 N/mm" }}
"""


def test_mass_on_a_spring_is_identified_from_its_frequencies(tmp_path):
    mass, stiffness = 1.2, 1700.0

    def frequency(known):
        return np.sqrt((stiffness + known) / mass) / (2.0 * np.pi)

    (tmp_path / "spring.toml").write_text(SPRING)
    measured = {"soft": frequency(1000.0), "stiff": frequency(3000.0), "predicted": frequency(2000.0)}
    (tmp_path / "twin.toml").write_text(ON_A_SPRING.format(**measured))
    done = room.identify(tmp_path / "twin.toml", tmp_path / "out")
    (low_mass, _, high_mass), (low, _, high) = done.unknowns
    assert low_mass < mass < high_mass and low < stiffness < high
    assert done.problem.values(done.posterior.mode) == pytest.approx([mass, stiffness], rel=0.02)
    assert done.inside == [True, True, True]
    assert (done.posterior_rows[2][2] - done.posterior_rows[2][0]) < 0.2 * np.diff(done.prior_rows[2][[0, 2]])
    machine = load_case(tmp_path / "out" / "spring.toml")
    assert machine.bodies[0].mass == pytest.approx(mass, rel=0.02)
    stored = json.loads((tmp_path / "out" / "identify.json").read_text())
    assert stored["rows"][2]["inside"] is True
    assert {file.name for file in done.files} == {
        "identify.md", "identify.json", "corner.png", "rows.png", "spring.toml",
    }  # fmt: skip
    text = "\n".join(done.lines())
    assert "1 of 1 predicted rows are inside their 90 % interval" in text


FILE = """
case = "numill"
[set]
"charge.kind" = "none"
"mechanism.mounting" = "rigid"
[unknown.friction]
keys = ["mechanism.joint_friction"]
low = 0.0
high = 0.1
reason = "bearings"
[unknown.gain]
gain_of = ["driveshaft_torque"]
low = 0.9
high = 1.1
reason = "the instrument"
campaign = "second"
[[stage]]
name = "cheap"
members = 8
[[stage]]
name = "dear"
members = 6
[[learn]]
quantity = "driveshaft_torque"
value = "0.35 N m"
scatter = "20 N mm"
discrepancy = "0 N m"
[[predict]]
quantity = "driveshaft_torque"
value = "0.9 N m"
scatter = "20 N mm"
set = { "drive.speed" = "600 rpm" }
campaign = "second"
stages = ["dear"]
"""


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """A file of the empty mill, and runs replaced by a torque of friction times speed."""
    path = tmp_path / "file.toml"
    path.write_text(FILE)
    asked = []

    def run_all(planned, folder, workers, readings, report, log):
        asked.append(planned)

        def torque(case):
            return Estimate(0.1 * case.mechanism.joint_friction * case.drive.speed, 0.0, 0.0, 9, True)

        return [Outcome(one, folder, "complete", {TORQUE: torque(one.case)}) for one in planned]

    monkeypatch.setattr(ran, "run_all", run_all)
    return path, asked


def test_later_stage_runs_only_what_is_not_ruled_out_and_a_repeated_call_asks_for_the_same(bench, tmp_path):
    path, asked = bench
    problem = read_problem(path)
    emulators, refused = room.learn(problem, tmp_path, lambda: None)
    # 0.35 +- 0.02 N m at 700 rpm: three standard deviations are friction of 0.040 to 0.056
    frictions = [one.case.mechanism.joint_friction for one in asked[1]]
    assert len(asked[0]) == 8 and len(frictions) == 6 and refused == 0
    assert 0.039 < min(frictions) < max(frictions) < 0.057
    room.learn(problem, tmp_path, lambda: None)
    assert len(asked) == 2  # values of all runs are stored
    (tmp_path / "values.json").unlink()
    room.learn(problem, tmp_path, lambda: None)
    assert [one.case.digest for one in asked[2] + asked[3]] == [
        one.case.digest for one in asked[0] + asked[1]
    ]
    table = (tmp_path / "members-1.csv").read_text().splitlines()
    assert table[0] == 'friction (1),"driveshaft torque (N m)"'.replace('"', "") and len(table) == 9
    done = identification_of(problem, emulators)
    # the predicted row is 0.35 x 6/7 = 0.30 N m, and 0.69 N m at most over the ranges
    assert done.posterior_rows[1][1] == pytest.approx(0.30, abs=0.02)
    assert done.inside == [True, False]
    text = "\n".join(done.lines())
    assert "0 of 1 predicted rows" in text and "600 rpm: no value in the ranges reaches the" in text
    assert room.machine_at_mode(done).mechanism.joint_friction == pytest.approx(0.0477, abs=0.001)


def test_draws_of_the_posterior_predict_as_they_are(bench, tmp_path):
    path, asked = bench
    path.write_text(FILE.replace("members = 6", "members = 6\ndraws = true"))
    problem = read_problem(path)
    emulators, _ = room.learn(problem, tmp_path, lambda: None)
    # 0.35 +- 0.02 N m at 700 rpm: friction of 0.048 +- 0.0027
    frictions = np.array([one.case.mechanism.joint_friction for one in asked[1]])
    assert (
        len(frictions) == 6 and np.all(np.abs(frictions - 0.0477) < 5.0 * 0.0027) and np.ptp(frictions) > 0.0
    )
    mean, _ = emulators[1].predict(np.zeros((1, 2)))
    assert mean == pytest.approx(0.30, abs=0.05)  # of 600 rpm, with gains of 0.9 to 1.1
    done = identification_of(problem, emulators)
    assert done.inside == [True, False] and np.isnan(done.least[1])
    assert "| 6 draws" in "\n".join(done.lines())
    stored = json.loads(room.json_text(done))["rows"][1]
    assert (stored["draws"], stored["prior_90"]) == (6, None)
    room.learn(problem, tmp_path, lambda: None)
    assert len(asked) == 2
    file = next(tmp_path.glob("points-2-*.json"))
    file.write_text("[[0.1]]")
    with pytest.raises(CaseError, match=r"holds no points of a stage .* Delete it and repeat the command"):
        room.learn(problem, tmp_path, lambda: None)


def test_stage_that_names_what_is_active_needs_members_for_that_only(bench, tmp_path):
    path, _ = bench
    idle = '[unknown.mass]\nkeys = ["carriage.mass"]\nlow = "0.1 kg"\nhigh = "1 kg"\nreason = "a"\n'
    idle += 'stages = ["dear"]\n'
    both = FILE.replace("[[stage]]", f"{idle}[[stage]]", 1)
    path.write_text(both)
    with pytest.raises(CaseError, match="too few members for the number of unknowns, got 6 for 2"):
        read_problem(path)
    path.write_text(both.replace("members = 6", 'members = 6\nactive = ["driveshaft torque"]'))
    problem = read_problem(path)
    emulators, _ = room.learn(problem, tmp_path, lambda: None)
    # torque goes with friction times speed, and so with the torque of the stage before it
    mean, _ = emulators[1].predict(np.array([[0.5, 0.5, 0.0], [0.5, 0.5, 1.0]]))
    slow, _ = emulators[0].predict(np.array([[0.5, 0.5, 0.0]]))
    assert mean == pytest.approx(slow[0] * 6.0 / 7.0, rel=1e-3)
    path.write_text(both.replace("members = 6", 'members = 6\nactive = ["mess"]\ndraws = true'))
    with pytest.raises(CaseError) as raised:
        read_problem(path)
    assert 'a row of earlier stages, got "mess". Unknowns: friction, mass' in str(raised.value)
    assert "active: has no use with draws" in str(raised.value)


def test_row_to_predict_is_learned_from_where_it_is_asked(bench, tmp_path):
    path, _ = bench
    path.write_text(FILE.replace("[[predict]]", '[[predict]]\ntitle = "fast"\ndiscrepancy = "0 N m"'))
    before, after = read_problem(path), read_problem(path, None, ["fast"])
    assert [row.learned for row in before.rows] == [True, False]
    assert [row.learned for row in after.rows] == [True, True]
    with pytest.raises(
        CaseError, match=r'--learn: must be the title of a row to predict, got "fat"\. Titles: fast'
    ):
        read_problem(path, None, ["fat"])
    path.write_text(path.read_text().replace('title = "fast"\ndiscrepancy = "0 N m"', 'title = "fast"'))
    with pytest.raises(CaseError, match="must state what is learned from it, lacks discrepancy"):
        read_problem(path, None, ["fast"])


def test_few_draws_have_the_interval_of_student():
    # s = 1.29099, t(3) = 2.35336 at 95 %, z = 1.64485: s (1 + 1/4)^0.5 t/z
    emulator = emulator_of_draws(np.array([1.0, 2.0, 3.0, 4.0, np.nan]), 2)
    mean, error = emulator.predict(np.zeros((1, 2)))
    assert (mean[0], error[0]) == (2.5, pytest.approx(2.0651, rel=1e-4))


def test_members_that_the_drawing_cannot_hold_are_refused_one_by_one_and_counted(bench, tmp_path):
    path, asked = bench
    text = FILE.replace("mechanism.joint_friction", "mechanism.total_mass")
    path.write_text(text.replace("low = 0.0\nhigh = 0.1", 'low = "5 kg"\nhigh = "100 kg"'))
    log = []
    room.run_members(
        read_problem(path), "cheap", np.array([[x, 0.5] for x in np.linspace(0.0, 1.0, 12)]), tmp_path,
        lambda: None, log=log.append,
    )  # fmt: skip
    held = len(asked[0])
    assert 5 <= held < 12
    assert log[0] == f"stage cheap: {12 - held} of 12 members refused"
    assert sum(int(line.split(" x ")[0]) for line in log[1:]) == 12 - held
    with pytest.raises(CaseError, match="the drawing cannot hold 6 of 6 members, 1 unknowns need 5"):
        room.run_members(read_problem(path), "cheap", np.zeros((6, 2)), tmp_path, lambda: None)


def test_a_machine_that_no_drawing_can_have_is_refused_as_a_member(bench):
    path, _ = bench
    text = FILE.replace("mechanism.joint_friction", "frame.gyration_rocking")
    path.write_text(text.replace("low = 0.0\nhigh = 0.1", 'low = "10 mm"\nhigh = "260 mm"'))
    problem = read_problem(path)
    with pytest.raises(CaseError, match="leave the frame moments of inertia"):
        problem.case_at(problem.rows[0], np.zeros(2))
    problem.case_at(problem.rows[0], np.ones(2))


def test_refused_members_are_counted_by_reason_whatever_the_numbers_in_it():
    log = []
    reasons = [f"chamber: must exceed m x d^2 = 0.{k} kg m^2, got {k} kg m^2" for k in range(3)]
    ran._log_reasons(reasons, "stage a", "of 9 members refused", log.append)
    assert log == ["stage a: 3 of 9 members refused", "  3 x chamber: must exceed m x d^2 = ... kg m^2"]


def test_a_sum_of_two_unknowns_is_what_the_key_holds(bench):
    path, _ = bench
    above = '[unknown.above]\nkeys = ["mechanism.joint_friction"]\nplus = "friction"\n'
    path.write_text(
        FILE.replace('keys = ["mechanism.joint_friction"]', 'keys = ["driveshaft.inertia_axial"]')
        .replace("low = 0.0\nhigh = 0.1", 'low = "0.01 kg m^2"\nhigh = "0.03 kg m^2"')
        .replace("[[stage]]", f'{above}low = 0.0\nhigh = 0.1\nreason = "a"\n[[stage]]', 1)
    )
    with pytest.raises(CaseError, match="must be an unknown of the same unit"):
        read_problem(path)
    base = path.read_text()
    path.write_text(base.replace("mechanism.joint_friction", "driveshaft.inertia_transverse").replace(
        "plus = \"friction\"\nlow = 0.0\nhigh = 0.1", 'plus = "friction"\nlow = "1 kg m^2"\nhigh = "2 kg m^2"'
    ).replace("members = 8", "members = 10").replace("members = 6", "members = 10"))  # fmt: skip
    problem = read_problem(path)
    case = problem.case_at(problem.rows[0], np.array([0.5, 0.0, 0.25]))
    assert case.driveshaft.inertia_axial == pytest.approx(0.02)
    assert case.driveshaft.inertia_transverse == pytest.approx(0.02 + 1.25)
    assert problem.case_at(problem.rows[0], np.array([0.5, 0.0, 0.25])).digest == case.digest
    # two numbers decide: the inertia of its own, and the sum, of ranges 0.02 and 1 kg m^2 wide
    mixed = problem.inputs(problem.rows[:1])
    np.testing.assert_allclose(mixed[[0, 2]].T, [[1.0, 0.0], [0.02 / 1.02, 1.0 / 1.02]])


def test_the_first_stages_alone_leave_out_rows_and_unknowns_of_the_others(bench):
    path, _ = bench
    path.write_text(FILE.replace('reason = "the instrument"', 'reason = "the instrument"\nstages = ["dear"]'))
    whole, first = read_problem(path), read_problem(path, "cheap")
    assert [one.name for one in whole.unknowns] == ["friction", "gain"] and len(whole.rows) == 2
    assert [one.name for one in first.unknowns] == ["friction"] and len(first.rows) == 1
    # the points of a stage are the same, whether later ones follow or not
    assert _file(whole, 0, path) != _file(whole, 1, path)
    assert _file(whole, 0, path) == _file(first, 0, path)
    dear = FILE.replace("[[predict]]", '[[stage]]\nname = "last"\nmembers = 6\n[[predict]]', 1)
    path.write_text(dear.replace('stages = ["dear"]', 'stages = ["dear", "last"]'))
    assert _file(read_problem(path), 1, path) == _file(read_problem(path, "dear"), 1, path)
    with pytest.raises(CaseError, match=r'--until: must be a stage, got "later"\. Stages: cheap, dear'):
        read_problem(path, "later")


def test_damaged_values_of_runs_are_refused(bench, tmp_path):
    path, _ = bench
    (tmp_path / "values.json").write_text('{"a": [1, {"torque": "much"}]}')
    with pytest.raises(CaseError, match=r"holds no values of runs \('much' is no number\). Delete it"):
        room.learn(read_problem(path), tmp_path, lambda: None)


def test_posterior_beyond_the_drawing_is_refused(bench):
    path, _ = bench
    text = FILE.replace("mechanism.joint_friction", "mechanism.total_mass")
    path.write_text(text.replace("low = 0.0\nhigh = 0.1", 'low = "1 kg"\nhigh = "2 kg"'))
    with pytest.raises(CaseError, match="the drawing can hold no point that agrees with the rows"):
        identification_of(read_problem(path), [Formula(lambda points: points[:, 0])] * 2, refused=1)


def test_rows_whose_runs_fail_are_counted_and_refused(bench, tmp_path, monkeypatch):
    path, _ = bench
    monkeypatch.setattr(
        ran, "run_all", lambda planned, *_: [Outcome(one, tmp_path, "blown up", {}) for one in planned]
    )
    log = []
    with pytest.raises(CaseError, match="only 0 of its members have a steady value, 1 unknowns need 5"):
        room.learn(read_problem(path), tmp_path, lambda: None, log=log.append)
    assert log[1:] == ["stage cheap: 8 of 8 runs failed", "  8 x blown up"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('keys = ["mechanism.joint_friction"]', "", "must have either keys or gain_of"),
        ("joint_friction", "joint_frction", "must be a key of one number, got None"),
        ("high = 0.1\n", "high = 0.0\n", "must have low below high, got 0 and 0"),
        ("low = 0.0", 'low = "0 N"', "must be a plain number"),
        ("low = 0.9", 'low = "much"', "must be a number without a unit, got"),
        ('quantity = "driveshaft_torque"\nvalue', "value", "must have quantity, or paper and row"),
        ('value = "0.35 N m"\n', "", "must state what is learned from it, lacks value"),
        ('discrepancy = "0 N m"\n', "", "lacks discrepancy. A model without error is"),
        ('scatter = "20 N mm"\ndis', 'scatter = "0 N m"\ndis', "must have a scatter above zero, got 0"),
        ('value = "0.35 N m"', 'value = "0.35 N m"\nrecord = "a.h5"', "must have either value or record"),
        ('value = "0.35 N m"', 'record = "a.h5"', "holds no steady mean of the row"),
        ('stages = ["dear"]', 'stages = ["later"]', '"later" is no stage. Stages: cheap, dear'),
        ('stages = ["dear"]', "", 'the stage "dear" runs no row'),
        ("members = 8", "members = 8\ndraws = true", "there is no posterior before the first stage"),
        (
            'discrepancy = "0 N m"\n[[predict]]',
            'discrepancy = "0 N m"\nstages = ["cheap", "dear"]\n[[predict]]',
            'cannot learn from rows of a stage of draws, got "driveshaft torque"',
        ),
        (
            'campaign = "second"\nstages = ["dear"]',
            'campaign = "second"\nstages = ["cheap", "dear"]',
            "must have rows of its own",
        ),
        ("members = 8", "members = 4", "too few members for the number of unknowns, got 4 for 1"),
        ('campaign = "second"\nstages', "stages", "acts in no row"),
        ('reason = "bearings"', 'reason = "bearings"\ncampaign = "third"', "the row depends on no unknown"),
        ('reason = "bearings"', 'reason = ""', "reason"),
        ("[unknown.friction]", "[unknwon.friction]", "unknown key"),
        ('reason = "bearings"', 'reason = "bearings"\nplus = "friction"', 'another unknown, got "friction"'),
        ('reason = "the instrument"', 'reason = "a"\nplus = "friction"', "plus has no use with gain_of"),
        ('reason = "bearings"', 'reason = "a"\nstages = ["late"]', '"late" is no stage. Stages: cheap, dear'),
    ],
)
def test_wrong_file_is_refused_before_anything_runs(bench, tmp_path, old, new, message):
    path, asked = bench
    assert old in FILE
    given = FILE.replace("members = 6", "members = 6\ndraws = true") if "draws" not in new else FILE
    path.write_text(given.replace(old, new, 1))
    with pytest.raises(CaseError) as raised:
        room.identify(path, tmp_path)
    assert message in str(raised.value)
    assert not asked


def test_row_of_a_paper_brings_its_case_and_its_value(bench):
    path, _ = bench
    learned = '[[learn]]\npaper = "mca2026"\nrow = "{}"\nscatter = "5 N"\ndiscrepancy = "0 N"\n'
    path.write_text(FILE + learned.format("table7-bars-force"))
    row = read_problem(path).rows[1]
    assert (row.value, row.quantity) == (817.0, "force")
    assert row.case.chamber.bars_mass == pytest.approx(1.347)
    path.write_text(FILE + learned.format("table7-bars-force") + 'quantity = "radial"\nvalue = "1 N"\n')
    beside = read_problem(path.with_name("file.toml")).rows[1]
    assert (beside.value, beside.quantity, beside.case) == (1.0, "radial", row.case)
    path.write_text(FILE + learned.format("bars-increment"))
    with pytest.raises(CaseError, match='must be a row of one run of mca2026, got "bars-increment"'):
        read_problem(path)


def test_a_record_of_another_machine_identifies_it(tmp_path, monkeypatch):
    """The example of the trough, its runs replaced by the closed form of J. P. Den Hartog, section 2.11."""
    for name in ("trough-identified.toml", "trough-channels.toml", "trough-test.csv"):
        (tmp_path / name).write_text((EXAMPLES / name).read_text())
    import_test(tmp_path / "trough-test.csv", tmp_path / "trough-channels.toml", tmp_path / "trough-test.h5")

    def run_all(planned, folder, workers, readings, report, log):
        def amplitude(case):
            motor, spring = case.unbalance_motors[0], case.springs[0]
            force = motor.mass * motor.eccentricity * motor.speed**2
            return force / np.hypot(spring.stiffness - 2.0 * motor.speed**2, spring.damping * motor.speed)

        return [
            Outcome(one, folder, "complete", {readings[0]: Estimate.exact(float(amplitude(one.case)))})
            for one in planned
        ]

    monkeypatch.setattr(ran, "run_all", run_all)
    problem = read_problem(tmp_path / "trough-identified.toml")
    emulators, _ = room.learn(problem, tmp_path, lambda: None)
    done = identification_of(problem, emulators)
    # made for 1400 N/m and an eccentricity of 36 mm
    (low, _, high), (least, _, largest) = done.unknowns
    assert low < 1400.0 < high and least < 0.036 < largest
    assert largest - least < 0.001  # of a range of 0.02
    # 1.933 mm at 960 rpm by the closed form
    assert done.posterior_rows[2][0] < 1.9333e-3 < done.posterior_rows[2][2]


def test_a_users_own_signals_are_a_row(bench, tmp_path):
    path, _ = bench
    rate, rng = 500.0, np.random.default_rng(1)
    time = np.arange(5000) / rate
    torque = 0.5 + 0.05 * rng.standard_normal(len(time))
    table = "\n".join(f"{t:.6f},{1e3 * value:.6f}" for t, value in zip(time, torque, strict=True))
    (tmp_path / "test.csv").write_text(f"t,Mz\n{table}\n")
    channel = '[channel.driveshaft_torque]\ncolumn = "Mz"\nunit = "N mm"\nsensor = "flange"\n'
    (tmp_path / "map.toml").write_text(f'time = "t"\nspeed = "60 rad/s"\n{channel}')
    import_test(tmp_path / "test.csv", tmp_path / "map.toml", tmp_path / "test.h5")
    path.write_text(FILE.replace('value = "0.35 N m"\nscatter = "20 N mm"', 'record = "test.h5"'))
    row = read_problem(path).rows[0]
    # white noise of 0.05 N m in 5000 samples: 0.7 mN m
    assert row.value == pytest.approx(0.5, abs=0.003)
    assert 0.0003 < row.scatter < 0.0015
    path.write_text(
        FILE.replace('"driveshaft_torque"\nvalue = "0.35 N m"', '"natural_frequency 1"\nrecord = "test.h5"')
    )
    with pytest.raises(CaseError, match="holds series only, the row asks for natural frequency 1"):
        read_problem(path)
