"""Published tests of single particles, as `python -m validation.charge` runs them: every row that should
agree does.

References, sources and tolerances stand with the cases, in `validation/charge`.  Rows that miss for a known
reason are named here, so that one more miss, and one less, is noticed.
"""

import importlib
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[2]))
chung_ooi, hysteretic, mfix, recorded, rolling = (
    importlib.import_module(f"validation.charge.{name}")
    for name in ("chung_ooi", "hysteretic", "mfix", "recorded", "rolling")
)


def missed(rows):
    """Quantities of the rows that do not pass, with what was got and allowed."""
    return {
        row.quantity: (row.source, row.ours - row.reference, row.tolerance) for row in rows if not row.passes
    }


@pytest.mark.parametrize("name", [name for name in chung_ooi.CASES if name[-1] != "5"])
def test_impacts_of_chung_and_ooi_are_those_of_the_paper(name):
    assert missed(chung_ooi.CASES[name]()) == {}


def test_impacts_at_constant_normal_speed_are_those_of_the_paper_with_its_half_shear_modulus():
    # test 5: the paper's curves are those of half the shear modulus of a rigid plane; with all of it they are
    # missed
    wrong = missed(chung_ooi.test_5())
    assert len(wrong) == 4
    assert all(
        "rigid plane" in quantity and source == chung_ooi.FIGURE for quantity, (source, *_) in wrong.items()
    )


@pytest.mark.parametrize("name", mfix.CASES)
def test_cases_of_mfix_follow_their_closed_forms(name):
    assert missed(mfix.CASES[name]()) == {}


@pytest.mark.parametrize("name", recorded.CASES)
def test_values_that_other_codes_recorded_are_met(name):
    assert missed(recorded.CASES[name]()) == {}


def test_hysteretic_impact_is_that_of_walton_and_braun():
    assert missed(hysteretic.walton_braun()) == {}


def test_rolling_ball_stops_where_a_constant_moment_stops_it():
    # type C has no dashpot here: at rest its spring goes on swinging
    assert set(missed(rolling.decay())) == {"type_c: stands still afterwards [m/s]"}


def test_ball_on_an_incline_stops_and_rests_or_rolls_back():
    assert missed(rolling.incline()) == {}
