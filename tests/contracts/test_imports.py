"""The house as drawn: who may import whom, and which outside library belongs in which room."""

import ast
import pathlib
import subprocess
import sys

import pytest

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent

FLOOR = {
    **dict.fromkeys(("source_code", "cachefolder", "child", "signals"), 0),
    **dict.fromkeys(("errors", "files", "host", "units", "kernel", "keys", "steady"), 1),
    **dict.fromkeys(
        ("frames", "fields", "forecast", "tables", "wholefile", "provenance", "screen", "running"), 2
    ),
    "materials": 3,
    **dict.fromkeys(("mechanism", "charge", "machine"), 4),
    **dict.fromkeys(("coupling", "case"), 5),
    **dict.fromkeys(("result", "build", "warm", "mount_test"), 6),
    **dict.fromkeys(
        ("analysis", "mechanism_analysis", "dialects", "preflight", "mechanism_preflight", "watch", "record_plan", "campaign_report"), 7
    ),
    **dict.fromkeys(("replay", "vibration", "drawing"), 7),
    "advance": 8,
    **dict.fromkeys(("charge_flow", "quantities", "readings", "webview", "scene", "export", "measured"), 8),
    **dict.fromkeys(("march", "bench", "papers"), 9),
    "design": 10,
    "figures": 11,
    **dict.fromkeys(("campaign", "report"), 12),
    "validation": 13,
    "cli": 14,
    "__main__": 15,
}
"""A room imports from lower floors and from itself only."""

MILL = {"machine", "materials", "units", "case"}
ENGINES = {"kernel", "frames", "mechanism", "charge", "coupling", "build", "warm", "advance", "march"}
NEVER = {
    "mechanism": {"charge", *MILL},
    "charge": {"mechanism", *MILL},
    "coupling": MILL,
    "result": ENGINES,
    "analysis": ENGINES,
    "steady": ENGINES,
    "mount_test": ENGINES,
    "mechanism_analysis": ENGINES,
    "charge_flow": ENGINES,
    "figures": ENGINES,
    "papers": ENGINES,
    "quantities": ENGINES,
    "readings": ENGINES,
    "screen": ENGINES,
    "drawing": ENGINES,
    "replay": ENGINES,
    "webview": ENGINES,
    "scene": ENGINES,
    "export": ENGINES,
    "vibration": ENGINES,
    "measured": ENGINES,
    "report": ENGINES,
    "campaign_report": ENGINES,
}
"""Engines know no mill; what reads results needs no engine."""

AT_HOME = {
    "numba": {"kernel.py", "charge/kernels/simd.py", "charge/kernels/team.py"},
    "llvmlite": {"kernel.py", "charge/kernels/simd.py", "charge/kernels/team.py"},
    "h5py": {"result", "export"},
    "matplotlib": {"figures", "report.py"},
    "tomllib": {"case"},
    "pydantic": {"case", "machine.py", "materials.py", "tables.py", "papers"},
    "pydantic_core": {"tables.py"},
    "typer": {"cli"},
    "rich": {"screen.py", "studies/board.py", "papers"},
    "distributed": {"campaign", "validation.py"},
    "trimesh": {"simulation/setup/walls.py"},
    "rainflow": {"analysis/fatigue.py"},
    "pyvista": {"scene.py"},
    "imageio_ffmpeg": {"scene.py"},
}
"""Outside libraries that belong in some rooms only."""

FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def imports(path):
    """Dotted names a file imports, those within functions too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name}:{node.lineno}: write imports in full"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names if node.module == "nutamill")


def room(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def named(path):
    return str(path.relative_to(PACKAGE))


@pytest.mark.parametrize("path", FILES, ids=named)
def test_a_room_imports_from_lower_floors_only(path):
    here = room(path)
    assert here in FLOOR, f"give {here} a floor"
    rooms = {name.split(".")[1] for name in imports(path) if name.startswith("nutamill.")} - {here, "__version__"}
    assert not {name for name in rooms if FLOOR[name] >= FLOOR[here]}
    assert not rooms & NEVER.get(here, set())


@pytest.mark.parametrize("path", FILES, ids=named)
def test_an_outside_library_stays_in_its_room(path):
    outside = {name.split(".")[0] for name in imports(path)}
    homes = {library: rooms for library, rooms in AT_HOME.items() if library in outside}
    assert not {library for library, rooms in homes.items() if not rooms & {named(path), path.relative_to(PACKAGE).parts[0]}}


def test_reading_a_case_or_a_result_loads_no_compiler():
    program = "import sys, nutamill as nm; nm.load_case('numill'); nm.open_result; print('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == "False\n"
