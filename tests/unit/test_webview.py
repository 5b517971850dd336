"""The page in which the mill turns holds the run, stays small, and shows pellets inside the chamber in a real
browser.
"""

import base64
import json
import math
import re
import subprocess
import zlib

import h5py
import numpy as np
import pytest
from browser import CHROMIUM, Browser
from matplotlib.image import imread

from nutamill.analysis.source import case_of
from nutamill.base.errors import ResultError
from nutamill.case import load_case
from nutamill.case.drawing import BODIES
from nutamill.result import open_result
from nutamill.result.checksums import Checksums
from nutamill.view import webview
from nutamill.view.cameras import VIEWS, camera_of
from nutamill.view.drawing import box, machine_parts, ring
from nutamill.view.webview import view_page, write_view


def block(page, name):
    return re.search(rf'<script id="{name}"[^>]*>(.*?)</script>', page, re.DOTALL)[1]


def enclosed(part):
    """Volume within triangles whose corners run counter-clockwise seen from outside."""
    a, b, c = (part.vertices[part.triangles[:, k]] for k in range(3))
    return np.sum(a * np.cross(b, c)) / 6.0


def test_parts_of_the_drawing_are_closed_and_face_outwards():
    assert enclosed(box(0.1, 0.2, 0.3)) == pytest.approx(0.006)
    # a prism of 96 sides has (96 / 2 pi) sin(2 pi / 96) = 0.99929 of the circle's area
    whole = math.pi * (0.05**2 - 0.03**2) * 0.4 * 0.99929
    assert enclosed(ring(0.03, 0.05, -0.1, 0.3)) == pytest.approx(whole, rel=1e-4)
    assert enclosed(ring(0.03, 0.05, -0.1, 0.3, opening=math.pi)) == pytest.approx(whole / 2, rel=1e-4)
    assert enclosed(ring(0.0, 0.05, 0.0, 1.0).lying("x")) == pytest.approx(
        math.pi * 0.05**2 * 0.99929, rel=1e-4
    )
    case = load_case("numill", ["chamber.ribs=12", "chamber.bars.mass=1 kg", "balance.mass=1 kg"])
    for part in machine_parts(case, opening=2.0):
        assert enclosed(part) > 0.0, part.name


def test_drawing_knows_the_bodies_in_the_order_of_the_snapshots():
    assert tuple(body.name for body in load_case("numill").machine.bodies) == BODIES


def test_page_holds_every_place_to_sixteen_bits(filmed):
    facts = json.loads(block(view_page(filmed), "facts"))
    raw = np.frombuffer(zlib.decompress(base64.b64decode(block(view_page(filmed), "packed"))), np.uint8)
    frames, n = facts["frames"], facts["particles"]
    rows = raw.reshape(frames, 7 * n).astype(np.uint32)
    whole = np.cumsum(256 * rows[:, : 3 * n] + rows[:, 3 * n : 6 * n], axis=0) % 65536
    places = facts["low"] + whole.reshape(frames, n, 3) / 65535.0 * facts["span"]
    # the pellets of the film stand in the chamber as (0.046..0.066 m, azimuth, height); a step of 16 bits is
    # 0.15 m / 65535
    radius = np.hypot(places[..., 0], places[..., 1])
    assert radius.min() > 0.046 - 1e-5
    assert radius.max() < 0.066 + 1e-5
    assert places[..., 2].min() == pytest.approx(-0.345, abs=2e-3)
    assert np.ptp(places[..., 2], axis=0).max() < 1e-5
    speeds = np.cumsum(rows[:, 6 * n :], axis=0) % 256 / 255.0 * facts["speed"]
    taken = np.minimum(np.linalg.norm(filmed.snapshots[-1]["velocities"], axis=1), facts["speed"])
    assert np.abs(speeds[-1] - taken).max() <= 0.51 / 255.0 * facts["speed"]


def test_page_holds_forces_sizes_and_materials_to_colour_by(filmed, monkeypatch):
    """Forces of a known spread; a step of eight bits is a 255th of the end of the bar, their 99.9 %
    quantile.
    """
    snapshots = filmed.snapshots
    frames, n = len(snapshots), len(snapshots[0]["radii"])
    given = np.random.default_rng(3).uniform(0.0, 40.0, (frames, n))
    monkeypatch.setattr(webview, "_forces", lambda result, chosen: given)
    page = view_page(filmed)
    facts = json.loads(block(page, "facts"))
    raw = np.frombuffer(zlib.decompress(base64.b64decode(block(page, "packed"))), np.uint8)
    shares = np.cumsum(raw.reshape(frames, 8 * n)[:, 7 * n :].astype(np.uint32), axis=0) % 256 / 255.0
    assert facts["force"] == pytest.approx(np.quantile(given, 0.999))
    assert np.abs(shares * facts["force"] - np.minimum(given, facts["force"])).max() <= 0.51 / 255 * 40.0
    assert facts["sizes"] == pytest.approx([0.005, 0.005])


