"""Commands about a case that is not run: write, check, show."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nutamill.base.atomic_file import RESULTS
from nutamill.base.errors import CaseError, Fault, printable
from nutamill.cli import completion
from nutamill.cli.common import CaseName, Overrides, app, load, reports_errors
from nutamill.cli.paragraphs import echo_lines

if TYPE_CHECKING:
    from nutamill.result import Result


MEASURED = "measured"
"""State of a file that holds a test, as `nutamill.analysis.measured_import` writes it."""


@app.command()
@reports_errors
def new(
    file: Annotated[Path, typer.Argument(metavar="FILE.toml", help="The file to write.")],
    base: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="CASE",
            help="The case that it begins with; else numill.",
            autocompletion=completion.cases,
        ),
    ] = None,
    kind: Annotated[
        str,
        typer.Option(metavar="KIND", help="mill, mechanism, sweep, fit, identify, ratings, ore or mapping."),
    ] = "mill",
) -> None:
    """Write a first file to change, and beside it the schema by which an editor completes and checks it."""
    from nutamill.studies.new_file import NEXT, write_new

    schema = write_new(kind, file, base)
    typer.echo(f"{file} written, with {schema.name} for editors. Next: {NEXT[kind].format(file)}")


@app.command()
@reports_errors
def check(
    case: CaseName,
    overrides: Overrides = None,
    dialects: Annotated[
        bool,
        typer.Option("--dialects", help="Also the contacts as Rocky, PFC, LAMMPS and LIGGGHTS take them."),
    ] = False,
) -> None:
    """Check a case and print what is known before a run.

    Where kernels are compiled, the case is marched for two seconds to forecast the time of the run.
    """
    loaded = load(case, overrides)
    from nutamill.design.check import check as checked
    from nutamill.design.dialects import dialect_lines
    from nutamill.simulation.fmus.trust import fmu_lines
    from nutamill.simulation.setup.charge import contact_law_of
    from nutamill.simulation.trial import trial_rate
    from nutamill.simulation.warm_up import warm_up

    if loaded.charge.parts:
        warm_up(lambda text: typer.echo(text, err=True), law=contact_law_of(loaded.machine))
    more = fmu_lines(loaded.machine) + (dialect_lines(loaded.machine) if dialects else [])
    echo_lines(checked(loaded, trial_rate).lines() + more)


@app.command()
@reports_errors
def show(
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE|RESULT.h5",
            help="A case or a result.",
            autocompletion=completion.cases_and_results,
        ),
    ],
    overrides: Overrides = None,
    expanded: Annotated[
        bool,
        typer.Option(
            "--expanded", help="The machine part by part: bodies, joints, walls, quantities of its drawing."
        ),
    ] = False,
) -> None:
    """Print a case with every default written out, or the summary of a result."""
    if Path(case).suffix in RESULTS:
        from nutamill.result import open_result

        for option, given in (("--set", overrides), ("--expanded", expanded)):
            if given:
                what = "has no use for a result, whose case is as it was run"
                raise CaseError(Fault(option, what, "Leave it out, or give the case"))
        with open_result(case) as result:
            summary, warnings = _summary(result)
            echo_lines([*summary, *warnings, *_facts(result)])
    else:
        loaded = load(case, overrides)
        typer.echo((loaded.machine if expanded else loaded).to_toml(), nl=False)


def _summary(result: "Result") -> tuple[list[str], list[str]]:
    """Return the summary lines of a result, and its warnings."""
    if result.state == MEASURED:
        from nutamill.analysis.measured_import import measured_lines

        return measured_lines(result), []
    from nutamill.analysis.summary import summary_lines, warning_lines

    return summary_lines(result), warning_lines(result)


def _facts(result: "Result") -> list[str]:
    """Return title, state, steps and provenance of a result, one fact a line."""
    from nutamill.base.units import shown
    from nutamill.case import case_of_text

    facts: dict[str, Any] = {"title": case_of_text(result.case_text).title} if result.case_text else {}
    if not result.verifiable:
        facts["checksums"] = "none, the file is of format 1: what it holds cannot be verified"
    facts |= {"state": result.state, **result.summary, **result.provenance}
    facts |= {key: shown(facts[key], "us") for key in ("substep", "mechanism_step") if key in facts}
    if "wall_time" in facts:
        facts["wall_time"] = f"{facts['wall_time']:.1f} s"
    width = max(map(len, facts))
    return [printable(f"{key:{width}}  {value}") for key, value in facts.items()]
