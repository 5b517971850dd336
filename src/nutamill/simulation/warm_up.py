"""Compile the kernels once, the two engines at the same time in two processes.

Compiled code is stored in the user's cache folder (`nutamill.base.kernel`), so that this happens after an
installation or a change of the kernels, and not again.  What is compiled depends on the kinds of arrays and
on the contact law only, not on the mill: a ball on a turntable will do.
"""

import subprocess
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

import numpy as np

from nutamill.base.cache_folder import cache_trouble
from nutamill.base.child import ended, start_child, task_of_parent
from nutamill.base.kernel import JIT, compiled_mark
from nutamill.charge.assembly import charge as charge_arrays
from nutamill.charge.face import Charge, at_rest
from nutamill.charge.kernels.dynamics import start
from nutamill.charge.kernels.neighbours import rebuild
from nutamill.charge.kernels.team import run_team
from nutamill.charge.laws.composition import STANDARD_LAW, ContactLaw, contact_law, law_names
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.measures.observe import charge_reading, observe
from nutamill.charge.measures.sampling import sample
from nutamill.charge.measures.statistics import charge_statistics, statistics_plan
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind
from nutamill.mechanism.sensors import Sensor, SensorKind, sensor_table
from nutamill.simulation.coupling import march_coupled, march_mechanism
from nutamill.simulation.coupling_model import (
    CoupledModel,
    CoupledState,
    CouplingPlan,
    Scheme,
    coupled_scratch,
    coupling_state,
)
from nutamill.simulation.progress_report import COMPILING
from nutamill.simulation.row import RowTable, row_groups

STEP = 1e-6
"""Window of the ball on the turntable [s]."""


def warm_up(
    log: Callable[[str], None] | None = None,
    meanwhile: Callable[[], subprocess.Popen] | None = None,
    law: ContactLaw = STANDARD_LAW,
) -> None:
    """Compile the kernels of an empty and of a staggered run, if this version has not been compiled here
    before.

    Parameters
    ----------
    log : receives one line before compiling begins
    meanwhile : starts a process that needs the charge's kernels only, while the coupled ones are being
        compiled
    law : of the contacts; each has kernels of its own
    """
    names = law_names(law)
    if not _begins(compiled_mark(*names), log):
        return
    with ExitStack() as children:
        charge_compiler = start_child(
            "from nutamill.simulation.warm_up import compile_charge; compile_charge()", names
        )
        children.enter_context(ended(charge_compiler))
        list_balls(names)  # first: the other process needs them a little later
        march_turntable()
        read_ball(names)
        charge_compiler.wait()
        process = meanwhile() if meanwhile is not None else None
        if process is not None:
            children.enter_context(ended(process))
        march_both(names)
        if process is not None:
            process.wait()
    _set(compiled_mark(*names))


def is_compiled(law: ContactLaw | None, engine: str | None = None) -> bool:
    """Return whether the kernels of runs with a contact law, or without a charge if None, are compiled, those
    for a charge in another `engine` included.
    """
    if not JIT:
        return False
    if law is not None and engine is not None:
        return compiled_mark(engine, *law_names(law)).is_file()
    standard = law_names(STANDARD_LAW)
    marks = [law_names(law)] if law is not None else [("mechanism",), standard]
    return any(compiled_mark(*names).is_file() for names in marks)


def warm_up_mechanism(log: Callable[[str], None] | None = None) -> None:
    """Compile the kernels of a run without charge, if this version has not been compiled here before. `log`
    is that of `warm_up`.
    """
    mark = compiled_mark("mechanism")
    if _begins(mark, log):
        march_turntable()
        _set(mark)


def compile_charge() -> None:
    """Compile the charge's window in a process of its own, for the law whose names the parent gives."""
    march_ball(task_of_parent())


def _begins(mark: Path, log: Callable[[str], None] | None) -> bool:
    """Return whether there is something to compile. If so, log it, and what is wrong with the cache."""
    if not JIT or mark.is_file():
        return False
    if log is not None:
        for text in filter(None, (cache_trouble(), COMPILING)):
            log(text)
    return True


def note_compiled(law: ContactLaw, engine: str) -> None:
    """Note that a run with its charge in another engine has compiled its kernels."""
    if JIT:
        _set(compiled_mark(engine, *law_names(law)))


