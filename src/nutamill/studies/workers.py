"""Who does the work: a process for each run on this machine, or the workers of a Dask cluster.  No scheduler
of our own.
"""

import contextlib
import os
import signal
import subprocess
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Protocol

from nutamill.base.child import start_child
from nutamill.base.errors import CaseError, ExitCode, Fault, MillError, missing_extra
from nutamill.simulation.setup.threads import usable_cores
from nutamill.studies.member import Task, perform

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
    """A process of its own for each task, so many at once: a task that dies takes no other with it.

    Parameters
    ----------
    jobs : processes at once; the physical cores if None
    """

    def __init__(self, jobs: int | None = None):
        self._waiting = ThreadPoolExecutor(jobs or usable_cores())
        self._running: set[subprocess.Popen] = set()
        self._lock = threading.Lock()
        self._stopped = False

    def submit(self, task: Task) -> Future:
        """Begin a task when a core is free."""
        return self._waiting.submit(self._supervise, task)

    def _supervise(self, task: Task) -> None:
        """Start the process of a task and wait for its end. Raises WorkerError unless it ended well."""
        with self._lock:
            if self._stopped:
                raise WorkerError("not begun")
            process = start_child(PROGRAM, task, stderr=subprocess.PIPE)
            self._running.add(process)
        assert process.stdin is not None and process.stderr is not None  # pipes
        try:
            output = process.stderr.read()  # until the process ends; its input stays open meanwhile
        finally:
            code = process.wait()
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
            process.stderr.close()
            with self._lock:
                self._running.discard(process)
        if code == ExitCode.INTERRUPTED or (self._stopped and code == -signal.SIGTERM):
            raise WorkerError("interrupted, saved")
        if code < 0:
            raise WorkerError(f"its process was killed ({signal.Signals(-code).name})")
        if code:
            raise WorkerError(
                output.strip().splitlines()[-1] if output.strip() else f"its process ended with code {code}"
            )

    def stop(self) -> None:
        """Begin no more tasks, ask the running processes to save and end, and wait for them."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                process.terminate()
        self._waiting.shutdown(wait=True, cancel_futures=True)


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
