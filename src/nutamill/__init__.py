"""Nutating mills: multibody dynamics of the machine, coupled with the particles inside.

    import nutamill as nm
    case = nm.load_case("numill").with_(drive__speed="500 rpm")
    result = nm.run(case, to="first.h5")

The names below are loaded when they are first used: to read a result needs no compiler, and ``--help`` no
NumPy.
"""

import importlib
from typing import Any

__version__ = "0.2.0"

_HOME = {
    "Case": "nutamill.case",
    "MechanismCase": "nutamill.case",
    "load_case": "nutamill.case",
    "library_names": "nutamill.case",
    "check": "nutamill.design.preflight",
    "System": "nutamill.mechanism.system",
    "run": "nutamill.simulation.march",
    "resume": "nutamill.simulation.march",
    "sweep": "nutamill.studies.sweep",
    "steady_mean": "nutamill.analysis.windows",
    "power_split": "nutamill.analysis.power",
    "load_paths": "nutamill.analysis.load_paths",
    "fit": "nutamill.studies.fit",
    "Charge": "nutamill.charge.face",
    "linear_pair": "nutamill.charge.face",
    "spheres": "nutamill.charge.particles.particles",
    "plane": "nutamill.charge.walls.surface",
    "mount_properties": "nutamill.analysis.mount_test",
    "open_result": "nutamill.result",
    "validate": "nutamill.studies.validate",
    "MillError": "nutamill.base.errors",
    "CaseError": "nutamill.base.errors",
    "StepError": "nutamill.base.errors",
    "NotSteadyError": "nutamill.base.errors",
    "ResultError": "nutamill.base.errors",
    "DamagedError": "nutamill.base.errors",
    "verify": "nutamill.result",
}
_NAME_THERE = {"check": "preflight"}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'nutamill' has no attribute '{name}'")
    found = getattr(importlib.import_module(_HOME[name]), _NAME_THERE.get(name, name))
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
