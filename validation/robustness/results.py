"""Result files that were damaged at random, read by every command that reads results.

Each attempt damages a copy of one sound result in one way.  The result is read as a format-2 file whose
checksums are as they were, as one whose checksums were written anew after the damage (so that what lies
behind them is met), or as a file of format 1, which has none.  What a reader gets from a file with its own
checksums must be what was written.

Every attempt reads all parts of the file through Python.  A share of them, `THOROUGH`, damages a file with
all series and statistics of a mill, which is also verified, reopened for writing and given to a command.
"""

import math
import os
import random
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from typer.testing import CliRunner

from nutamill.base.errors import MillError, ResultError
from nutamill.case import load_case
from nutamill.case.drawing import BODIES
from nutamill.cli import app
from nutamill.result import Recorder, WallMesh, open_result, verify
from nutamill.result.checksums import COPIES, Checksums
from nutamill.result.fields import STATISTICS, expand
from nutamill.result.layout import FORMAT_VERSION

COMMANDS = ("show", "verify", "orders", "loads", "mounts", "view", "export", "report", "plot", "compare")
"""Commands that read a result; a thorough attempt gives the file to one of them."""
THOROUGH = 0.05
"""Share of the attempts that are thorough: one takes as long as ten of the others [1]."""
SERIES, AXES = 4, ("pair", "part", "energy", "neighbours")
"""Number of series [1] and axes of the statistics in the file of the other attempts: each kind of object is
there.
"""
ODD = (
    0,
    -1,
    math.nan,
    math.inf,
    5,
    "x",
    "",
    10**9,
    10**18,
    "complete",
    "1",
    np.arange(3),
    np.zeros(0),
    np.bytes_(b"\xff\xfe"),
)
"""Values that damage puts into attributes."""
LENGTHS = (0, 1, 700, 30_000_000, 10**13)
"""Lengths that damage gives to datasets."""
RATE = 1000.0


def attempts(
    number: int, seed: int, thorough: float = THOROUGH
) -> Iterator[tuple[str, str, Callable[[], Any]]]:
    """Yield the kind and the name of each attempt, and what reads the damaged file; an AssertionError is
    silent use.

    `thorough` is the share of thorough attempts [1].
    """
    with tempfile.TemporaryDirectory() as folder:
        small = _Sound.written(Path(folder) / "sound.h5", whole=False)
        large = _Sound.written(Path(folder) / "large.h5") if thorough else small
        for count in range(number):
            path = Path(folder) / str(count) / "damaged.h5"
            path.parent.mkdir()
            draw = random.Random(f"{seed}-{count}")
            damage, guise = draw.choice(DAMAGES), draw.choice(GUISES)
            command = draw.choice(COMMANDS) if draw.random() < thorough else ""
            sound = large if command else small
            path.write_bytes(sound.whole)
            guise(path, damage, draw)
            name = f"{count} of seed {seed}: {damage.__name__.strip('_')}, {guise.__name__.strip('_')}"
            true = sound.content if guise is _as_it_was else None

            yield damage.__name__.strip("_"), f"{name}, {command}", partial(_read, path, command, true)
            shutil.rmtree(path.parent)


class _Sound(NamedTuple):
    """A result before it is damaged."""

    whole: bytes
    """The file."""
    content: list[Any]
    """What readers get from it."""

    @classmethod
    def written(cls, path: Path, whole: bool = True) -> "_Sound":
        write_sound(path, whole)
        return cls(path.read_bytes(), content(path))


