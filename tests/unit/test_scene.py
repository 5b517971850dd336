"""Pictures in three dimensions show the charge in its colours, from each camera, and say what is missing."""

import builtins

import numpy as np
import pytest
from matplotlib.image import imread

from nutamill.analysis.replay import chosen_snapshots, replay
from nutamill.base.errors import CaseError, MillError, NotInstalledError, OutputError, ResultError
from nutamill.case import Case
from nutamill.view.cameras import camera_of
from nutamill.view.film import film_scene
from nutamill.view.looks import Cut, Look
from nutamill.view.scene import draw_scene

pytestmark = pytest.mark.external


@pytest.fixture(autouse=True)
def _pyvista():
    pytest.importorskip("pyvista", reason='needs the extra "view"')


def test_camera_inside_rides_on_the_chamber(filmed):
    """In chamber axes it stands still, 2 % of the height under the ceiling, and looks at the middle of the
    floor.
    """
    case = Case.from_toml(filmed.case_text)
    for frame in replay(filmed, chosen_snapshots(filmed)):
        pose, camera = frame.bodies["chamber"], camera_of("inside", case).in_world(frame)
        assert (camera.eye - pose.origin) @ pose.rotation == pytest.approx(
            [0.0, -0.028, -0.122 - 0.02 * 0.228]
        )
        assert (camera.target - pose.origin) @ pose.rotation == pytest.approx([0.0, 0.0, -0.350])


@pytest.mark.parametrize("view", ["front", "inside", "axis"])
def test_picture_from_each_camera_shows_the_coloured_charge(filmed, tmp_path, view):
    try:
        picture = imread(draw_scene(filmed, tmp_path / "a.png", Look(view, "height")))[..., :3]
    except MillError as error:
        pytest.skip(str(error))
    assert picture.shape == (960, 1280, 3)
    coloured = np.ptp(picture[:, 120:], axis=-1) > 0.35  # viridis; the machine is grey, the bar on the left
    # the nearest pellets are 300 circles of 2.5 mm seen from about 1.6 m at 30 deg, 960 pixels high: 4 pixels
    # across at least
    assert coloured.sum() > 300
    assert coloured.mean() < 0.6


def test_film_of_a_run_is_as_long_as_asked(filmed, tmp_path):
    iio = pytest.importorskip("imageio_ffmpeg", reason='needs the extra "view"')
    try:
        film = film_scene(filmed, tmp_path / "a.mp4", Look("axis"), slowed=4.0)
    except MillError as error:
        pytest.skip(str(error))
    # 95 ms, four times slower, 25 pictures a second: 9.5 steps, so 10 or 11 pictures
    assert iio.count_frames_and_secs(str(film))[0] in (10, 11)


def test_a_film_that_ffmpeg_cannot_write_to_its_end_is_an_error(filmed, tmp_path):
    """A short film is in the memory of ffmpeg until its end, so that no picture is refused."""
    pytest.importorskip("imageio_ffmpeg", reason='needs the extra "view"')
    resource = pytest.importorskip("resource", reason="limits the size of files")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        with pytest.raises(OutputError, match=r"a\.mp4: ffmpeg cannot write the film any further"):
            film_scene(filmed, tmp_path / "a.mp4", slowed=1.0, size=(320, 240))
    except NotInstalledError as error:
        pytest.skip(str(error))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_film_with_a_trace_has_the_size_that_is_asked_for(filmed, tmp_path):
    """No multiple of 16, to which ffmpeg would round up."""
    iio = pytest.importorskip("imageio_ffmpeg", reason='needs the extra "view"')
    try:
        film = film_scene(filmed, tmp_path / "a.mp4", slowed=1.0, size=(330, 250), trace=True)
    except MillError as error:
        pytest.skip(str(error))
    frames = iio.read_frames(str(film))
    assert next(frames)["size"] == (330, 250)


def test_film_without_ffmpeg_says_what_to_install(filmed, tmp_path, monkeypatch):
    real = builtins.__import__

    def missing(name, *rest):
        if name == "imageio_ffmpeg":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(MillError, match=r"needs ffmpeg.*pip install .\.\[view\]"):
        film_scene(filmed, tmp_path / "a.mp4")


def test_pyvista_or_opengl_that_is_missing_is_named(filmed, tmp_path, monkeypatch):
    import pyvista

    def no_opengl(*_, **__):
        raise RuntimeError("no display")

    monkeypatch.setattr(pyvista, "Plotter", no_opengl)
    with pytest.raises(MillError, match=r"need OpenGL.*no display.*libegl1"):
        draw_scene(filmed, tmp_path / "a.png")


def test_view_and_colour_of_no_such_name_are_refused_together(filmed, tmp_path):
    with pytest.raises(CaseError) as raised:
        draw_scene(filmed, tmp_path / "a.png", Look("behind", "taste"))
    assert [fault.where for fault in raised.value.faults] == ["--camera", "--colour"]


def test_snapshots_without_forces_cannot_be_coloured_by_them(filmed, tmp_path):
    with pytest.raises(ResultError, match="hold no contact_forces"):
        draw_scene(filmed, tmp_path / "a.png", Look(colour="force"))


def test_the_size_of_a_picture_must_be_two_numbers(filmed):
    from typer.testing import CliRunner

    from nutamill import cli

    reply = CliRunner().invoke(cli.app, ["picture", str(filmed.path), "--size", "big"])
    assert reply.exit_code == 2
    assert reply.stderr == (
        '--size: must be width and height in pixels, from 10 to 9999, got "big". '
        "Write e.g. --size 1920x1080\n"
    )


def drawn(filmed, file, **words):
    """A picture as an array, without the alpha of an opaque one."""
    try:
        return imread(draw_scene(filmed, file, **words))
    except MillError as error:
        pytest.skip(str(error))


def coloured(picture):
    """Pixels of the charge: viridis, while the machine is grey, without the bar on the left."""
    return int((np.ptp(picture[:, 200:, :3], axis=-1) > 0.35).sum())


def test_several_moments_are_drawn_side_by_side(filmed, tmp_path):
    """The two moments are half a turn apart, so that the charge is on the other side."""
    look = Look("axis", "height")
    pair = drawn(filmed, tmp_path / "a.png", look=look, times=[0.5 - np.pi / 60, 0.5], size=(800, 400))
    assert pair.shape[:2] == (400, 800)
    assert not np.array_equal(pair[:300, :400], pair[:300, 400:])


def test_a_cut_takes_away_what_is_before_the_plane(filmed, tmp_path):
    whole, half = (
        drawn(filmed, tmp_path / "a.png", look=Look("axis", "height", (0.0, 0.15), cut=cut))
        for cut in (None, Cut(2, -0.30))
    )
    assert 0 < coloured(half) < coloured(whole)


def test_a_background_is_a_colour_or_nothing(filmed, tmp_path):
    dark = drawn(filmed, tmp_path / "a.png", look=Look(background="#202830"), size=(320, 240))
    assert np.round(255 * dark[2, 2, :3]).astype(int).tolist() == [0x20, 0x28, 0x30]
    clear = drawn(filmed, tmp_path / "b.png", look=Look(background="transparent"), size=(320, 240))
    assert clear.shape[2] == 4 and clear[2, 2, 3] == 0.0 and clear[..., 3].max() == 1.0
