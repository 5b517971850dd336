"""The particles of a charge in LAMMPS: arrays, the callback of every substep, and one window."""

import ctypes
import tempfile
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nutamill.base.kernel import entry_of
from nutamill.case.machine import Machine
from nutamill.charge.kernels.dynamics import close_window, open_window
from nutamill.charge.kernels.foreign_atoms import AtomState, finish_atoms, push_atoms
from nutamill.charge.measures.foreign_sample import sample_atoms
from nutamill.charge.measures.observe import ChargeReading, charge_reading, observe
from nutamill.charge.measures.statistics import ChargeStatistics, StatisticsPlan
from nutamill.charge.measures.totals import add_to_first, clear
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock
from nutamill.charge.saved_state import WHOLE
from nutamill.simulation.lammps.commands import (
    COLUMNS,
    FRAME,
    KICKS,
    WALLS,
    box_commands,
    law_commands,
    memory_commands,
    share_commands,
    start_commands,
)
from nutamill.simulation.lammps.library import start_lammps
from nutamill.simulation.lammps.ranks import Ranks

ARRAYS = {"x": 3, "v": 3, "omega": 3, "radius": 1, "rmass": 1, "f": 3, "torque": 3, KICKS: 6, WALLS: 0}
"""Arrays of LAMMPS in the order of `AtomState`, behind id and type: numbers for each atom, 0 as many as the
walls need [1].
"""
BLOCK = 50_000
"""Particles that are created at once [1]."""


