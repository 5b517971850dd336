"""Every quick example runs, and what it checks of itself, against a closed form or another method, holds."""

import re
import runpy
import shutil
from pathlib import Path

import pytest

SLOW = {"balancing", "grinding", "modes", "mounts", "run_up"}
"""Left to be run by hand: many runs each, whose parts `test_design`, `test_running_modes`, `test_breakage`
and `test_wear` hold.
"""
FMI = {"fmu_export", "fmu_machine", "fmu_motor"}
"""Need the extra fmu and a C compiler."""
EXAMPLES = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.external] if path.stem in FMI else [])
    for path in sorted((Path(__file__).parents[2] / "examples").glob("*.py"))
    if path.stem not in SLOW
]
PINNED = {
    "empty_mill": ("100 rpm: 14.5 N", "400 rpm: 231.7 N"),
    "moving_charge": ("ledger open by 0.000 %", "moving.html"),
}
"""What the examples without a check of their own say that they print."""

PRINTED = Path(__file__).parents[2] / "docs" / "printed"
"""What the gallery shows that the examples print, as tools/gallery.py writes it."""


def words(text):
    """Return the words of a text without its numbers, whose last digits are those of a processor."""
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", text).split()


@pytest.mark.parametrize("path", EXAMPLES)
def test_example_holds_what_it_checks_of_itself(path, tmp_path, monkeypatch, capsys):
    if path.stem in FMI:
        pytest.importorskip("fmpy", reason="needs the extra fmu")
        if shutil.which("cc") is None:
            pytest.skip("needs a C compiler")
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    printed = capsys.readouterr().out
    shown = PRINTED / f"{path.stem}.txt"
    assert not shown.is_file() or words(shown.read_text(encoding="utf-8")) == words(printed)
    assert all(text in printed for text in PINNED.get(path.stem, ()))
    assert path.stem in PINNED or "assert " in path.read_text(encoding="utf-8")
    drawn = [*tmp_path.rglob("*.png"), *tmp_path.rglob("*.html")]
    assert drawn and all(file.stat().st_size > 5000 for file in drawn)