def test_two_hundred_frames_of_2618_pellets_stay_under_six_megabytes(tmp_path, film):
    """Seven bytes for each pellet and frame, four thirds of them as text, if nothing could be compressed: 4.9
    MB, and the page itself.
    """
    with open_result(film(tmp_path / "a.h5", snapshots=2, pellets=2000)) as result:
        bare = len(view_page(result).encode()) - 2 * 2000 * 7 * 4 // 3
    assert bare + 200 * 2618 * 7 * 4 // 3 < 6e6


def test_of_many_snapshots_evenly_spaced_ones_are_shown(filmed):
    times = json.loads(block(view_page(filmed, frames=7), "facts"))["times"]
    assert np.allclose(np.diff(times), 0.015)
    assert times[-1] == pytest.approx(0.5)


def test_no_name_in_a_result_can_end_the_facts_or_hide_the_rest_of_the_page(tmp_path, film):
    """A browser leaves a script at "</script>", and after "<!--<script>" it takes all that follows for a part
    of it.
    """
    path, name = film(tmp_path / "a.h5", snapshots=1, pellets=1), "<!--<script>x</script>"
    with h5py.File(path, "a") as file:
        mesh = file.create_group(f"walls/{name.replace('/', '|')}")
        mesh["vertices"], mesh["triangles"] = np.eye(3), np.array([[0, 1, 2]], np.int32)
        checksums = Checksums.read(file)
        checksums.take(file, "walls")
        checksums.write(file)
    with open_result(path) as result:
        facts = block(view_page(result), "facts")
    assert "<" not in facts
    assert name.replace("/", "|") in [part["name"] for part in json.loads(facts)["parts"]]


def test_result_without_snapshots_says_what_to_run(unfilmed):
    with pytest.raises(ResultError, match=r"unfilmed\.h5: holds no snapshots.* run\.snapshots"):
        view_page(unfilmed)


@pytest.mark.external
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium to open the page in")
def test_browser_shows_pellets_inside_the_chamber_and_complains_of_nothing(tmp_path, film):
    width, height = 800, 600
    with open_result(film(tmp_path / "a.h5", snapshots=1, pellets=300)) as result:
        page = write_view(result, tmp_path / "a.html")
        facts = json.loads(block(page.read_text(), "facts"))
    alone = page.read_text().replace(
        "</head>", "<style>header, footer, #legend, #traces { display: none !important }</style></head>"
    )
    page.write_text(alone.replace('id="machine" type="checkbox" checked', 'id="machine" type="checkbox"'))
    picture = tmp_path / "a.png"
    flags = [
        "--headless",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--hide-scrollbars",
    ]
    flags += [
        f"--user-data-dir={tmp_path / 'profile'}",
        f"--window-size={width},{height}",
        "--virtual-time-budget=3000",
    ]
    printed = subprocess.run(
        [CHROMIUM, *flags, "--enable-logging=stderr", f"--screenshot={picture}", page.as_uri()],
        capture_output=True,
        text=True,
        timeout=120,
    ).stderr
    assert "CONSOLE" not in printed
    seen = imread(picture)[..., :3]
    coloured = np.argwhere(np.ptp(seen, axis=-1) > 0.25)
    # a pinhole camera at the place the page gives: the chamber's corners in pixels, from the camera's axes
    view = facts["views"]["front"]
    direction = np.array(
        [
            math.cos(view["height"]) * math.cos(view["azimuth"]),
            math.cos(view["height"]) * math.sin(view["azimuth"]),
            0.0,
        ]
    )
    direction[2] = math.sin(view["height"])
    right = np.cross([0.0, 0.0, 1.0], direction) / math.cos(view["height"])
    up = np.cross(direction, right)
    chamber = np.array(facts["bodies"]["chamber"][0])
    w, v = chamber[3], chamber[4:]
    corners = np.array([[x, y, z] for x in (-0.07, 0.07) for y in (-0.07, 0.07) for z in (-0.350, -0.122)])
    corners = (
        corners
        + 2 * np.cross(v, np.cross(v, corners) + w * corners)
        - (np.array(view["target"]) + view["distance"] * direction)
    )
    pixels = 0.5 * height / math.tan(0.5 * view["angle"])
    across = 0.5 * width + pixels * (corners @ right) / -(corners @ direction)
    down = 0.5 * height - pixels * (corners @ up) / -(corners @ direction)
    # 300 pellets of 2.5 mm hide each other at most ten times over; a pixel more on each side for the edges
    area = 300 * math.pi * (0.0025 * pixels / view["distance"]) ** 2
    assert area / 10 < len(coloured) < area * 1.3
    assert down.min() - 1 <= coloured[:, 0].min()
    assert coloured[:, 0].max() <= down.max() + 1
    assert across.min() - 1 <= coloured[:, 1].min()
    assert coloured[:, 1].max() <= across.max() + 1