class Grains:
    """The particles of a charge that LAMMPS moves.

    The charge of this package holds the particles of this process between two windows, and on the first
    process those of all after `gather`.

    Parameters
    ----------
    machine : the machine
    charge : model, state and work space of all particles, in double precision
    dt : substep [s]
    ranks : processes
    saved : arrays of a checkpoint to go on from, as `saved_arrays` returns them; None for the particles of
        the state
    sums : the statistics of the charge, which ``gather`` leaves on the first process; None for none

    Attributes
    ----------
    halted : whether a particle of any process stopped the last window
    """

    halted = False

    def __init__(
        self,
        machine: Machine,
        charge: tuple[ChargeModel, ChargeState, ChargeScratch],
        dt: float,
        ranks: Ranks,
        saved: Mapping[str, np.ndarray] | None = None,
        sums: ChargeStatistics | None = None,
    ):
        self.model, self.state, self.scratch = charge
        self.sums = sums
        self.ranks, self.dt = ranks, dt
        self._engine = start_lammps(ranks.communicator)
        self._motions, self._step, self._room = np.zeros((self.model.n_bodies, 19)), -1, 0
        self._substeps, self._stopped = 1, False
        self._fault: BaseException | None = None
        self._begin_window: Callable[[], np.ndarray] = lambda: self._motions
        self._end_window: Callable[[], bool] = lambda: True
        self._atoms: AtomState | None = None
        self._push_walls: Callable[..., Any] | None = None
        if saved is not None:
            self._put_back(saved)
        self._begin(machine, None if saved is None else saved["restart"].tobytes())

    def close(self) -> None:
        """Close the LAMMPS."""
        self._engine.close()

    def _begin(self, machine: Machine, saved: bytes | None) -> None:
        """Put particles and laws into LAMMPS, and make its forces those of the last substep."""
        surfaces = len(self.model.surface_kind)
        self._run(*start_commands())
        if saved is None:
            places = self.state.x[:, : self.model.n_particles].T
            self._run(*box_commands(machine, places), *memory_commands(surfaces))
            self._create()
        else:
            self._read(saved, memory_commands(surfaces))
        self._run(*law_commands(machine, self.model, self.dt))
        self._engine.set_fix_external_callback(FRAME, self._push, None)
        self._run(*share_commands(self.ranks.size), "run 0 post no")
        atoms, n = self._views(), self.count
        kick = 2.0 / self.dt * atoms.kick[:n]
        inertia = 0.4 * atoms.mass[:n] * atoms.radius[:n] ** 2
        atoms.force[:n], atoms.moment[:n] = atoms.mass[:n, None] * kick[:, :3], inertia[:, None] * kick[:, 3:]

    def _create(self) -> None:
        """Make the particles of the state, each on the process in whose part of the box it is."""
        n, state = self.model.n_particles, self.state
        ids = state.ids[:n]
        rows = state.published_rows[state.clock[Clock.PUBLISHED], :n]
        kick = np.hstack([rows[:, 0:3] - state.v[:, :n].T, rows[:, 4:7] - state.w[:, :n].T])
        # as LAMMPS has them between two steps: positions half a substep before, velocities half a kick
        x = state.x[:, :n].T - self.dt * state.v[:, :n].T
        motion = np.hstack([state.v[:, :n].T, state.w[:, :n].T]) - kick
        types = (state.material[:n] + 1).astype(np.int32)
        made = 0
        for lo in range(0, n, BLOCK):  # it takes lists, which are five times as large as arrays
            part = slice(lo, min(lo + BLOCK, n))
            given = ((ids[part] + 1).tolist(), types[part].tolist(), x[part].ravel().tolist())
            made += self._engine.create_atoms(part.stop - lo, *given)
        assert made == n
        atoms = self._views()
        slot = np.empty(n, np.int64)
        slot[ids] = np.arange(n)
        here = slot[atoms.id[: self.count] - 1]
        m = len(here)
        atoms.x[:m], atoms.v[:m], atoms.w[:m] = x[here], motion[here, :3], motion[here, 3:]
        atoms.radius[:m], atoms.mass[:m] = state.mass_props[0, here], state.mass_props[1, here]
        atoms.kick[:m], atoms.wall[: m * len(self.model.surface_kind)] = kick[here], 0.0

    def _read(self, saved: bytes, memory: list[str]) -> None:
        """Read the particles of an earlier LAMMPS, of any number of processes."""
        with tempfile.TemporaryDirectory() as folder:
            path = self.ranks.share(str(Path(folder, "restart")))
            if self.ranks.rank == 0:
                Path(path).write_bytes(saved)
            self._run(f"read_restart {path}", *memory)

    def _put_back(self, saved: Mapping[str, np.ndarray]) -> None:
        """Set what does not belong to a particle to that of a checkpoint. The works of all processes are
        those of the first.
        """
        for name in WHOLE:
            getattr(self.state, name)[...] = saved[name]
        if self.ranks.rank > 0:
            self.state.ledger[:] = 0.0
            if self.sums is not None:
                clear(self.sums, self.state.impacts)

    def saved_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of a checkpoint, from which any number of processes can go on. The first process
        calls it.
        """
        self.ranks.order(("save",))
        n, state = self.model.n_particles, self.state
        restart, ledger = self.part_of_save()
        arrays = {name: getattr(state, name).copy() for name in WHOLE}
        return arrays | {
            "ledger": ledger,
            "ids": state.ids[:n].astype(np.int32),
            "x": state.x[:, :n].copy(),
            "restart": np.frombuffer(restart, np.uint8),
        }

    def part_of_save(self) -> tuple[bytes, np.ndarray]:
        """Return a file from which LAMMPS goes on, empty but on the first process, and the ledger of all. All
        processes call it.
        """
        return self._restart_file(), self.ranks.total(self.state.ledger)

    def _restart_file(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = self.ranks.share(str(Path(folder, "restart")))
            self._run(f"write_restart {path}")
            return Path(path).read_bytes() if self.ranks.rank == 0 else b""

    @property
    def count(self) -> int:
        """Number of particles on this process [1]."""
        return int(self._engine.extract_global("nlocal"))

    def window(self, motions: np.ndarray, n_substeps: int) -> None:
        """March the charge through one window of `n_substeps` inside the motion (n_bodies, 19) of the
        carriers, as `nutamill.charge.kernels.dynamics.window`.
        """
        self.march(1, n_substeps, lambda: motions, lambda: True)

    def march(
        self,
        n_windows: int,
        n_substeps: int,
        begin: Callable[[], np.ndarray],
        end: Callable[[], bool],
    ) -> None:
        """March the charge through windows in one run of LAMMPS, since each of its runs ends with a copy of
        all contacts.

        Parameters
        ----------
        n_windows, n_substeps : number of windows, and of substeps in each
        begin : called at the start of a window, returns the motion (n_bodies, 19) of the carriers in it
        end : called at its end, when ``state.impulse`` is the sum over all processes; returns whether to go
            on. After False, the particles are of no use
        """
        self._begin_window, self._end_window, self._substeps = begin, end, n_substeps
        self._step, self._stopped, self._fault = 0, False, None
        try:
            self._run(f"run {n_windows * n_substeps} pre no post no")
        except Exception:
            if not self._stopped:  # else it has lost particles that nothing holds any more
                raise
        self._step = -1
        if self._fault is not None:
            raise self._fault

    def _close_window(self) -> None:
        """Sum up a window over all processes."""
        close_window(self.model, self.state, self.scratch, self._motions, self._substeps, self.dt, 0, 1)
        halted = self.state.status[0] != 0
        sums = self.ranks.total(np.append(self.state.impulse.ravel(), float(halted)))
        self.state.impulse[:] = sums[:-1].reshape(self.state.impulse.shape)
        self.halted = bool(sums[-1] > 0.0)
        if self.halted:
            self._name_halt()

    def _name_halt(self) -> None:
        """Copy the status of the process with a halted particle to the first. All processes call it."""
        state = self.state
        own = np.concatenate([state.status, state.halt_speeds, state.largest_overlap])[None, :]
        for status in self.ranks.gathered(own.astype(float)):
            if status[0] != 0.0:
                state.status[:], state.halt_speeds[:], state.largest_overlap[:] = np.split(status, (4, 7))
                return

    def read(self) -> tuple[ChargeReading, np.ndarray]:
        """Return the present reading of the whole charge and its ledger [J] (9,).

        The largest overlap with walls is then that of all processes.  All processes call it.

        The energies stored in pairs are part of the work of pairs.
        """
        self.take()
        n, reading = self.count, charge_reading()
        observe(self.model, self._with_memory(), self.scratch, reading, 0, 1)
        mass = self.state.mass_props[1, :n].sum()
        moment = mass * reading.mass_centre if n else np.zeros(3)
        pairs = 0.5 * float(self._touching().sum())
        counts, ledger = [pairs, reading.contacts[1], mass], self.state.ledger
        sums = self.ranks.total(np.concatenate([reading.energy, counts, moment, reading.momentum, ledger]))
        reading.energy[:], reading.contacts[:] = sums[:8], sums[8:10]
        reading.mass_centre[:], reading.momentum[:] = sums[11:14] / sums[10], sums[14:17]
        reading.coordination[0] = 2.0 * sums[8] / self.model.n_particles
        self.state.largest_overlap[1] = self.ranks.largest(float(self.state.largest_overlap[1]))
        return reading, sums[17:]

    def take(self) -> None:
        """Copy the particles of this process into the slots, as a march of this engine leaves them."""
        n, atoms = self.count, self._views()
        if self._step >= 0:  # within a step of LAMMPS, which has not added half of its forces yet
            kick = atoms.kick[:n]
            atoms = atoms._replace(v=atoms.v[:n] + kick[:, :3], w=atoms.w[:n] + kick[:, 3:])
        finish_atoms(self.model, self.state, atoms, n, self.dt)

    def gather(self) -> None:
        """Copy the particles of all processes into the slots of the first, and add their statistics to its.
        All processes call it.
        """
        self.take()
        if self.ranks.size == 1:
            return
        if self.sums is not None:
            add_to_first(self.sums, self.state.impacts, self.ranks.total, self.ranks.rank == 0)
        n, state = self.count, self.state
        rows = state.published_rows[state.clock[Clock.PUBLISHED]]
        local = [state.ids[:n], state.material[:n], state.mass_props[:, :n].T, state.x[:, :n].T]
        local += [state.v[:, :n].T, state.w[:, :n].T, rows[:n]]
        whole = self.ranks.gathered(np.column_stack(local))
        if self.ranks.rank > 0:
            return
        m = len(whole)
        state.ids[:m], state.material[:m] = whole[:, 0], whole[:, 1]
        state.mass_props[:, :m], state.x[:, :m] = whole[:, 2:6].T, whole[:, 6:9].T
        state.v[:, :m], state.w[:, :m], rows[:m] = whole[:, 9:12].T, whole[:, 12:15].T, whole[:, 15:23]

    def sample(self, plan: StatisticsPlan, motions: np.ndarray, angle: float) -> None:
        """Take one sample of the statistics, of the particles of this process as `read` has left them.

        The arguments are those of `nutamill.charge.measures.sampling.sample`.
        """
        state, touching = self._with_memory(), self._touching()
        sample_atoms(self.model, state, self.scratch, plan, motions, angle, touching, self.sums)

    def _with_memory(self) -> ChargeState:
        """Return the state with the memory of the walls, which is with the particles in LAMMPS."""
        return self.state._replace(wall_memory=self._views().wall)

    def _touching(self) -> np.ndarray:
        """Return how many particles each particle of this process touches [1] (n,)."""
        counts = self._engine.numpy.extract_compute("touching", 1, 1)
        return np.array(counts[: self.count], float)

    def _push(self, _caller: Any, _step: int, n: int, _tag: Any, _x: Any, out: np.ndarray) -> None:
        """Add the walls to the forces of a step, or nothing while LAMMPS prepares."""
        if self._step < 0 or self._stopped:
            out[:] = 0.0
            return
        try:
            self._substep(n, out)
        except BaseException as error:  # LAMMPS would go on as if nothing had been raised
            self._fault, self._stopped = error, True
            if self.ranks.size > 1:  # the others wait for a sum
                traceback.print_exc()
                self.ranks.abort()

    def _substep(self, n: int, out: np.ndarray) -> None:
        """Add the walls to the forces `out` (n, 3) of a step, and begin and end the windows."""
        if self._step == 0:
            self._motions = self._begin_window()
            open_window(self.model, self.state, self.scratch, 0)
        since, atoms = (self._step + 0.5) * self.dt, self._views()
        given = (self.model, self.state, self.scratch, self._motions, atoms, n, since, self.dt, out)
        if self._push_walls is None:
            self._push_walls = entry_of(push_atoms, *given)
        self._push_walls(*given)
        self._step += 1
        if self._step == self._substeps:
            self._close_window()
            self._stopped = not self._end_window()
            self._step = 0

    def _views(self) -> AtomState:
        """Return the arrays of LAMMPS, looked up anew where it has made them larger."""
        room = int(self._engine.extract_setting("nmax"))
        if self._atoms is None or room != self._room:
            self._room = room
            engine, surfaces = self._engine, len(self.model.surface_kind)
            numbers = [
                _view(engine.extract_atom(name), room, columns or COLUMNS * max(surfaces, 1))
                for name, columns in ARRAYS.items()
            ]
            wall = numbers.pop().reshape(-1, COLUMNS)
            ids, types = (_view(engine.extract_atom(name), room, 1) for name in ("id", "type"))
            x, v, w, radius, mass, force, moment, kick = numbers
            self._atoms = AtomState(ids, types, x, v, w, radius, mass, force, moment, kick, wall)
        return self._atoms

    def _run(self, *commands: str) -> None:
        for command in commands:
            self._engine.command(command)


def _view(pointer: Any, rows: int, columns: int) -> np.ndarray:
    """Return an array of LAMMPS, (rows,) or (rows, columns), without a copy."""
    kind = pointer._type_
    if hasattr(kind, "_type_") and not isinstance(kind._type_, str):  # a pointer to the rows
        pointer, kind = pointer[0], kind._type_
    flat = ctypes.cast(pointer, ctypes.POINTER(kind))
    shape = (rows,) if columns == 1 else (rows, columns)
    return np.ctypeslib.as_array(flat, shape)
