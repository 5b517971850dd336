"""A machine with its charge as an FMU: bits of a run with meshes as walls, with clumps, with films."""

import shutil

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.export.fmu.write import export_machine

pytest.importorskip("fmpy", reason="needs the extra fmu")
trimesh = pytest.importorskip("trimesh", reason="needs the extra mesh")
from fmu_session import marched, opened, recorded_rows  # noqa: E402

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]

MESH = """
[[walls]]
name     = "crown"
body     = "piston"
material = "steel"
shape    = "mesh"
file     = "crown.stl"
unit     = "mm"
side     = "outside"
point    = ["0 mm", "0 mm", "-10 mm"]

[[walls]]
name     = "liner"
material = "slick"
shape    = "cylinder"
radius   = "30 mm"
"""
CLUMPS = """
[charge]
kind     = "clumps"
shapes   = "coarse-sand"
diameter = "6 mm"
count    = 60
material = "steel"
"""
FILM = """
[contact]
film = "viscous"

[contact.pairs.steel-steel]
liquid_viscosity = "50 mPa s"
film_thickness   = "50 um"
film_roughness   = "1 um"

[contact.pairs.steel-slick]
liquid_viscosity = "50 mPa s"
film_thickness   = "50 um"
film_roughness   = "1 um"
"""


@pytest.mark.parametrize(
    ("text", "changes"),
    [
        pytest.param(MESH, ["charge.count=60"], id="mesh"),
        pytest.param(CLUMPS, [], id="clumps"),
        pytest.param(FILM, ["charge.count=60"], id="film"),
    ],
)
def test_every_series_has_the_bits_of_a_run(tmp_path, text, changes):
    (tmp_path / "crown.stl").write_bytes(trimesh.creation.box((100.0, 100.0, 20.0)).export(file_type="stl"))
    head = 'schema = 1\nbase = "piston"\n'
    (tmp_path / "case.toml").write_text(head + text, encoding="utf-8")
    run = ['run.until="20 ms"', 'run.series_rate="1000 Hz"', "run.threads=1"]
    case = load_case(tmp_path / "case.toml", [*changes, *run])
    names, values = recorded_rows(case, tmp_path / "run.h5")
    unit, places = opened(export_machine(case.machine, tmp_path / "machine.fmu", "whole"))
    rows = marched(unit, [places[name] for name in names], len(values) - 1, 1e-3)
    differ = [name for k, name in enumerate(names) if not np.array_equal(rows[:, k], values[1:, k])]
    assert not differ
    assert np.abs(values[-1, names.index("piston_charge_force_z")]) > 0.0
