"""The demonstration: what it shortens and what it keeps."""

import math

import pytest

from nutamill.case import load_case
from nutamill.simulation.setup.clock import contact_facts, run_clock
from nutamill.simulation.setup.quick import quick


@pytest.fixture(scope="module")
def mill():
    return load_case("numill")


def test_a_demonstration_keeps_the_speed_and_makes_three_turns_at_it(mill):
    short = quick(mill)
    assert short.drive.speed == mill.drive.speed
    rows = (short.run.until - short.drive.ramp_end) * short.run.series_rate
    turn = 2 * math.pi / short.drive.speed * short.run.series_rate
    assert (
        3 * turn <= math.floor(rows) - 1 <= 3 * turn + 2
    )  # whole turns are looked for between rows, one at each end may be lost


def test_a_demonstration_softens_contacts_between_particles_ninefold_and_no_other(mill):
    (pair, wall), (soft, same) = contact_facts(mill.machine), contact_facts(quick(mill).machine)
    assert soft.stiffness == pytest.approx(pair.stiffness / 9, rel=1e-12)
    assert same.stiffness == pytest.approx(wall.stiffness, rel=1e-12)
    # a contact lasts as sqrt(1/k), and the substep goes with it, rounded to whole windows in a row of the
    # record
    assert run_clock(quick(mill).machine).substep > 2.5 * run_clock(mill.machine).substep


def test_an_empty_mill_has_a_demonstration_too(mill):
    assert quick(mill.with_("charge.kind", "none")).mechanism.mounting == "rigid"


def test_the_title_of_a_demonstration_says_what_is_simplified(mill):
    title = "demonstration of numill: rigid mounts, 0.2 s ramp, 3 turns at speed"
    assert quick(mill).title == f"{title}, contacts between particles 9 times softer"
    assert quick(mill.with_("charge.kind", "none")).title == title
