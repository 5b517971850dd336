"""The job script of a run on many processes of a cluster with SLURM."""

import re
import shlex
import shutil
import subprocess
from pathlib import Path

from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault, OutputError
from nutamill.base.units import in_unit
from nutamill.case import Case, Machine

SAVING_TIME = 300
"""Time before the end of a job at which its run is asked to save and stop [s]."""
SBATCH = "sbatch"
"""The command that hands a script to the queue."""


def job_faults(case: Case | Machine, nodes: int, ranks: int, hours: float) -> list[Fault]:
    """Return what is wrong with a job, all at once."""
    faults = []
    if case.machine.charge.engine != "lammps":
        what = 'a run on many processes needs charge.engine = "lammps"'
        faults.append(Fault("charge.engine", what, "For many runs at once: nutamill sweep --cluster"))
    if ranks % nodes:
        what = f"must be a multiple of the {nodes} nodes, got {ranks}"
        faults.append(Fault("--ranks", what, f"Write e.g. {max(nodes, ranks // nodes * nodes)}"))
    if hours < in_unit(SAVING_TIME, "h"):
        what = f"must be at least {SAVING_TIME / 60:g} minutes, which a run has to save, got {hours:g} h"
        faults.append(Fault("--hours", what))
    return faults


def job_text(name: str, case: Path, result: Path, nodes: int, ranks: int, hours: float) -> str:
    """Return the script of a job that begins a run, or goes on with it where its result file is there.

    Parameters
    ----------
    name : of the job
    case : the case file
    result : the result file
    nodes, ranks : nodes, and processes on all of them [1]
    hours : longest time of the job [h]
    """
    title = re.sub(r"[^\w.-]+", "-", name)[:60] or "nutamill"
    minutes = round(60 * hours)
    start, end = (shlex.quote(str(path)) for path in (case, result))
    return f"""#!/bin/bash
#SBATCH --job-name={title}
#SBATCH --nodes={nodes}
#SBATCH --ntasks={ranks}
#SBATCH --ntasks-per-node={ranks // nodes}
#SBATCH --cpus-per-task=1
#SBATCH --time={minutes // 60:02d}:{minutes % 60:02d}:00
#SBATCH --signal=INT@{SAVING_TIME}
#SBATCH --output=%x-%j.log
# Add the lines of your site here: partition, account, modules of its MPI and LAMMPS, environment of nutamill.
export OMP_NUM_THREADS=1
if [ -e {end} ]; then
    srun nutamill resume {end}
else
    srun nutamill run {start} --to {end}
fi
"""


def write_job(
    case: Case | Machine, file: Path, script: Path, result: Path, nodes: int, ranks: int, hours: float
) -> Path:
    """Write the script of a job and return its path. Other arguments are those of `job_text`.

    Raises
    ------
    CaseError : every fault of the job
    OutputError : the script cannot be written
    """
    if faults := job_faults(case, nodes, ranks, hours):
        raise CaseError(*faults)
    return write_whole(script, job_text(case.name, file, result, nodes, ranks, hours))


def submitted(script: Path) -> str | None:
    """Submit a script to the queue and return the answer, or None where there is no queue.

    Raises
    ------
    OutputError : the queue refuses
    """
    command = shutil.which(SBATCH)
    if command is None:
        return None
    answer = subprocess.run([command, str(script)], capture_output=True, text=True, check=False)
    if answer.returncode:
        raise OutputError(f"{script}: {SBATCH} refused it: {answer.stderr.strip()}. The script is written.")
    return answer.stdout.strip()