def test_page_and_pictures_have_the_same_cameras(filmed):
    """The page gives the camera as angles about its target; above 1.57 rad it keeps an upward direction."""
    views = json.loads(block(view_page(filmed), "facts"))["views"]
    assert list(views) == list(VIEWS)
    for name, view in views.items():
        camera = camera_of(name, case_of(filmed))
        flat = math.cos(view["height"])
        direction = [flat * math.cos(view["azimuth"]), flat * math.sin(view["azimuth"]), 0.0]
        direction[2] = math.sin(view["height"])
        eye = np.array(view["target"]) + view["distance"] * np.array(direction)
        assert eye == pytest.approx(camera.eye, abs=1e-3 * camera.distance)  # cos 1.57 = 8e-4
        assert (view["angle"], view["rides"]) == (camera.angle, camera.rides)
        assert view["hides"] == list(camera.hides)


def test_traces_cover_the_whole_run_and_lose_no_peak(tmp_path, film):
    """A run of 8 s at 1000 Hz has 8001 samples; the force swings by 20 N about 700 N throughout."""
    with open_result(film(tmp_path / "a.h5", snapshots=3, pellets=1, seconds=8.0)) as result:
        facts = json.loads(block(view_page(result), "facts"))
        force = result.series["crank_pin_force_resultant"].values
    times = facts["traceTimes"]
    assert (times[0], times[-1]) == (0.0, 8.0) and len(times) < 5000 < len(force)
    assert facts["times"][-1] < 1.0 and np.all(np.diff(times) > 0.0)
    drawn = facts["traces"][0]["values"]
    assert (min(drawn), max(drawn)) == pytest.approx((force.min(), force.max()), rel=1e-4)


@pytest.mark.external
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium to click in")
def test_a_person_moves_in_time_resets_and_asks_for_help(tmp_path, film):
    with open_result(film(tmp_path / "a.h5", snapshots=5, pellets=20)) as result:
        page = write_view(result, tmp_path / "a.html")
    with Browser(tmp_path) as browser:
        browser.open(page.as_uri())
        browser.wait("document.body.dataset.drawn === 'yes'")
        browser.click("#play")
        browser.click("#plot")  # its middle is before the first snapshot, at a quarter of a second
        assert browser.value("playing.frame") == 0
        browser.value("document.activeElement.blur()")
        browser.press("ArrowRight")
        assert browser.value("playing.frame") == 1
        browser.click("#machine")
        browser.press("r")
        # it plays from the beginning, and may be in a later frame, or round again, when the answer comes
        browser.wait("document.querySelector('#machine').checked && playing.frame < 1 && playing.on")
        browser.click("#ask")
        assert browser.value("document.querySelector('#help').getClientRects().length > 0")
        browser.press("Escape")
        assert browser.value("document.querySelector('#help').getClientRects().length === 0")
        assert browser.trouble == []


@pytest.mark.external
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium to click in")
def test_without_the_machine_the_vessel_is_in_the_middle_and_larger(tmp_path, film):
    """The chamber reaches from 122 to 350 mm below the nutation point, and its middle, 236 mm, swings on a
    cone of 6.08 deg.
    """
    with open_result(film(tmp_path / "a.h5", snapshots=5, pellets=20)) as result:
        page = write_view(result, tmp_path / "a.html")
    with Browser(tmp_path) as browser:
        browser.open(page.as_uri())
        browser.wait("document.body.dataset.drawn === 'yes'")
        whole = browser.value("camera.distance")
        browser.click("#machine")
        # half of 228 mm and of two lids of 4.9 mm, 15 % more, in half of the lens of 28 deg
        near = 1.15 * (0.114 + 0.0049) / math.sin(math.radians(14.0))
        assert browser.value("camera.distance") == pytest.approx(near, rel=1e-3) and near < 0.6 * whole
        assert browser.value("camera.target[2]") == pytest.approx(-0.236 * math.cos(0.1061), abs=2e-3)
        browser.click("#machine")
        assert browser.value("camera.distance") == whole
        names = "[...document.querySelector('#colour').options].map((option) => option.text).join()"
        assert browser.value(names) in ("speed,height,size", "speed,height,material,size")
        browser.value("element('colour').value = 'size'; legend(); 0")
        assert browser.value("element('what').textContent") == "diameter (mm)"
        assert browser.trouble == []