def write_sound(path: Path, whole: bool = True) -> Path:
    """Write the result of a mill: 0.6 s at 60 rad/s, 3 snapshots, statistics at two times, a meshed wall, two
    checkpoints.

    It has all series and statistics, or, where not `whole`, `SERIES` and those over `AXES`.
    """
    draw = np.random.default_rng(1)
    case = load_case("numill", ["mechanism.mounting=rigid"])
    names, time = expand(sensors=("frame_corner",))[: None if whole else SERIES], np.arange(601) / RATE
    axes = {name: line for name, line in _axes().items() if whole or name in AXES}
    walls = {
        "chamber.mesh": WallMesh(draw.random((4, 3)), np.array([[0, 1, 2], [1, 2, 3]], np.int32), "chamber")
    }
    provenance = {"seed": 1, "kernel_digest": "none", "versions": {"numpy": "2"}}
    recorder = Recorder.create(path, case.to_toml(), provenance, names, RATE, axes=axes, walls=walls)
    known = {"time": time, "crank_angle": 60.0 * time, "driveshaft_speed": np.full_like(time, 60.0)}
    series = [
        known.get(name, 100.0 + 20.0 * np.cos(120.0 * time + place)) for place, name in enumerate(names)
    ]
    recorder.append(np.stack(series, axis=1))
    for k in range(3):
        poses = {
            "body_positions": np.zeros((len(BODIES), 3)),
            "body_attitudes": np.tile([1.0, 0, 0, 0], (len(BODIES), 1)),
        }
        positions = (0.05 * draw.random((40, 3)) - [0.0, 0.0, 0.3]).astype(np.float32)
        particles = {
            "positions": positions,
            "velocities": positions,
            "radii": np.full(40, 0.0025, np.float32),
        }
        chamber = {
            "chamber_floor": np.array([0.0, 0.0, -0.35]),
            "chamber_attitude": np.array([1.0, 0.0, 0.0, 0.0]),
        }
        recorder.snapshot(0.5 + 0.05 * k, poses | particles | chamber)
    sizes = {name: len(line) for name, line in axes.items()} | {"patch": len(axes.get("patch_area", ()))}
    for at in (0.3, 0.6):
        sums = {}
        for field in STATISTICS:
            parts = [part.strip() for part in field.shape.strip("()").split(",") if part.strip()]
            if all(sizes.get(part) for part in parts):
                shape = [sizes[part] for part in parts]
                sums[field.name] = np.float64(at) * (1.0 + np.zeros(shape))
        recorder.statistics(at, sums)
        arrays = {
            "time": np.array([at]),
            "velocity": draw.random((7, 3)),
            "rows": np.arange(40, dtype=np.int32),
        }
        recorder.checkpoint(at, {"mechanism": arrays}, {"windows": 7})
    recorder.summary({"substep": 1e-6, "particles": 40})
    recorder.state("complete")
    recorder.close()
    return path


def _axes() -> dict[str, np.ndarray]:
    """What the statistics lie along: two cells of each."""
    return {
        "pair": np.array(["steel-steel", "steel-acrylic wall"]),
        "part": np.array(["normal", "tangential"]),
        "energy": 2.0 ** (np.arange(8) - 20.0),
        "radius": np.array([0.02, 0.05]),
        "azimuth": (np.arange(12) + 0.5) * math.tau / 12,
        "height": np.arange(4) * 0.01 + 0.005,
        "cell_volume": np.full((2, 4), 1e-6),
        "neighbours": np.arange(16),
        "patch_surface": np.array(["bore"] * 4 + ["floor"]),
        "patch_column": np.array([0, 0, 1, 1, 0]),
        "patch_azimuth": np.array([0.5, 0.5, 3.5, 3.5, 1.0]),
        "patch_along": np.array([0.05, 0.15] * 2 + [0.03]),
        "patch_area": np.array([2.0] * 4 + [0.0]),
    }


def content(path: Path) -> list[Any]:
    """Everything that the readers of a result get, part by part; of a part that is refused the words
    "refused".
    """
    with open_result(path) as result:
        parts: list[Callable[[], Any]] = [
            lambda: (
                result.case_text,
                result.state,
                result.rate,
                result.reached,
                result.summary,
                repr(result.provenance),
            ),
            lambda: [
                (str(name), one.values.tobytes(), one.attrs) for name, one in result.series.variables.items()
            ],
            lambda: [
                (str(name), one.values.tolist(), one.attrs)
                for name, one in result.statistics.variables.items()
            ],
            lambda: [
                {name: np.asarray(array).tobytes() for name, array in moment.items()}
                for moment in result.snapshots
            ],
            lambda: [
                (name, mesh.vertices.tobytes(), mesh.triangles.tobytes())
                for name, mesh in result.walls.items()
            ],
            lambda: _bits(result.checkpoint()),
        ]
        return [_or_refused(part) for part in parts]


