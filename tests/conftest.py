"""Shares the tests out to two processes, so that no kernel is compiled by both at once.

A plain `pytest`, or one that is given folders, runs in two processes; one that is given files or names of
tests runs in one, as does one with a debugger.  ``-n`` decides otherwise.  Without pytest-xdist all tests
run in one process.
"""

import fnmatch
from pathlib import Path

import pytest

WORKERS = 2
"""Processes of a run of whole folders."""

SHARED = {
    "charge in double precision": (
        "verification/test_charge_*",
        "verification/test_coupling_*",
        "unit/test_charge_face*",
        "unit/test_charge_parts*",
        "unit/test_walls*",
    ),
    "mills with a charge": (
        "unit/test_march.py",
        "unit/test_size_classes.py",
        "unit/test_cache.py",
        "unit/test_quick.py",
        "unit/test_build.py",
        "unit/test_wall_files.py",
        "verification/test_mill_*",
        "verification/test_examples.py",
    ),
    "mechanisms": (
        "unit/test_mechanism_*",
        "verification/test_mechanism_*",
        "verification/test_running_modes.py",
    ),
}
"""Files whose tests compile the same kernels: one process runs them.  Any other file is its own group."""


def group_of(path: Path) -> str:
    """Return the group of a test file: its tests run in one process, one after the other."""
    name = path.relative_to(Path(__file__).parent).as_posix()
    for group, patterns in SHARED.items():
        if any(fnmatch.fnmatch(name, pattern) for pattern in patterns):
            return group
    return name


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """Ask pytest-xdist for two processes if whole folders are run."""
    if not config.pluginmanager.hasplugin("xdist") or hasattr(config, "workerinput"):
        return
    if config.option.numprocesses is not None:
        return
    folders = any(Path(argument).is_dir() for argument in config.args)
    if folders and not config.option.usepdb and not config.option.collectonly:
        config.option.numprocesses, config.option.dist = WORKERS, "loadscope"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Send all tests of a group to the same process."""
    from xdist.scheduler import LoadScopeScheduling

    class ByGroup(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return group_of(config.rootpath / nodeid.split("::")[0])

    return ByGroup(config, log)
