"""What a picture or a film shows and when, without drawing it: moments between snapshots, cameras, words."""

import math

import numpy as np
import pytest
from nutating_chamber import SPEED, matrix, tilted
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.replay import between, chosen_snapshots, replay
from nutamill.base.errors import CaseError
from nutamill.case import Case, load_case
from nutamill.view.cameras import camera_of
from nutamill.view.drawing import DARK
from nutamill.view.film import caption, film_times
from nutamill.view.film_trace import FilmTrace
from nutamill.view.looks import Cut, Look, check_look, cut_of, range_of
from nutamill.view.machine_drawing import machine_solids


def test_between_two_snapshots_the_driveshaft_turns_and_pellets_stay_in_the_chamber(filmed):
    """The shaft turns at 60 rad/s: 2 ms after a snapshot by 0.12 rad. The chamber's axis moves on its cone;
    between two moments 0.3 rad apart a turn about a fixed axis leaves the cone by less than its sagitta,
    0.106 (1 - cos 0.15) = 0.0012 rad.
    """
    first, second = replay(filmed, chosen_snapshots(filmed)[:2])
    shown = between(first, second, 0.4)
    assert shown.time == pytest.approx(first.time + 0.4 * (second.time - first.time))
    angle = SPEED * shown.time
    shaft = shown.bodies["driveshaft"].rotation
    assert math.remainder(math.atan2(shaft[1, 0], shaft[0, 0]) - angle, 2.0 * math.pi) == pytest.approx(
        0.0, abs=1e-9
    )
    chamber = shown.bodies["chamber"]
    assert np.linalg.det(chamber.rotation) == pytest.approx(1.0)
    assert chamber.rotation[:, 2] == pytest.approx(matrix(tilted(angle))[:, 2], abs=1.3e-3)
    own = shown.at_home()
    low, high = (np.minimum(first.at_home(), second.at_home()), np.maximum(first.at_home(), second.at_home()))
    assert np.all(own >= low - 1e-9) and np.all(own <= high + 1e-9)
    assert between(first, second, 0.0) is first


def test_a_film_has_25_pictures_for_each_second_of_it():
    times = film_times(0.2, 0.3, slowed=40.0)  # 0.1 s become 4 s
    assert len(times) == 101
    assert np.diff(times) == pytest.approx(1.0 / (40.0 * 25.0))


def test_the_caption_of_a_film_has_time_speed_and_slowing(filmed):
    assert caption(filmed, 0.45, 40.0) == "t = 0.4500 s   573 rpm   40 times slower"  # 60 rad/s


def test_the_mark_below_a_film_follows_the_force_over_time(filmed):
    """The force is 700 N + 20 N cos(120 rad/s t): largest at 8 periods, 0.4189 s, smallest half a period
    later, and 700 N halfway between.
    """
    times = film_times(0.405, 0.5, slowed=40.0)
    strip = FilmTrace(filmed, times, Look(background="#202830"), (640, 480))
    largest = 16.0 * math.pi / 120.0
    half = math.pi / 120.0
    marks = []
    for time in (largest, largest + 0.5 * half, largest + half):
        image = strip.at(time)
        assert image.shape == (strip.height, 640, 3) and strip.height == 116
        assert image[0, 0].tolist() == [0x20, 0x28, 0x30]
        marks.append(np.argwhere((image == (0xD5, 0x5E, 0x00)).all(axis=-1)).mean(axis=0))
    rows, columns = np.transpose(marks)
    assert rows[2] - rows[0] > 30.0 and np.diff(columns)[0] > 20.0
    # the mark is where samples 1 ms apart are joined: 20 N (1 - cos 0.06) = 0.04 N, and half a pixel
    assert rows[1] == pytest.approx(0.5 * (rows[0] + rows[2]), abs=1.0)
    assert columns[1] == pytest.approx(0.5 * (columns[0] + columns[2]), abs=1.0)


def test_a_camera_is_turned_about_its_target(filmed):
    camera = camera_of("front", Case.from_toml(filmed.case_text))
    look = Look(azimuth=math.radians(-60.0), elevation=math.radians(20.0))
    turned = look.aimed(camera)
    assert turned.distance == pytest.approx(camera.distance)
    assert (turned.azimuth, turned.elevation) == pytest.approx((math.radians(-60.0), math.radians(20.0)))
    assert Look(elevation=0.1).aimed(camera).azimuth == pytest.approx(camera.azimuth)
    above = Look(elevation=math.radians(90.0)).aimed(camera)
    assert abs(above.up @ (above.eye - above.target)) < 1e-9 * above.distance
    assert Look().aimed(camera) is camera


def test_planes_and_ranges_are_read_with_units():
    assert cut_of("y") == Cut(1, 0.0) and cut_of("z=-20 mm") == Cut(2, pytest.approx(-0.02))
    assert range_of("0..3 m/s", "speed") == (0.0, 3.0)
    assert range_of("-5 .. 150 mm", "height") == pytest.approx((-0.005, 0.15))


@pytest.mark.parametrize("text", ["w", "", "xy", "y=3", "y=3 kg"])
def test_another_plane_is_refused(text):
    with pytest.raises(
        CaseError, match=r"--cut: (must be an axis, and where the plane|needs a unit|.* this needs a length)"
    ):
        cut_of(text)


@pytest.mark.parametrize(
    ("text", "why"), [("3 m/s", "must be two ends and a unit"), ("3..0 m/s", "must rise"), ("0..3 kg", "kg")]
)
def test_another_range_is_refused(text, why):
    with pytest.raises(CaseError, match=why):
        range_of(text, "speed")


def test_faults_of_a_look_are_reported_at_once():
    look = Look("behind", "material", limits=(0.0, 1.0), background="mud")
    with pytest.raises(CaseError) as raised:
        check_look(look)
    faults = [str(fault) for fault in raised.value.faults]
    assert len(faults) == 3
    assert "must be a colour, as white or" in faults[1] and "has no use for materials" in faults[2]
    with pytest.raises(CaseError, match="cannot be transparent in a film"):
        check_look(Look(background="transparent"), film=True)
    assert (Look().ink, Look(background="#202830").ink) == ("black", "white")


def test_nothing_floats_between_the_walls_of_a_body_without_joints_elsewhere():
    """The guide of the damper is at the mass centre of its box; the crank of a planetary mill is drawn."""
    parts = {part.name for part in machine_solids(load_case("particle-damper").machine)}
    assert parts == {"enclosure"}
    assert any(part.colour == DARK for part in machine_solids(load_case("planetary-mill").machine))


def test_options_of_pictures_are_those_of_films():
    helps = [CliRunner().invoke(cli.app, [name, "-h"]).stdout for name in ("picture", "movie")]
    for option in ("--range", "--cut", "--background", "--azimuth", "--elevation", "--size"):
        assert all(option in text for text in helps)
