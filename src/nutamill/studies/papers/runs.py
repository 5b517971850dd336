"""Which cases a paper needs, in which file each has its result, and how far that is."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, DamagedError, Fault, ResultError
from nutamill.base.library import similar
from nutamill.base.units import rpm, shown
from nutamill.case import Case, Machine, load_case
from nutamill.result import state_of
from nutamill.studies.papers.model import Paper, Row, same_speed
from nutamill.studies.papers.quantities import MODES

COMPLETE = "complete"
"""State of a result file whose run is done (`nutamill.result.Result.state`)."""


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """One case of a paper."""

    configuration: str
    """Its set-up."""
    speed: float
    """Steady speed [rad/s]."""
    seed: int
    """Seed of the charge's placement."""
    quick: bool
    """Whether it is one of the few that decide."""
    case: Case | Machine
    """What is run."""
    folder: Path
    """Where its files are."""
    average: float
    """Length of the averaging window at its end [s]."""

    @property
    def name(self) -> str:
        """Short name, for ``--only`` and file names (`run_name`)."""
        return self.case.name

    @property
    def path(self) -> Path:
        """Its result file, named by the content of the case."""
        return self.case.file_in(self.folder)

    @property
    def modes_path(self) -> Path:
        """File of the natural frequencies of its machine."""
        return self.path.with_suffix(".modes.json")


def run_name(configuration: str, speed: float, seed: int = 1) -> str:
    """Return the name of a configuration at a speed [rad/s]: ``pellets-723rpm``, or ``pellets-723rpm-seed2``
    where the seed is not 1, without the speed where that is zero.
    """
    at = f"-{rpm(speed):.6g}rpm" if speed else ""
    return f"{configuration}{at}" + (f"-seed{seed}" if seed != 1 else "")


def planned_runs(paper: Paper, folder: str | Path) -> list[PlannedRun]:
    """List every run a paper needs, each distinct case once, in the order of its file.

    Parameters
    ----------
    folder : where the result files are, or will be

    Raises
    ------
    CaseError : a configuration whose changes make no sound case
    """
    runs, faults = [], []
    for name, configuration in paper.configurations.items():
        for speed in dict.fromkeys(configuration.speeds):
            for seed in configuration.seeds_at(speed):
                try:
                    case = case_of_paper(paper, name, speed, seed)
                except CaseError as error:
                    faults += [
                        Fault(f"configurations.{name}: {fault.where}", fault.what, fault.hint)
                        for fault in error.faults
                    ]
                    continue
                quick = (
                    any(same_speed(speed, own) for own in configuration.quick)
                    and seed == configuration.seeds[0]
                )
                runs.append(PlannedRun(name, speed, seed, quick, case, Path(folder), configuration.average))
    if faults:
        raise CaseError(*dict.fromkeys(faults))
    return runs


def case_of_paper(
    paper: Paper,
    name: str,
    speed: float,
    seed: int = 1,
    base: str | None = None,
    fixed: Sequence[str] = (),
) -> Case | Machine:
    """Return the case of a configuration at a speed [rad/s]: of a mill its ramp, then `hold` at that speed.

    Parameters
    ----------
    base : the case it starts from, that of the configuration if None
    fixed : changes before those of the configuration, as after ``--set``
    """
    configuration = paper.configurations[name]
    case = load_case(base or configuration.base, [*fixed, *configuration.set])
    title = f"{paper.short}: {configuration.title}" + (f", {shown(speed, 'rpm', '.6g')}" if speed else "")
    if speed:
        case = case.with_(configuration.speed_key, speed)
    case = case.with_(run__seed=seed, run__threads=1, title=title)  # one core each, many at once
    begin = case.drive.ramp_end if isinstance(case, Case) else 0.0
    case = case.with_("run.until", begin + configuration.hold)
    return type(case).from_toml(case.to_toml(), run_name(name, speed, seed))


def chosen(
    paper: Paper, runs: Sequence[PlannedRun], only: Iterable[str], quick: bool
) -> tuple[list[Row], list[PlannedRun]]:
    """Return the rows and runs that are asked for.

    Parameters
    ----------
    only : names of rows, configurations or runs; all if empty
    quick : the few decisive runs only; the rows stay

    Raises
    ------
    CaseError : a name that is none of them
    """
    asked = list(only)
    known = [*(row.id for row in paper.rows), *paper.configurations, *dict.fromkeys(run.name for run in runs)]
    if unknown := [name for name in asked if name not in known]:
        raise CaseError(
            *(
                Fault(
                    f"--only {name}",
                    "is not the name of a row, a configuration or a run",
                    similar(name, known, cutoff=0.6),
                )
                for name in unknown
            )
        )
    rows = [row for row in paper.rows if not asked or row.id in asked or _names_of(row) & set(asked)]
    wanted = {(name, round(speed, 6)) for row in rows if row.id in asked for name, speed, _ in row.needs}
    taken = [
        run
        for run in runs
        if not asked
        or {run.name, run.configuration} & set(asked)
        or (run.configuration, round(run.speed, 6)) in wanted
    ]
    return rows, [run for run in taken if run.quick] if quick else taken


def _names_of(row: Row) -> set[str]:
    """Return the configurations and runs that a row is made of."""
    return {
        name
        for configuration, speed, _ in row.needs
        for name in (configuration, run_name(configuration, speed))
    }


def wants_modes(rows: Iterable[Row], run: PlannedRun) -> bool:
    """Return whether one of the rows asks for the natural frequencies of a run's machine."""
    needs = [(name, round(speed, 6)) for row in rows if row.quantity == MODES for name, speed, _ in row.needs]
    return (run.configuration, round(run.speed, 6)) in needs


def run_state(run: PlannedRun) -> str:
    """Return ``missing``, or the state in the result file: ``complete``, ``running`` (perhaps killed),
    ``interrupted``, ``failed: ...``.

    A file that cannot be read is ``failed`` with the reason.
    """
    try:
        return state_of(run.path)
    except (ResultError, DamagedError) as error:
        return f"failed: {error}"


def write_modes(run: PlannedRun, frequencies: Sequence[float], damping: Sequence[float]) -> None:
    """Store natural frequencies [Hz] and damping ratios of a run's machine, slowest first."""
    text = json.dumps({"frequency_Hz": list(frequencies), "damping_ratio": list(damping)}, indent=1)
    write_whole(run.modes_path, text + "\n")


def read_modes(run: PlannedRun) -> list[float] | None:
    """Return the natural frequencies [Hz] of a run's machine, slowest first, or None if they are not stored
    yet.

    Raises
    ------
    ResultError : a file that is none of them
    """
    if not run.modes_path.exists():
        return None
    try:
        return [
            float(value) for value in json.loads(run.modes_path.read_text(encoding="utf-8"))["frequency_Hz"]
        ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultError(
            f"{run.modes_path}: holds no natural frequencies ({error}). Delete it and repeat the command."
        ) from None