def _set(mark: Path) -> None:
    """Note that kernels have been compiled. Without the note they are only looked for again."""
    with suppress(OSError):
        mark.touch()


def turntable():
    """Build a driven shaft on a bushing to the ground: mechanism, state, scratch, table of its sensors."""
    shaft = Body("shaft", 1.0, np.eye(3), (0.0, 0.0, 0.0))
    hub = Body("hub", 1.0, np.eye(3), (0.0, 0.0, 0.0))
    axis = (0.0, 0.0, 1.0)
    bushing = Bushing("mount", GROUND, "hub", (0.0, 0.0, 0.0), axis, (1e5, 1e5, 1e3, 1e3))
    bearing = Joint("bearing", JointKind.REVOLUTE, "hub", "shaft", (0.0, 0.0, 0.0), axis)
    built = assemble(
        [hub, shaft], [bearing], [bushing], drives=[Drive("motor", "bearing", (0.0, 1.0), (0.0, 1.0))]
    )
    static_equilibrium(*built)
    sensors = sensor_table(built[0], built[1], [Sensor("motor", SensorKind.DRIVE, "motor")])
    return *built, sensors


def ball(
    names: Sequence[str], started: bool = True, floors: int = 1
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Build two balls over a floor, their law by name: model, state, scratch. `started` is ready to march."""
    pair = PairLaw(
        1e4,
        0.0,
        0.0,
        1.0,
        0.2,
        False,
        0.3,
        0.3,
        0.01,
        0.5,
        0.9,
        contact_modulus=1e7,
        contact_shear_modulus=1e7,
    )
    floor = Surface("floor", SurfaceKind.PLANE, 0, 0)
    centres = np.array([[0.0, 0.0, 0.01], [0.0, 0.0, 0.0301]])
    built = charge_arrays(
        centres,
        np.full(2, 0.01),
        np.zeros(2, int),
        [1e3],
        {(0, 0): pair},
        [floor] * floors,
        1,
        law=contact_law(*names),
    )
    if started:
        start(*built, STEP)
    return built


def plan() -> CouplingPlan:
    """Return a plan with one substep to the window and one window to the row. The shaft carries the floor."""
    return CouplingPlan(int(Scheme.STAGGERED), 1, STEP, 1, np.array([1]), np.zeros((1, 3)), 0)


def march_turntable() -> None:
    """Compile the mechanism's march."""
    mechanism, state, scratch, sensors = turntable()
    starts = RowTable(row_groups(mechanism, sensors)).starts
    rows = np.empty((1, starts.columns))
    march_mechanism(mechanism, state, scratch, coupling_state(1), sensors, plan(), starts, 1, rows)


def list_balls(names: Sequence[str]) -> None:
    """Compile the neighbour lists, as a part of the charge's window."""
    model, state, scratch = ball(names, started=False, floors=0)
    no_law = model._replace(law=None)  # type: ignore[arg-type]  # as `without_law`
    rebuild.compile_for_kernels(no_law, state, scratch, np.zeros(8), 0.0, 0, 1)


def march_ball(names: Sequence[str]) -> None:
    """Compile the charge's window."""
    model, state, scratch = ball(names)
    Charge.from_parts(model, state, scratch, STEP, at_rest()).step()


def read_ball(names: Sequence[str]) -> None:
    """Compile what reads the charge."""
    built = ball(names)
    run_team(observe, (*built, charge_reading()), 1)
    survey = statistics_plan(built[0], built[1], STEP)
    run_team(sample, (*built, survey, at_rest(), 0.0, charge_statistics(survey, built[1])), 1)


def march_both(names: Sequence[str]) -> None:
    """Compile the coupled march. It is quick if its parts have been compiled."""
    mechanism, mstate, mscratch, sensors = turntable()
    charge, cstate, cscratch = ball(names)
    survey = statistics_plan(charge, cstate, STEP)
    starts = RowTable(row_groups(mechanism, sensors, ["hub"])).starts
    model = CoupledModel(mechanism, sensors, charge, survey, plan(), starts)
    state = CoupledState(mstate, cstate, charge_statistics(survey, cstate), coupling_state(1))
    scratch = coupled_scratch(state, mscratch, cscratch, Scheme.STAGGERED)
    run_team(march_coupled, (model, state, scratch, 1, np.empty((1, starts.columns))), 1)
