"""Who does the work: processes of this machine, or the workers of a Dask cluster.  No scheduler
of our own.
"""

import contextlib
import os
import signal
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Protocol

from nutamill.base.child import give_task, start_child
from nutamill.base.errors import CaseError, ExitCode, Fault, MillError, missing_extra
from nutamill.simulation.setup.threads import usable_cores
from nutamill.studies.member import DONE, Task, perform

if TYPE_CHECKING:
    import distributed

PROGRAM = "from nutamill.studies.member import main; main()"


class WorkerError(MillError, RuntimeError):
    """A worker that did not do what it was asked: killed, interrupted, or its run failed."""


class Workers(Protocol):
    """Takes tasks, and can be stopped."""

    def submit(self, task: Task) -> Future:
        """Begin a task when a worker is free. The future raises what went wrong."""

    def stop(self) -> None:
        """Begin no more tasks, and let those that run save what they have."""


class LocalProcesses:
    """So many processes, each with one task at a time: a task that dies takes no other with it.

    A process that is done with a task takes the next one; one that has failed or died is replaced.

    Parameters
    ----------
    jobs : processes at once; the physical cores if None
    """

    def __init__(self, jobs: int | None = None):
        self._waiting = ThreadPoolExecutor(jobs or usable_cores())
        self._running: set[_Child] = set()
        self._idle: list[_Child] = []
        self._lock = threading.Lock()
        self._stopped = False

    def submit(self, task: Task) -> Future:
        """Begin a task when a process is free."""
        return self._waiting.submit(self._supervise, task)

    def _supervise(self, task: Task) -> None:
        """Give a task to a process and wait for its end. Raises WorkerError unless it ended well."""
        with self._lock:
            if self._stopped:
                raise WorkerError("not begun")
            child = next((one for one in _taken(self._idle) if one.takes(task)), None) or _Child(task)
            self._running.add(child)
        done = child.answers()
        with self._lock:
            self._running.discard(child)
            if done:
                self._idle.append(child)
                return
        code, reason = child.end()
        if code == ExitCode.INTERRUPTED or (self._stopped and code == -signal.SIGTERM):
            raise WorkerError("interrupted, saved")
        if code < 0:
            raise WorkerError(f"its process was killed ({signal.Signals(-code).name})")
        if code:
            raise WorkerError(reason or f"its process ended with code {code}")

    def stop(self) -> None:
        """Begin no more tasks, ask the running processes to save and end, and wait for them."""
        with self._lock:
            self._stopped = True
            for child in self._running:
                child.process.terminate()
        self._waiting.shutdown(wait=True, cancel_futures=True)
        for child in _taken(self._idle):
            child.end()


class _Child:
    """A process that performs tasks, and what it writes of a fault.

    Parameters
    ----------
    task : its first one
    """

    def __init__(self, task: Task):
        self._faults = tempfile.TemporaryFile()  # noqa: SIM115 (closed at its end)
        self.process = start_child(PROGRAM, task, stdout=subprocess.PIPE, stderr=self._faults)

    def takes(self, task: Task) -> bool:
        """Give it another task. Return whether it is still there to take it."""
        try:
            give_task(self.process, task)
        except BrokenPipeError:
            self.end()
            return False
        return True

    def answers(self) -> bool:
        """Wait until its task is done, True, or it has ended, False."""
        assert self.process.stdout is not None  # a pipe
        return self.process.stdout.readline().strip() == DONE

    def end(self) -> tuple[int, str]:
        """Wait until it ends, as it does when its input is closed. Return its exit code, and the last line of
        its faults.
        """
        assert self.process.stdin is not None and self.process.stdout is not None  # pipes
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.close()
        code = self.process.wait()
        self.process.stdout.close()
        self._faults.seek(0)
        lines = self._faults.read().decode(errors="replace").strip().splitlines()
        self._faults.close()
        return code, lines[-1] if lines else ""


def _taken(children: list[_Child]) -> Iterator[_Child]:
    """Take one after another out of a list."""
    while children:
        yield children.pop()


class ClusterWorkers:
    """The workers of a Dask cluster; results and settled beds must be where they and this process can reach
    them.

    Parameters
    ----------
    client : connected to the scheduler
    """

    def __init__(self, client: "distributed.Client"):
        self._executor = client.get_executor(pure=False)

    def submit(self, task: Task) -> Future:
        """Begin a task when a worker is free. A worker that dies hands it to another, which goes on from the
        last checkpoint.
        """
        return self._executor.submit(perform, task)

    def stop(self) -> None:
        """Take back the tasks. A worker finishes the run that is under way, as Dask interrupts nothing."""
        self._executor.shutdown(wait=False)


def cluster_client(address: str, jobs: int | None) -> "distributed.Client":
    """Return a Dask client: of a cluster of processes on this machine for ``"local"``, else of the scheduler
    at an address or in a file.

    Raises
    ------
    CaseError : no scheduler answers
    NotInstalledError : the extra ``cluster`` is missing
    """
    try:
        import distributed
    except ImportError:
        raise missing_extra("--cluster", "Dask", "cluster") from None
    if address == "local":
        os.environ["PYTHONSAFEPATH"] = "1"  # its processes look for no modules in the working folder
        local = distributed.LocalCluster(
            n_workers=jobs or usable_cores(), threads_per_worker=1, dashboard_address=None
        )
        return distributed.Client(local)
    try:
        return (
            distributed.Client(scheduler_file=address)
            if address.endswith(".json")
            else distributed.Client(address, timeout="30s")
        )
    except (OSError, ValueError, TimeoutError) as error:
        hint = "Give local, an address like tcp://host:8786, or a scheduler file (.json)"
        raise CaseError(Fault("--cluster", f'no scheduler answers at "{address}": {error}', hint)) from None
