"""The processes of a run: who is first, and how they sum and share. One process needs no MPI."""

import atexit
import functools
import os
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from nutamill.base.errors import CaseError, Fault, missing_extra

SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MV2_COMM_WORLD_SIZE", "PMIX_SIZE")
"""Variables in which a launcher of MPI says how many processes it has started."""

NUMBERS = ("PMI_RANK", "OMPI_COMM_WORLD_RANK", "MV2_COMM_WORLD_RANK", "PMIX_RANK")
"""Variables in which it says the number of the process."""

PAUSE = 1e-3
"""Time between two looks of a waiting process for its next order [s]: it takes no core meanwhile."""


class Ranks:
    """One process of a run that has no others.

    Attributes
    ----------
    rank : number of this process, from 0 [1]
    size : number of processes [1]
    """

    rank, size = 0, 1
    communicator: Any = None
    """What LAMMPS takes; None for one process."""

    def total(self, numbers: np.ndarray) -> np.ndarray:
        """Return the sum of an array over all processes, with the same bits on each of them."""
        return numbers

    def largest(self, number: float) -> float:
        """Return the largest of the numbers of all processes, on each of them."""
        return number

    def gathered(self, rows: np.ndarray) -> np.ndarray:
        """Return the rows of all processes behind each other on the first, an empty array on the others."""
        return rows

    def share(self, content: Any) -> Any:
        """Return what the first process has, on all of them."""
        return content

    def order(self, content: Any) -> None:
        """Give an order to the other processes, which wait in `next_order`."""

    def leave(self) -> None:
        """Give no more orders: the other processes cannot hear them, and end with this one."""

    def abort(self) -> None:
        """Kill all processes at once."""


class MpiRanks(Ranks):
    """The processes that ``mpiexec`` has started.

    Parameters
    ----------
    communicator : of mpi4py
    """

    def __init__(self, communicator: Any):
        self.communicator, self._left = communicator, False
        self.rank, self.size = communicator.Get_rank(), communicator.Get_size()

    def total(self, numbers: np.ndarray) -> np.ndarray:
        """Return the sum of an array over all processes, with the same bits on each of them.

        MPI promises the same bits to all processes of one reduction.
        """
        out = np.empty_like(numbers)
        self.communicator.Allreduce(np.ascontiguousarray(numbers), out)
        return out

    def largest(self, number: float) -> float:
        """Return the largest of the numbers of all processes, on each of them."""
        return max(self.communicator.allgather(number))

    def gathered(self, rows: np.ndarray) -> np.ndarray:
        """Return the rows of all processes behind each other on the first, an empty array on the others."""
        parts = self.communicator.gather(np.ascontiguousarray(rows), root=0)
        return np.concatenate(parts) if parts is not None else rows[:0]

    def share(self, content: Any) -> Any:
        """Return what the first process has, on all of them."""
        return self.communicator.bcast(content, root=0)

    def order(self, content: Any) -> None:
        """Give an order to the other processes, which wait in `next_order`."""
        if not self._left:
            self.communicator.Ibarrier().Wait()
            self.share(content)

    def leave(self) -> None:
        """Give no more orders: the other processes cannot hear them, and end with this one."""
        self._left = True
        atexit.register(self.abort)

    def next_order(self) -> Any:
        """Wait for the next order of the first process, and return it."""
        called = self.communicator.Ibarrier()
        while not called.Test():
            time.sleep(PAUSE)
        return self.share(None)

    def abort(self) -> None:
        """Kill all processes at once."""
        self.communicator.Abort(1)


def launched(environment: Mapping[str, str] = os.environ) -> int:
    """Return the number of processes that a launcher of MPI has started, 1 without one [1]."""
    return max([1, *(int(environment[name]) for name in SIZES if environment.get(name, "").isdigit())])


def follows(environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether a launcher of MPI has started this process behind the first of several."""
    return launched(environment) > 1 and any(int(environment.get(name, "0")) > 0 for name in NUMBERS)


@functools.cache
def all_ranks() -> Ranks:
    """Return the processes of this run. Raise NotInstalledError where there are several and mpi4py is
    missing.
    """
    if launched() == 1:
        return Ranks()
    try:
        from mpi4py import MPI
    except ImportError:
        raise missing_extra("a run on several processes", "mpi4py", "mpi") from None
    except RuntimeError as error:  # mpi4py is there and no library of MPI is
        raise missing_extra("a run on several processes", f"a library of MPI ({error})", "mpi") from None
    return MpiRanks(MPI.COMM_WORLD)


def refuse_copies() -> None:
    """Raise CaseError where a launcher of MPI has started several processes of a run that shares nothing."""
    if (count := launched()) > 1:
        what = f"mpiexec has started {count} processes, which would all run the same case"
        raise CaseError(Fault("mpiexec", what, 'Write charge.engine = "lammps", or start it without mpiexec'))
