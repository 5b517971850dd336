"""Nutating mills: multibody dynamics of the machine, coupled with the particles inside.

    import nutamill as nm
    case = nm.load_case("numill").with_("drive.speed", "500 rpm")
    result = nm.run(case, to="first.h5")

The names below are loaded when they are first used: to read a result needs no compiler, and ``--help`` no
NumPy.
"""

import importlib
from typing import Any

__version__ = "0.2.0"

_FACE = {
    "base.errors": "MillError CaseError StepError NotSteadyError ResultError DamagedError",
    "case": "Case Machine load_case library_names",
    "mechanism.parts": "GROUND Body Joint JointKind",
    "mechanism.system": "System",
    "charge.face": "Charge linear_pair",
    "charge.laws.composition": "contact_law",
    "charge.particles.particles": "spheres",
    "charge.walls.surface": "plane",
    "notebook.runs": "run resume",
    "result": "open_result verify",
    "analysis.windows": "steady_mean",
    "analysis.steady_table": "steady",
    "analysis.power": "power_split",
    "analysis.load_paths": "load_paths loads_lines hodograph",
    "analysis.rods": "yoke_rods rods_lines",
    "analysis.mounts": "mounts_lines floor_force chamber_clearance clearance_line",
    "analysis.ratings": "load_ratings",
    "analysis.bearings": "bearing_life bearings_lines",
    "analysis.fatigue": "section_life sections_lines",
    "analysis.flow": "charge_window loading_spectra wear_table",
    "analysis.orders": "peaks",
    "analysis.breakage.ore": "load_ore",
    "analysis.breakage.impacts": "grinding_of",
    "analysis.breakage.answer": "breakage breakage_lines comparison_lines",
    "analysis.wear": "liner_of wall_wear by_surface wear_lines",
    "analysis.mount_test": "mount_properties",
    "view.figures.shown": "plot",
    "view.figures.named": "write_figures",
    "view.figures.motion": "draw_histories",
    "view.figures.reading": "draw_loads draw_floor draw_lives",
    "view.figures.breakage": "draw_breakage",
    "view.figures.wear": "draw_wear",
    "view.webview": "write_view",
    "view.inline": "view",
    "design.check": "check",
    "design.campbell": "avoid_lines campbell",
    "design.modes": "machine_modes modes_lines",
    "design.sticks": "sticks",
    "design.runup": "run_up run_up_lines",
    "design.isolation": "isolation isolation_lines",
    "design.balancing": "balance_mill balance_lines",
    "design.figures": "draw_balancing draw_modes draw_campbell draw_isolation draw_run_up",
    "studies.sweep": "sweep",
    "studies.fit": "fit",
    "studies.validate": "validate",
    "studies.identify.identify": "identify",
}
"""Module of the package: the public names that it holds."""

_HOME = {name: f"nutamill.{module}" for module, names in _FACE.items() for name in names.split()}
_NAME_THERE = {"charge_window": "window", "view": "inline_view"}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'nutamill' has no attribute '{name}'")
    value = getattr(importlib.import_module(_HOME[name]), _NAME_THERE.get(name, name))
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
