"""What an identification asks: unknowns, rows and stages, with every number in SI and every case made."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nutamill.analysis.values import Reading
from nutamill.analysis.windows import MEASURED_SPEED, PAPER_WINDOW, steady_mean
from nutamill.base.errors import CaseError, Fault, MillError
from nutamill.base.schema import spelled
from nutamill.case import Case, Machine, load_case
from nutamill.case.toml.keys import held, si_at, unit_at
from nutamill.case.toml.layers import Layer
from nutamill.result import open_result
from nutamill.simulation.setup.clock import run_clock
from nutamill.studies.axes import changed
from nutamill.studies.campaign_file import case_of, overrides
from nutamill.studies.fit_file import position_of
from nutamill.studies.identify.identify_file import (
    IdentifyFile,
    RowGiven,
    StageGiven,
    UnknownGiven,
    load_identification,
)
from nutamill.studies.measurand import Measurand, measurand_of, si_in
from nutamill.studies.papers.library import read_paper
from nutamill.studies.papers.quantities import MODES
from nutamill.studies.papers.runs import case_of_paper

FEWEST_PER_UNKNOWN = 5
"""Members of a stage for each unknown of its rows, at least [1]; ten are usual.

Source: J. L. Loeppky, J. Sacks, W. J. Welch, Technometrics 51(4), 366-376, 2009 (ten)
"""
HALF_WIDTH = 1.96
"""Half width of a 95 % interval over the standard deviation [1]."""


class Unknown(NamedTuple):
    """A number with a range."""

    name: str
    """Its name."""
    keys: tuple[str, ...]
    """Dotted keys of the case that hold it; none for a gain."""
    gain_of: tuple[str, ...]
    """Quantities whose computed values it multiplies."""
    low: float
    """Lower end of its range, SI."""
    high: float
    """Upper end of its range, SI."""
    unit: str
    """Its SI unit."""
    reason: str
    """Why the range is what it is."""
    plus: int | None
    """Number of the unknown whose value is added at the keys."""
    campaign: str
    """Rows that it belongs to; all if empty."""
    stages: tuple[str, ...]
    """Stages in whose rows it acts; all if empty."""


class Row(NamedTuple):
    """A quantity of a variant of the case, with what was measured of it."""

    label: str
    """What to call it in tables."""
    quantity: str
    """Its name in the file."""
    measurand: Measurand
    """What is read."""
    case: Case | Machine
    """The variant, with the unknowns as the case has them."""
    value: float
    """What was measured, SI; NaN if nothing was."""
    scatter: float
    """Standard uncertainty of the measurement, SI."""
    discrepancy: float
    """Standard deviation of the error of the model itself, SI."""
    learned: bool
    """Whether the posterior is learned from it."""
    campaign: str
    """The campaign of measurements that it belongs to."""
    stages: tuple[str, ...]
    """Stages that run it."""
    average: float
    """Length of the averaging window at the end of its run [s], for quantities of the papers."""
    published: str = ""
    """Paper and name of the row that its interval stands beside, parted by a slash; none if empty."""

    @property
    def reading(self) -> str:
        """What is read from its runs, with the window where that matters."""
        if isinstance(self.measurand.what, str):
            return f"{self.quantity}, last {self.average:g} s"
        return self.quantity

    @property
    def doubt(self) -> float:
        """Root of the sum of squares of scatter and discrepancy, SI."""
        return math.hypot(self.scatter, self.discrepancy)


class Problem(NamedTuple):
    """Everything that an identification file asks."""

    base: Case | Machine
    """The case, without the changes of any row."""
    unknowns: list[Unknown]
    """Unknowns; a point has their shares of the ranges in this order."""
    rows: list[Row]
    """Rows to learn from, then rows to predict."""
    stages: list[StageGiven]
    """Stages in their order."""
    seed: int
    """Seed of the sample and of the posterior."""

    def belongs(self, unknown: Unknown, row: Row) -> bool:
        """Return whether an unknown acts in a row."""
        gained = not unknown.gain_of or row.quantity in unknown.gain_of
        staged = not unknown.stages or not set(unknown.stages).isdisjoint(row.stages)
        return gained and staged and unknown.campaign in ("", row.campaign)

    def columns(self, row: Row) -> np.ndarray:
        """Return which unknowns change the runs of a row, as indices."""
        chosen = {k for k, one in enumerate(self.unknowns) if one.keys and self.belongs(one, row)}
        added = {plus for k in chosen if (plus := self.unknowns[k].plus) is not None}
        return np.array(sorted(chosen | added), dtype=int)

    def inputs(self, rows: Sequence[Row]) -> np.ndarray:
        """Return how the numbers that the runs of some rows depend on follow from the shares of the unknowns,
        (n_unknowns, n_inputs): each is an unknown, or the sum of two as a share of both ranges together.
        Where a stage names what its emulators depend on, only the unknowns among it are taken.
        """
        chosen = [
            k
            for k, one in enumerate(self.unknowns)
            if one.keys
            and any(self.belongs(one, row) and one.name in (self.active(row) or [one.name]) for row in rows)
        ]
        mixed = np.zeros((len(self.unknowns), len(chosen)))
        for place, k in enumerate(chosen):
            plus = self.unknowns[k].plus
            terms = [k] if plus is None else [k, plus]
            widths = np.array([self.unknowns[term].high - self.unknowns[term].low for term in terms])
            mixed[terms, place] = widths / widths.sum()
        return mixed

    def active(self, row: Row) -> list[str]:
        """Return the unknowns and rows that the emulator of a row depends on, by name, none if it depends
        on all unknowns that change its runs.
        """
        named = [stage.active for stage in self.stages if stage.name in row.stages]
        return [name for names in named for name in names] if all(named) else []

    def through(self, rows: Sequence[Row]) -> list[int]:
        """Return the rows of earlier stages that the emulators of some rows depend on, by their numbers."""
        names = {name for row in rows for name in self.active(row)}
        return [number for number, one in enumerate(self.rows) if one.label in names]

    def count_inputs(self, rows: Sequence[Row]) -> int:
        """Return how many numbers the emulators of some rows depend on [1]."""
        return self.inputs(rows).shape[1] + len(self.through(rows))

    def gains(self, row: Row) -> np.ndarray:
        """Return which unknowns multiply the computed values of a row, as indices."""
        chosen = [k for k, one in enumerate(self.unknowns) if one.gain_of and self.belongs(one, row)]
        return np.array(chosen, dtype=int)

    def values(self, points: np.ndarray) -> np.ndarray:
        """Return the values of the unknowns (n, n_unknowns) in SI at shares of their ranges of that shape."""
        low, high = (np.array([getattr(one, name) for one in self.unknowns]) for name in ("low", "high"))
        return low + points * (high - low)

    def case_at(self, row: Row, point: np.ndarray) -> Case | Machine:
        """Return the case of a row with the unknowns at a point, on one thread.

        Raises
        ------
        CaseError : the case, or the machine that it describes, cannot hold these values
        """
        case = changed(row.case, self.changes(self.columns(row), point)).with_("run.threads", 1)
        run_clock(case.machine)
        return case

    def changes(self, columns: np.ndarray, point: np.ndarray) -> dict[str, float]:
        """Return the values of some of the unknowns at a point by dotted key."""
        values = self.values(point)
        changes: dict[str, float] = {}
        for k in columns:
            one = self.unknowns[k]
            value = values[k] if one.plus is None else values[k] + values[one.plus]
            changes |= dict.fromkeys(one.keys, float(value))
        return changes

    def deciding(self, number: int) -> np.ndarray:
        """Return which unknowns decide on the points of a stage, by its number: those that change its runs,
        or a row that earlier stages learn from.
        """
        chosen = {int(k) for k in self.acting(self.stages[number].name)}
        if self.stages[number].draws:
            chosen |= {int(k) for row in self.rows_of(self.stages[number].name) for k in self.gains(row)}
        return np.array(sorted(chosen | self.learned_before(number)), dtype=int)

    def learned_before(self, number: int) -> set[int]:
        """Return which unknowns act in a row that the stages before one learn from."""
        before = {one.name for one in self.stages[:number]}
        rows = [row for row in self.rows if row.learned and not before.isdisjoint(row.stages)]
        return {int(k) for row in rows for k in (*self.columns(row), *self.gains(row))}

    def acting(self, stage: str) -> np.ndarray:
        """Return which unknowns change the runs of a stage, as indices."""
        chosen = {int(k) for row in self.rows_of(stage) for k in self.columns(row)}
        return np.array(sorted(chosen), dtype=int)

    def drawn(self, row: Row) -> bool:
        """Return whether a row is predicted from draws of the posterior."""
        return any(stage.draws and stage.name in row.stages for stage in self.stages)

    def rows_of(self, stage: str) -> list[Row]:
        """Return the rows that a stage runs."""
        return [row for row in self.rows if stage in row.stages]


def read_problem(name: str | Path, until: str | None = None, learned: Sequence[str] = ()) -> Problem:
    """Read an identification file.

    Parameters
    ----------
    until : the last stage to take, with its rows and unknowns; all if None
    learned : titles of rows to predict that are learned from instead

    Raises
    ------
    CaseError : every fault
    """
    file, layer = load_identification(name)
    if until is not None:
        file = _shortened(file, until)
    case, fixed = case_of(file, layer)
    base = load_case(case, fixed)
    faults: list[Fault] = []
    unknowns: list[Unknown] = []
    rows: list[Row] = []
    for called, unknown in file.unknown.items():
        try:
            where = position_of(layer, "unknown", called)
            unknowns.append(_unknown(called, unknown, base, list(file.unknown), where))
        except CaseError as error:
            faults += error.faults
    for is_learned, table, given in [
        *((True, "learn", one) for one in enumerate(file.learn)),
        *((False, "predict", one) for one in enumerate(file.predict)),
    ]:
        try:
            where = position_of(layer, table, given[0])
            under, _ = case_of(file.model_copy(update={"case": given[1].case or file.case}), layer)
            is_learned = is_learned or given[1].title in learned
            rows.append(_row(given[1], is_learned, under, fixed, layer.folder, file.stage[0].name, where))
        except CaseError as error:
            faults += error.faults
    titles = [one.title for one in file.predict if one.title]
    for title in [one for one in learned if one not in titles]:
        what = f'must be the title of a row to predict, got "{title}"'
        faults.append(Fault("--learn", what, f"Titles: {'; '.join(titles)}"))
    problem = Problem(base, unknowns, rows, list(file.stage), file.seed)
    if not faults:
        faults = _faults(problem, file, layer)
    if faults:
        raise CaseError(*dict.fromkeys(faults))
    return problem


def _shortened(file: IdentifyFile, until: str) -> IdentifyFile:
    """Return a file without what belongs to the stages after one only."""
    names = [stage.name for stage in file.stage]
    if until not in names:
        raise CaseError(Fault("--until", f'must be a stage, got "{until}"', f"Stages: {', '.join(names)}"))
    taken = names[: names.index(until) + 1]

    def stays(stages: tuple[str, ...]) -> bool:
        return not stages or any(name in taken or name not in names for name in stages)

    def rows(given: tuple[RowGiven, ...]) -> tuple[RowGiven, ...]:
        staying = [row for row in given if stays(row.stages)]
        return tuple(
            row.model_copy(update={"stages": tuple(name for name in row.stages if name in taken)})
            for row in staying
        )

    unknown = {name: one for name, one in file.unknown.items() if stays(one.stages)}
    changes = {
        "stage": file.stage[: len(taken)],
        "unknown": {
            name: one.model_copy(update={"stages": tuple(s for s in one.stages if s in taken)})
            for name, one in unknown.items()
        },
        "learn": rows(file.learn),
        "predict": rows(file.predict),
    }
    return file.model_copy(update=changes)


def _unknown(name: str, given: UnknownGiven, base: Case | Machine, names: list[str], where: str) -> Unknown:
    """Return an unknown, its range in SI. Other unknowns are called `names`."""
    unit = "1"
    ends: list[list[float]] = []
    for key in given.keys:
        unit = unit_at(key)
        ends.append([si_at(key, getattr(given, end), f"{where}.{end}") for end in ("low", "high")])
        if not isinstance(held(base, key), (int, float)):
            what = f"must be a key of one number, got {spelled(held(base, key))} at {key}"
            raise CaseError(Fault(where, what, "Name a key that holds a number"))
    if given.gain_of:
        ends = [[si_in("1", getattr(given, end), f"{where}.{end}") for end in ("low", "high")]]
    low, high = ends[0]
    if not low < high:
        raise CaseError(Fault(where, f"must have low below high, got {low:g} and {high:g} (SI)"))
    if given.plus and (given.plus not in names or given.plus == name):
        what = f'must be the name of another unknown, got "{given.plus}"'
        raise CaseError(Fault(f"{where}.plus", what, f"Unknowns: {', '.join(names)}"))
    plus = names.index(given.plus) if given.plus else None
    return Unknown(
        name, given.keys, given.gain_of, low, high, unit, given.reason, plus, given.campaign, given.stages
    )


def _row(
    given: RowGiven, learned: bool, case: str, fixed: list[str], folder: Path, first: str, where: str
) -> Row:
    """Return a row, its quantity understood, its case made and its numbers in SI."""
    quantity, average, published, label = given.quantity, PAPER_WINDOW, math.nan, ""
    under = load_case(case, [*fixed, *overrides(given.set)])
    if given.paper:
        paper = read_paper(given.paper)
        row = next((row for row in paper.rows if row.id == given.row), None)
        if row is None or row.against is not None or row.quantity == MODES:
            what = f'must be a row of one run of {given.paper}, got "{given.row}"'
            raise CaseError(Fault(f"{where}.row", what, "Its file has their names as id"))
        if not given.quantity:
            quantity, published = row.quantity, math.nan if row.experiment is None else row.experiment
        under = case_of_paper(paper, row.configuration, row.speed, base=case, fixed=fixed)
        under = changed(under, given.set)
        average, label = paper.configurations[row.configuration].average, f"{paper.short} {row.id}"
    measurand = measurand_of(quantity, f"{where}.quantity", under.machine)
    changes = ", ".join(f"{key} = {value}" for key, value in given.set.items())
    value, scatter = published, math.nan
    if given.record:
        value, scatter = _measured(folder / given.record, measurand, f"{where}.record")
    if given.value is not None:
        value = si_in(measurand.unit, given.value, f"{where}.value")
    if given.scatter is not None:
        scatter = si_in(measurand.unit, given.scatter, f"{where}.scatter")
    discrepancy = math.nan
    if given.discrepancy is not None:
        discrepancy = si_in(measurand.unit, given.discrepancy, f"{where}.discrepancy")
    if learned:
        _refuse_blank(value, scatter, discrepancy, where)
    return Row(
        label=given.title or label or f"{measurand.label}{f', {changes}' if changes else ''}",
        quantity=quantity,
        measurand=measurand,
        case=under,
        value=value,
        scatter=0.0 if math.isnan(scatter) else scatter,
        discrepancy=0.0 if math.isnan(discrepancy) else discrepancy,
        learned=learned,
        campaign=given.campaign,
        stages=given.stages or (first,),
        average=average,
        published=given.published or (f"{given.paper}/{given.row}" if not math.isnan(published) else ""),
    )


def _refuse_blank(value: float, scatter: float, discrepancy: float, where: str) -> None:
    """Raise what a row to learn from lacks."""
    lacks = [
        name
        for name, number in (("value", value), ("scatter", scatter), ("discrepancy", discrepancy))
        if math.isnan(number)
    ]
    if lacks:
        hint = 'A model without error is discrepancy = "0 N" in the unit of the row'
        raise CaseError(Fault(where, f"must state what is learned from it, lacks {', '.join(lacks)}", hint))
    if not scatter > 0.0 or discrepancy < 0.0:
        what = f"must have a scatter above zero, got {scatter:g} with a discrepancy of {discrepancy:g}"
        raise CaseError(Fault(where, what))


def _measured(file: Path, measurand: Measurand, where: str) -> tuple[float, float]:
    """Return the steady mean of a measured series, and its standard uncertainty."""
    if not isinstance(measurand.what, Reading):
        what = f"holds series only, the row asks for {measurand.label}"
        raise CaseError(Fault(where, what, "Give a value"))
    try:
        with open_result(file) as test:
            estimate = steady_mean(test, measurand.what.series, measurand.what.by, scatter=MEASURED_SPEED)
    except MillError as error:
        raise CaseError(Fault(where, f"holds no steady mean of the row: {error}")) from None
    return estimate.mean, estimate.half_width / HALF_WIDTH


def _faults(problem: Problem, file: IdentifyFile, layer: Layer) -> list[Fault]:
    """Return what is wrong with unknowns, rows and stages together."""
    faults: list[Fault] = []
    names = [stage.name for stage in problem.stages]
    for row, where in _places(problem, file, layer):
        if lost := [name for name in row.stages if name not in names]:
            faults.append(Fault(f"{where}.stages", f'"{lost[0]}" is no stage', f"Stages: {', '.join(names)}"))
        if not len(problem.columns(row)) + len(problem.gains(row)):
            hint = f'Unknowns of its campaign "{row.campaign}" and those without a campaign act in it'
            faults.append(Fault(where, "the row depends on no unknown", hint))
    for number, stage in enumerate(problem.stages):
        acting = problem.count_inputs(problem.rows_of(stage.name))
        where = position_of(layer, "stage", number)
        if not problem.rows_of(stage.name):
            faults.append(Fault(where, f'the stage "{stage.name}" runs no row', "Name it in stages of a row"))
        if stage.active:
            faults += _active_faults(problem, number, where)
        if stage.draws:
            faults += _draws_faults(problem, stage.name, number, where)
        elif stage.members < FEWEST_PER_UNKNOWN * acting:
            what = f"too few members for the number of unknowns, got {stage.members} for {acting}"
            least = FEWEST_PER_UNKNOWN * acting
            hint = f"Take {least} at least, better {2 * least}, or fix unknowns"
            faults.append(Fault(f"{where}.members", what, hint))
    for k, unknown in enumerate(problem.unknowns):
        where = position_of(layer, "unknown", unknown.name)
        faults += _plus_faults(problem, unknown, where)
        if lost := [name for name in unknown.stages if name not in names]:
            faults.append(Fault(f"{where}.stages", f'"{lost[0]}" is no stage', f"Stages: {', '.join(names)}"))
        elif not any(k in {*problem.columns(row), *problem.gains(row)} for row in problem.rows):
            hint = "Correct its campaign, stages or gain_of, or leave it out"
            faults.append(Fault(where, "acts in no row", hint))
    return faults


def _active_faults(problem: Problem, number: int, where: str) -> list[Fault]:
    """Return what is wrong with what the emulators of a stage shall depend on."""
    stage, faults = problem.stages[number], []
    acting = [problem.unknowns[k].name for k in problem.acting(stage.name)]
    before = {one.name for one in problem.stages[:number] if not one.draws}
    known = [row.label for row in problem.rows if before.issuperset(row.stages)]
    for name in stage.active:
        if name not in acting and name not in known:
            what = f'must be an unknown that changes its runs or a row of earlier stages, got "{name}"'
            faults.append(Fault(f"{where}.active", what, f"Unknowns: {', '.join(acting)}"))
    if stage.draws:
        faults.append(Fault(f"{where}.active", "has no use with draws", "Leave one of the two out"))
    return faults


def _draws_faults(problem: Problem, stage: str, number: int, where: str) -> list[Fault]:
    """Return what is wrong with a stage of draws."""
    rows = problem.rows_of(stage)
    if number == 0:
        return [Fault(f"{where}.draws", "there is no posterior before the first stage", "Leave it out")]
    if learned := [row.label for row in rows if row.learned]:
        what = f'cannot learn from rows of a stage of draws, got "{learned[0]}"'
        return [Fault(f"{where}.draws", what, "Put the row under [[predict]], or leave draws out")]
    if shared := [row.label for row in rows if len(row.stages) > 1]:
        what = f'must have rows of its own, got "{shared[0]}" of several stages'
        return [Fault(f"{where}.draws", what, "Give the row one stage")]
    return []


def _plus_faults(problem: Problem, unknown: Unknown, where: str) -> list[Fault]:
    """Return what is wrong with the unknown that is added to another."""
    if unknown.plus is None:
        return []
    added = problem.unknowns[unknown.plus]
    if added.plus is not None or added.unit != unknown.unit or not added.keys:
        what = f'must be an unknown of the same unit with keys and without plus, got "{added.name}"'
        return [Fault(f"{where}.plus", what)]
    return []


def _places(problem: Problem, file: IdentifyFile, layer: Layer) -> list[tuple[Row, str]]:
    """Return each row with its place in the file."""
    given: list[Any] = [("learn", k) for k in range(len(file.learn))]
    given += [("predict", k) for k in range(len(file.predict))]
    return [(row, position_of(layer, *key)) for row, key in zip(problem.rows, given, strict=True)]
