"""Films of the machine in three dimensions: the pictures of `nutamill.view.scene`, one after another.

ffmpeg is of the extra ``view`` and imported in this file only.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from nutamill.analysis.replay import chosen_snapshots
from nutamill.base.atomic_file import check_writable, io_errors
from nutamill.base.errors import OutputError, missing_extra
from nutamill.base.units import rpm
from nutamill.result import Result
from nutamill.view.film_trace import FilmTrace
from nutamill.view.looks import Look, check_look
from nutamill.view.renderer import SIZE
from nutamill.view.scene import LOOK, open_stage

FILMS = (".mp4",)
"""Suffixes of films."""
FILM_RATE = 25
"""Pictures per second of a film [1/s]."""
SLOWED = 40.0
"""Default of how many times slower than real a film runs [1]."""
LOGGED = 100
"""Pictures of a film drawn between two lines of its log [1]."""
FRAGMENTS = ["-movflags", "+frag_keyframe+empty_moov+default_base_moof", "-g", "50"]
"""Options of ffmpeg: fragments of two seconds, each complete, so that a truncated film still plays."""
QUALITY = 7
"""Quality of the pictures of a film, of 10."""
BLOCK = 2
"""Width and height of a film are rounded up to a multiple of this [px]: colours are stored for four pixels
together.
"""


def film_scene(
    result: Result,
    path: str | Path,
    look: Look = LOOK,
    slowed: float = SLOWED,
    log: Callable[[str], None] | None = None,
    size: tuple[int, int] = SIZE,
    trace: bool = False,
) -> Path:
    """Write a film (MP4) of the time that has snapshots, and return its path. Between two snapshots the
    motion is interpolated.

    Parameters
    ----------
    slowed : how many times slower than real the film runs [1]
    log : receives now and then how many pictures have been drawn
    size : width and height of the film [px]
    trace : whether the force, of a machine without one the first series of its page, is drawn over time
        below the picture, with a mark at the present moment

    Raises
    ------
    as `draw_scene`; NotInstalledError also where ffmpeg is missing
    """
    path = Path(path)
    check_writable(path, FILMS)
    check_look(look, film=True)
    known = chosen_snapshots(result)
    at = result.snapshots.time[known]
    times = film_times(float(at[0]), float(at[-1]), slowed)
    below = FilmTrace(result, times, look, size) if trace else None
    across, down = size[0], size[1] - (below.height if below else 0)
    with open_stage(result, look, known, (across, down)) as stage:
        if ffmpeg_trouble():
            raise missing_extra(f"{path}: a film", "ffmpeg", "view")
        with _writer(path, size) as write:
            for done, time in enumerate(times):
                if log is not None and done % LOGGED == 0:
                    log(f"{done} of {len(times)} pictures drawn")
                stage.show(stage.moment_at(float(time), at), caption(result, float(time), slowed))
                image = stage.image()
                write(image if below is None else np.vstack([image, below.at(float(time))]))
    return path


def film_times(first: float, last: float, slowed: float) -> np.ndarray:
    """Return the simulated times of the pictures of a film [s], at 25 pictures for each second of film."""
    return np.linspace(first, last, max(2, round((last - first) * slowed * FILM_RATE) + 1))


def caption(result: Result, time: float, slowed: float) -> str:
    """Return the caption of a picture of a film: time, speed of the drive where there is one, slowing."""
    words = [f"t = {time:.4f} s"]
    if "driveshaft_speed" in result.series:
        series = result.series
        speed = float(np.interp(time, series["time"].values, series["driveshaft_speed"].values))
        words.append(f"{rpm(speed):.0f} rpm")
    return "   ".join([*words, f"{slowed:g} times slower"])


def ffmpeg_trouble() -> str:
    """Return why no film can be written, or "" if one can."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return str(missing_extra("a film", "ffmpeg", "view"))
    return ""


@contextmanager
def _writer(path: Path, size: tuple[int, int]) -> Iterator[Callable[[np.ndarray], None]]:
    """Open a film, and give a function that adds a picture, (height, width, 3), to it.

    Raises
    ------
    OutputError : ffmpeg cannot write
    """
    import imageio_ffmpeg

    full = OutputError(
        f"{path}: ffmpeg cannot write the film any further. Free some room, or choose another folder."
    )
    written = 0
    with io_errors(path):
        film = imageio_ffmpeg.write_frames(
            str(path),
            size,
            fps=FILM_RATE,
            quality=QUALITY,
            macro_block_size=BLOCK,
            ffmpeg_log_level="error",
            output_params=list(FRAGMENTS),
        )
        film.send(None)

    def write(image: np.ndarray) -> None:
        nonlocal written
        try:
            film.send(np.ascontiguousarray(image))
        except OSError:  # holds the command line of ffmpeg
            raise full from None
        written += 1

    try:
        yield write
    finally:
        film.close()
    if _pictures_in(path) < written:  # of what ffmpeg has not written yet it reports no error
        raise full


def _pictures_in(path: Path) -> int:
    """Return how many pictures of a film can be read [1]."""
    import imageio_ffmpeg

    try:
        return imageio_ffmpeg.count_frames_and_secs(str(path))[0]
    except RuntimeError:  # nothing can be read
        return 0