def _bits(checkpoint: Any) -> tuple:
    arrays = {
        f"{group}/{name}": a.tobytes() for group, one in checkpoint.groups.items() for name, a in one.items()
    }
    return checkpoint.time, checkpoint.attributes, arrays


def _or_refused(part: Callable[[], Any]) -> Any:
    try:
        return part()
    except MillError as error:
        assert "\n" not in str(error) or "checkpoint" in str(error), f"more than one sentence: {error}"
        return "refused"


def _read(path: Path, command: str, true: list[Any] | None) -> None:
    """Read everything through Python, reopen a copy for writing, and give the file to a command; `true`: what
    must come out.
    """
    try:
        found = content(path)
    except MillError:
        found = []
    if true is not None:
        for part, (one, other) in enumerate(zip(found, true, strict=False)):
            if one != "refused" and repr(one) != repr(other):
                with open_result(path) as result:
                    passed_over = part == len(true) - 1 and result.damaged_checkpoints()
                assert passed_over, f"used without a word: part {part}"
    if not command:
        return
    with suppress(MillError):
        verify(path)
    copy = path.with_name("copy.h5")
    copy.write_bytes(path.read_bytes())
    with suppress(MillError):
        Recorder.reopen(copy, 0.6).close()
    words = {
        "export": [str(path), "--vtkhdf", str(path.with_suffix(".vtkhdf"))],
        "plot": [str(path), "run", "power", "impacts", "wall", "flow", "orbit"],
        "compare": [str(path), str(path)],
    }
    done = CliRunner().invoke(app, [command, *words.get(command, [str(path)])])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    if done.exit_code:
        raise ResultError(done.output.strip().splitlines()[-1])


# damages: each changes one thing


def _bit(raw: bytearray, first: int, length: int, draw: random.Random) -> None:
    raw[first + draw.randrange(length)] ^= 1 << draw.randrange(8)


def _bit_anywhere(path: Path, draw: random.Random) -> None:
    raw = bytearray(path.read_bytes())
    _bit(raw, 0, len(raw), draw)
    path.write_bytes(raw)


def _bit_in_numbers(path: Path, draw: random.Random) -> None:
    """Flip a bit in the stored block of a dataset, most often of a checkpoint or of the statistics."""
    with h5py.File(path, "r") as file:
        names = [name for name in _names(file) if isinstance(file[name], h5py.Dataset)]
        part = draw.choice(("checkpoints", "statistics", "s", ""))
        data = file[draw.choice([name for name in names if name.startswith(part)])]
        place = (data.id.get_offset(), data.id.get_storage_size())
        if data.chunks is not None and data.id.get_num_chunks():
            block = data.id.get_chunk_info(draw.randrange(data.id.get_num_chunks()))
            place = (block.byte_offset, block.size)
    if place[0] is not None and place[1]:
        raw = bytearray(path.read_bytes())
        _bit(raw, *place, draw)
        path.write_bytes(raw)


def _bit_in_case_text(path: Path, draw: random.Random) -> None:
    raw = bytearray(path.read_bytes())
    with h5py.File(path, "r") as file:
        text = file["case"][()]
    _bit(raw, raw.index(text), len(text), draw)
    path.write_bytes(raw)


def _bytes_overwritten(path: Path, draw: random.Random) -> None:
    raw = bytearray(path.read_bytes())
    first, length = draw.randrange(len(raw)), draw.choice((1, 4, 64, 512, 4096))
    raw[first : first + length] = draw.randbytes(len(raw[first : first + length]))
    path.write_bytes(raw)


def _cut_off(path: Path, draw: random.Random) -> None:
    os.truncate(path, draw.randrange(path.stat().st_size))


def _object_missing(path: Path, draw: random.Random) -> None:
    with h5py.File(path, "r+") as file:
        del file[draw.choice(_names(file))]


def _attribute_missing(path: Path, draw: random.Random) -> None:
    with h5py.File(path, "r+") as file:
        thing = _with_attributes(file, draw)
        del thing.attrs[draw.choice(list(thing.attrs))]


