"""What the README, the documentation and the messages advise a user to install can be installed from a
clone.
"""

import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

from nutamill.base.errors import missing_extra

ROOT = Path(__file__).parents[2]
TEXTS = [
    ROOT / "README.md",
    *(path for path in (ROOT / "docs").rglob("*.md") if "generated" not in path.parts),
    *(ROOT / "src").rglob("*.py"),
    *(ROOT / "examples").rglob("*.py"),
]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "optional-dependencies"
]
ASKED = re.compile(r"""(?:pip install [^\n]*?\.\[|missing_extra\([^\n]*, ")([a-z, ]+)(?:\]|"\))""")


def blocks(text):
    """Return the blocks of a text that name no language: what is typed."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return [block for language, block in fenced if not language]


def test_nobody_is_sent_to_an_index_that_does_not_have_the_package():
    assert [
        path.name
        for path in TEXTS
        if re.search(r"pip install [\"']?nutamill", path.read_text(encoding="utf-8"))
    ] == []
    assert str(missing_extra("a film", "ffmpeg", "view")).endswith(
        'Type in your clone of the nutamill repository: pip install ".[view]"'
    )


def test_every_extra_that_is_advised_exists():
    advised = {
        extra.strip()
        for path in TEXTS
        for extras in ASKED.findall(path.read_text(encoding="utf-8"))
        for extra in extras.split(",")
    }
    assert {"view", "mesh", "life", "daq", "cluster", "dev"} <= advised <= set(EXTRAS)


def test_the_readme_names_every_extra():
    named = set(re.findall(r"^\| `(\w+)` \|", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE))
    assert named == set(EXTRAS)


def test_the_first_commands_of_the_readme_activate_the_environment_before_they_use_the_package():
    commands = [
        line.split("#")[0].strip()
        for line in blocks((ROOT / "README.md").read_text(encoding="utf-8"))[0].splitlines()
    ]
    assert commands == [
        "python3 -m venv .venv",
        ". .venv/bin/activate",
        "pip install .",
        "nutamill run numill",
    ]


def commands_of_ci():
    """Return the commands of the continuous integration that install and test."""
    lines = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if "pip install" in line or "pytest" in line.split()]


def test_the_readme_and_the_continuous_integration_run_the_same_test_commands():
    first, *others = commands_of_ci()
    texts = blocks((ROOT / "README.md").read_text(encoding="utf-8"))
    assert f"{first.removesuffix(' || exit')}\n" in texts
    assert "\n".join(others) + "\n" in texts


@pytest.mark.skipif(os.name != "posix", reason="the script is run by bash")
@pytest.mark.parametrize("failing", [1, 2, 3, 4, 5, 6, None])
def test_the_continuous_integration_stops_at_the_first_command_that_fails(tmp_path, failing):
    # the Python and the pip of this clone count their calls, and one of the calls fails
    clone, tools = tmp_path / "clone", tmp_path / "tools"
    for folder in (clone / ".ci", clone / ".venv/bin", tools):
        folder.mkdir(parents=True)
    shutil.copy(ROOT / ".ci/run", clone / ".ci/run")
    stub = f'#!/bin/sh\necho "$*" >> calls\n[ $(wc -l < calls) -ne {failing or 0} ] || exit 7\n'
    for program in (tools / "python3", clone / ".venv/bin/python", clone / ".venv/bin/pip"):
        program.write_text(stub, encoding="utf-8")
        program.chmod(0o755)
    path = f"{tools}{os.pathsep}{os.environ['PATH']}"
    ended = subprocess.run(["bash", clone / ".ci/run"], env=os.environ | {"PATH": path}, check=False)
    calls = (clone / "calls").read_text(encoding="utf-8").splitlines()
    assert (ended.returncode, len(calls)) == ((7, failing) if failing else (0, 6)), calls
    assert calls[-1] == "-m pytest -m external" or failing
