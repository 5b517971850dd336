"""Mesh files that were damaged at random, and heads that promise what the file does not hold."""

import functools
import hashlib
import random
import struct
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.case import load_case
from nutamill.case.machine import Machine
from nutamill.simulation.setup.walls import wall_mesh

SIZE = 10.0
"""Edge of the cube that the sound files hold [mm]."""
CORNERS = [(x, y, z) for x in (0.0, SIZE) for y in (0.0, SIZE) for z in (0.0, SIZE)]
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
TRIANGLES = [corner for a, b, c, d in QUADS for corner in ((a, b, c), (a, c, d))]
NUMBERS = (float("nan"), float("inf"), -float("inf"), 1e38, 1e-45, -0.0, 1e300)
COUNTS = (0, 1, 2**31, 2**32 - 1, 10**8, 11, 13)
"""Numbers of triangles that a head promises [1]."""
LINES = (
    "mtllib ../../etc/passwd",
    "usemtl x",
    "f 1 2 9999999",
    "f 0 0 0",
    "f -1 -2 -3",
    "v nan nan nan",
    "v 1e999 0 0",
    "o \x00",
)


class HostileMesh(NamedTuple):
    """A mesh file."""

    group: str
    """What was done to it, for the table."""
    name: str
    """Which one it is."""
    suffix: str
    """``.stl`` or ``.obj``."""
    content: bytes
    """What it holds."""


def binary(draw: random.Random | None = None) -> bytes:
    """Return a cube as binary STL; with random numbers one coordinate is none, or the head promises another
    number.
    """
    count, rows = (
        len(TRIANGLES),
        [[0.0] * 3 + [value for k in three for value in CORNERS[k]] for three in TRIANGLES],
    )
    if draw is not None:
        if draw.random() < 0.5:
            count = draw.choice(COUNTS)
        else:
            rows[draw.randrange(len(rows))][draw.randrange(12)] = draw.choice(NUMBERS[:6])
    body = b"".join(struct.pack("<12fH", *row, 0) for row in rows)
    return b"made".ljust(80) + struct.pack("<I", count) + body


def ascii_stl() -> bytes:
    """Return the cube as text STL."""
    lines = ["solid made"]
    for three in TRIANGLES:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex {} {} {}".format(*CORNERS[k]) for k in three)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid made", ""]).encode()


def obj(draw: random.Random | None = None) -> bytes:
    """Return the cube as OBJ; with random numbers a hostile line stands in it."""
    lines = ["v {} {} {}".format(*corner) for corner in CORNERS] + [
        "f {} {} {}".format(*(k + 1 for k in t)) for t in TRIANGLES
    ]
    if draw is not None:
        lines.insert(draw.randrange(len(lines)), draw.choice(LINES))
    return "\n".join([*lines, ""]).encode()


def attempts(number: int, seed: int) -> Iterator[tuple[str, str, Callable[[], Any]]]:
    """Yield the group, the name and the reading of so many hostile meshes."""
    with tempfile.TemporaryDirectory() as folder:
        machines = {suffix: machine_with_wall(Path(folder) / f"wall{suffix}") for suffix in (".stl", ".obj")}
        for mesh in hostile_meshes(number, seed):
            yield mesh.group, mesh.name, functools.partial(placed, mesh, machines[mesh.suffix])


def hostile_meshes(number: int, seed: int) -> Iterator[HostileMesh]:
    """Yield mesh files with one damage each."""
    draw = random.Random(seed)
    for count in range(number):
        suffix, content = draw.choice(((".stl", binary()), (".stl", ascii_stl()), (".obj", obj())))
        damage = draw.choice(("numbers", "bits", "cut off", "noise", "doubled", "other suffix"))
        if damage == "numbers":
            suffix, content = draw.choice(((".stl", binary(draw)), (".obj", obj(draw))))
        elif damage == "bits":
            changed = bytearray(content)
            for _ in range(draw.randint(1, 8)):
                changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
            content = bytes(changed)
        elif damage == "cut off":
            content = content[: draw.randrange(len(content))]
        elif damage == "noise":
            content = draw.randbytes(draw.choice((0, 1, 83, 84, 85, 134, 2000)))
        elif damage == "doubled":
            content += content
        else:
            suffix = ".obj" if suffix == ".stl" else ".stl"
        yield HostileMesh(damage, f"mesh {count} of seed {seed}: {damage}", suffix, content)


def machine_with_wall(file: Path) -> Machine:
    """Return the published mill with a wall from `file`, which is made empty."""
    file.touch()
    wall = f"{{ file = '{file}', unit = 'mm', at = ['0 m', '0 m', '-340 mm'], material = 'steel' }}"
    return load_case("numill", [f"walls=[{wall}]"]).machine


def placed(mesh: HostileMesh, machine: Machine) -> None:
    """Read a mesh as the last wall of a machine.

    The wall is as one that was loaded with this mesh: loading the case takes four times as long as the mesh.

    Raises
    ------
    CaseError : the mesh is refused
    """
    wall = machine.walls[-1]
    Path(wall.file).write_bytes(mesh.content)
    digest = hashlib.sha256(mesh.content).hexdigest()
    wall_mesh(machine, wall.model_copy(update={"sha256": digest}))