def _attribute_odd(path: Path, draw: random.Random) -> None:
    with h5py.File(path, "r+") as file:
        thing = _with_attributes(file, draw)
        thing.attrs[draw.choice(list(thing.attrs))] = draw.choice(ODD)


def _length_odd(path: Path, draw: random.Random) -> None:
    """Give datasets other lengths, without writing numbers: one of them, or all of a group."""
    with h5py.File(path, "r+") as file:
        group = file[draw.choice(("series", "snapshots", "statistics"))]
        datasets = [data for data in group.values() if isinstance(data, h5py.Dataset)]
        length = draw.choice(LENGTHS)
        for data in datasets if draw.random() < 0.5 else [draw.choice(datasets)]:
            data.resize(length, axis=0)


def _type_odd(path: Path, draw: random.Random) -> None:
    """Put another kind of object in the place of one."""
    with h5py.File(path, "r+") as file:
        name = draw.choice([name for name in _names(file) if name.count("/") < 3])
        del file[name]
        kind = draw.randrange(5)
        if kind == 0:
            file.create_group(name)
        elif kind == 1:
            file[name] = "text"
        elif kind == 2:
            file[name] = np.array([(1, 2.0)], [("a", "i4"), ("b", "f8")])
        elif kind == 3:
            file.create_dataset(name, (10**13,), "f8", chunks=(1024,))
        else:
            file[name] = np.full((3, 2), np.nan)


def _foreign_storage(path: Path, draw: random.Random) -> None:
    with h5py.File(path, "r+") as file:
        name = draw.choice(_names(file))
        del file[name]
        kind = draw.randrange(3)
        if kind == 0:
            file[name] = h5py.ExternalLink(str(path.parent.parent / "sound.h5"), "/" + name)
        elif kind == 1:
            file[name] = h5py.SoftLink("/series/time")
        else:
            file.create_dataset(name, (100,), "f8", external=[(str(path.parent.parent / "sound.h5"), 0, 800)])


DAMAGES: tuple[Callable[[Path, random.Random], None], ...] = (
    _bit_anywhere,
    _bit_in_numbers,
    _bit_in_case_text,
    _bytes_overwritten,
    _cut_off,
    _object_missing,
    _attribute_missing,
    _attribute_odd,
    _length_odd,
    _type_odd,
    _foreign_storage,
)
"""The ways in which a file is damaged."""


# guises: which checksums the damaged file has


def _as_it_was(path: Path, damage: Callable[[Path, random.Random], None], draw: random.Random) -> None:
    damage(path, draw)


def _with_new_checksums(
    path: Path, damage: Callable[[Path, random.Random], None], draw: random.Random
) -> None:
    damage(path, draw)
    with suppress(Exception), h5py.File(path, "r+") as file:
        _reseal(file)


def _as_format_1(path: Path, damage: Callable[[Path, random.Random], None], draw: random.Random) -> None:
    with h5py.File(path, "r+") as file:
        for name in COPIES:
            del file[name]
        file.attrs["format_version"] = FORMAT_VERSION - 1
    damage(path, draw)


GUISES = (_as_it_was, _with_new_checksums, _as_format_1)
"""What the checksums of the damaged file are."""


def _reseal(file: h5py.File) -> None:
    """Write checksums for what the file holds now; where content is too long or unreadable, for its shape
    alone.
    """
    old = Checksums.read(file)
    new = Checksums({}, old.moments)
    for name in ["", *_names(file)]:
        thing = file[name or "/"]
        if isinstance(thing, h5py.Dataset) and thing.nbytes > 2**24:
            entry = old.entries.get(name)
            if entry is not None:
                new.entries[name] = entry._replace(shape=thing.shape, dtype=thing.dtype.str)
        else:
            with suppress(Exception):
                new.take_one(file, name)
    new.write(file)


def _names(file: h5py.File) -> list[str]:
    """Paths of all objects but the checksums, without following links."""
    names: list[str] = []
    file.id.links.visit(lambda name: names.append(name.decode()))
    return [name for name in names if name not in COPIES]


def _with_attributes(file: h5py.File, draw: random.Random) -> h5py.HLObject:
    """The root group or another object that has attributes."""
    things = [file, file, *(file[name] for name in _names(file) if len(file[name].attrs))]
    return draw.choice(things)
