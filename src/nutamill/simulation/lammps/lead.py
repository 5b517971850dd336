"""Who does what in a run on many processes: the first runs the case, the others wait for its orders."""

import hashlib
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from nutamill.base.errors import CaseError, Fault, MillError
from nutamill.case.machine import Machine
from nutamill.simulation.lammps.faults import refuse_for_lammps
from nutamill.simulation.lammps.grains import Grains
from nutamill.simulation.lammps.ranks import MpiRanks, Ranks, all_ranks, refuse_copies
from nutamill.simulation.lammps.windows import march_windows
from nutamill.simulation.warm_up import note_compiled

if TYPE_CHECKING:
    from nutamill.simulation.setup.model import Model, Scratch, State


@contextmanager
def led(machine: Machine) -> Iterator[None]:
    """Start the other processes of a run, if there are any, and end them with the block. They do not come
    back from it.

    Raises
    ------
    CaseError : what LAMMPS cannot do, processes that read different cases, or processes that share nothing
    NotInstalledError : mpi4py or a library of MPI is missing
    SystemExit : on the processes that have followed
    """
    if machine.charge.engine is None or not machine.charge.parts:
        refuse_copies()
        yield
        return
    refuse_for_lammps(machine)
    ranks = all_ranks()
    agree(machine, ranks)
    if isinstance(ranks, MpiRanks) and ranks.rank > 0:
        follow(machine, ranks)
        raise SystemExit(0)
    try:
        yield
    finally:
        ranks.order(("end",))


def agree(machine: Machine, ranks: Ranks) -> None:
    """Raise CaseError on all processes if they have read different cases."""
    digest = np.frombuffer(hashlib.sha256(machine.to_toml().encode()).digest(), np.uint8)[None, :]
    seen = ranks.gathered(digest)
    other = ranks.share(int((seen != digest).any(axis=1).sum()) if ranks.rank == 0 else 0)
    if other:
        what = f"{other} of {ranks.size} processes have read another case than the first"
        raise CaseError(Fault("mpiexec", what, "Give all of them the same file on a shared disk"))


@contextmanager
def in_lammps(
    model: "Model",
    state: "State",
    scratch: "Scratch",
    bed: np.ndarray | None,
    poses: np.ndarray | None = None,
    groups: dict | None = None,
) -> Iterator[None]:
    """Put the charge of a state into LAMMPS, on all processes, if its case asks for it.

    Parameters
    ----------
    model, state, scratch : as built, of a checkpoint with its `groups` put back
    bed, poses : from which the other processes build theirs, as `nutamill.simulation.setup.model.build`
    groups : of the checkpoint, None at the start of a run
    """
    if model.machine.charge.engine is None or model.charge is None:
        yield
        return
    ranks = all_ranks()
    ranks.order(("begin", bed, poses, groups))
    state.grains = grains_of(model, state, scratch, ranks, groups)
    try:
        yield
        note_compiled(model.charge.law, model.machine.charge.engine)
    finally:
        state.grains.close()


def grains_of(
    model: "Model", state: "State", scratch: "Scratch", ranks: Ranks, groups: dict | None
) -> Grains:
    """Return the particles in LAMMPS, from the state or from a checkpoint."""
    assert model.charge is not None and state.charge is not None and scratch.charge is not None
    charge = model.charge, state.charge, scratch.charge
    saved = None if groups is None else groups["charge"]
    return Grains(model.machine, charge, model.clock.substep, ranks, saved, state.statistics)


def follow(machine: Machine, ranks: MpiRanks) -> None:
    """March as the first process orders, until it ends. A fault ends all processes."""
    from nutamill.simulation.checkpoint import restore
    from nutamill.simulation.setup.model import build

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the first process saves and ends the others
    parts: tuple[Any, ...] = ()
    try:
        while (order := ranks.next_order())[0] != "end":
            if order[0] == "begin":
                _, bed, poses, groups = order
                parts = build(machine, bed, None, poses)
                if groups is not None:
                    restore(*parts, groups)
                parts[1].grains = grains_of(*parts, ranks, groups)
            elif order[0] == "march":
                model, state, scratch = parts
                march_windows(model, state, scratch, order[1], np.empty((order[1], model.readout.n_columns)))
            elif order[0] == "save":
                parts[1].grains.part_of_save()
    except MillError as error:
        print(f"process {ranks.rank}: {error}", flush=True)
        ranks.abort()
    except Exception:
        traceback.print_exc()
        sys.stderr.flush()
        ranks.abort()
