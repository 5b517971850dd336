"""The command line: reads what was typed, calls the package, prints; computes nothing.

Exit codes: 0 done, 1 the run failed, 2 bad input, 3 not steady within the longest time, 130 interrupted.  Heavy
imports stand inside the commands, so that ``--help`` answers at once.
"""

import functools
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nutamill import __version__
from nutamill.errors import CaseError, Fault, MillError, NotSteadyError

if TYPE_CHECKING:
    from nutamill.case import Case
    from nutamill.result import Result
    from nutamill.screen import Screen

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
info_app = typer.Typer(no_args_is_help=True, help="Say what the package knows.")
app.add_typer(info_app, name="info")

INTERRUPTED = 130

CaseName = Annotated[str, typer.Argument(metavar="CASE", help="A case file, or a published mill such as numill.")]
Overrides = Annotated[list[str] | None, typer.Option("--set", "-s", metavar="KEY=VALUE", help='Change one key: -s drive.speed="500 rpm".')]
Quick = Annotated[bool, typer.Option("--quick", help="Demonstration: rigid mounts, short ramp, a few turns, softer contacts.")]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads of the charge.")]


def _told(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose faults are printed, one line each, instead of raised."""

    @functools.wraps(command)
    def telling(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
        except MillError as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None

    return telling


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"nutamill {__version__}")
        raise typer.Exit


@app.callback()
def main(version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False) -> None:
    """Simulate nutating mills: the machine and the charge inside it, coupled."""


@app.command()
@_told
def new(
    file: Annotated[Path, typer.Argument(help="The file to write.")],
    base: Annotated[str, typer.Option("--from", help="A published mill or another case file.")] = "numill",
) -> None:
    """Write a short case file to change: a base and the keys people change."""
    from nutamill.case.starter import write_starter

    write_starter(base, file)
    typer.echo(f"{file} written. Next: nutamill check {file}")


@app.command()
@_told
def check(
    case: CaseName,
    overrides: Overrides = None,
    dialects: Annotated[bool, typer.Option("--dialects", help="Also the contacts as Rocky, PFC, LAMMPS and LIGGGHTS take them.")] = False,
) -> None:
    """Say everything that can be known before a run."""
    loaded = _load(case, overrides)
    from nutamill.case import MechanismCase

    if isinstance(loaded, MechanismCase):
        from nutamill.mechanism_preflight import mechanism_preflight

        typer.echo("\n".join(mechanism_preflight(loaded).lines()))
        return
    from nutamill.build.chamber_charge import contact_law_of
    from nutamill.dialects import dialect_lines
    from nutamill.preflight import preflight
    from nutamill.warm import warm_up

    warm_up(lambda text: typer.echo(text, err=True), law=contact_law_of(loaded))
    typer.echo("\n".join(preflight(loaded).lines() + (dialect_lines(loaded) if dialects else [])))


@app.command()
@_told
def run(
    case: CaseName,
    overrides: Overrides = None,
    to: Annotated[Path | None, typer.Option(help="Result file; else results/<case>-<hash>.h5.")] = None,
    quick: Quick = False,
    threads: Threads = None,
) -> None:
    """Run a case to a result file."""
    loaded = _load(case, overrides)
    if (quick or threads is not None) and not hasattr(loaded, "charge"):
        raise CaseError(Fault("--quick" if quick else "--threads", "is for mills with a charge, this is a mechanism", "Leave it out"))
    if quick:
        from nutamill.build.quick import banner
        from nutamill.build.quick import quick as quickened

        typer.echo(banner(loaded))
        loaded = quickened(loaded)
    if threads is not None:
        loaded = loaded.with_("run.threads", threads)
    for warning in loaded.warnings:
        typer.echo(f"warning: {warning}", err=True)
    path = to or loaded.result_file
    from nutamill import march

    _watched(loaded.title or loaded.name, path, lambda screen: march.run(loaded, to=path, progress=screen, tell=screen.message))


@app.command()
@_told
def resume(
    file: Annotated[Path, typer.Argument(metavar="RESULT.h5", help="The result of a run that was interrupted or is to go on.")],
    until: Annotated[str | None, typer.Option(help='New end, e.g. "20 s"; with run.until = "steady" the new longest time.')] = None,
) -> None:
    """Continue a run from its last checkpoint."""
    end = None
    if until is not None:
        from nutamill import units

        try:
            end = units.parse(until, units.Kind.TIME)
        except units.UnitError as error:
            raise CaseError(Fault("--until", error.what, error.hint)) from None
    from nutamill import march

    _watched(file.stem, file, lambda screen: march.resume(file, until=end, progress=screen, tell=screen.message))


@app.command()
@_told
def show(case: Annotated[str, typer.Argument(metavar="CASE|RESULT.h5", help="A case or a result.")], overrides: Overrides = None) -> None:
    """Print a case with every default written out, or the summary of a result."""
    if Path(case).suffix in (".h5", ".hdf5"):
        from nutamill.result import open_result

        with open_result(case) as result:
            facts = {"state": result.state, **result.summary, **result.provenance}
            lines = [f"{key:16}  {value}" for key, value in facts.items()]
            summary, warnings = _summary(result)
            typer.echo("\n".join([*summary, *warnings, *lines]))
    else:
        typer.echo(_load(case, overrides).to_toml(), nl=False)


@info_app.command()
@_told
def fields() -> None:
    """List every recorded quantity: name, unit, meaning."""
    from nutamill.fields import PART_SERIES, SERIES, SNAPSHOT

    width = max(len(field.name) for field in (*SERIES, *PART_SERIES, *SNAPSHOT))
    for heading, known in (("series", SERIES), ("series of a mechanism's parts", PART_SERIES), ("snapshots", SNAPSHOT)):
        typer.echo(heading)
        for field in known:
            typer.echo(f"  {field.name:{width}}  {field.unit:8}  {field.meaning}")


@info_app.command()
@_told
def mills() -> None:
    """List the published mills."""
    from nutamill.case import library_names, load_case

    for name in library_names():
        typer.echo(f"{name:14}  {load_case(name).title}")


@app.command()
@_told
def schema() -> None:
    """Print the JSON schema of case files, for completion in editors."""
    from nutamill.case.schema import case_schema

    typer.echo(json.dumps(case_schema(), indent=2))


@app.command()
@_told
def bench() -> None:
    """Measure the speed of this version on this machine; takes about two minutes."""
    from nutamill.bench import measure

    for line in measure():
        typer.echo(line)


@app.command()
@_told
def validate(
    paper: Annotated[str, typer.Argument(metavar="PAPER", help="saimm2025, mca2026, or a file of the same form.")],
    quick: Annotated[bool, typer.Option("--quick", help="Start the few decisive runs only.")] = False,
    only: Annotated[list[str] | None, typer.Option("--only", metavar="NAME", help="A row, a configuration or a run; repeatable.")] = None,
    results: Annotated[Path | None, typer.Option(help="Folder of the results; else results/validation/<paper>.")] = None,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="Runs at once; else the physical cores.")] = None,
    cluster: Annotated[str | None, typer.Option(help="Run on a Dask cluster: local, a scheduler's address, or its file (.json).")] = None,
    stored: Annotated[bool, typer.Option("--stored", help="Start no run: evaluate what is there.")] = False,
    short: Annotated[
        Path | None, typer.Option("--markdown", metavar="FILE", help="Write the short table there, between its marks if it has them.")
    ] = None,
) -> None:
    """Compare a published paper with runs of all its configurations, row by row."""
    from nutamill import validation as room
    from nutamill.campaign.command import workers_of
    from nutamill.papers.table import print_table

    done = room.validate(paper, quick, only or [], results, not stored, workers_of(jobs, cluster), typer.echo)
    print_table(done.findings, done.paper)
    for line in (*done.failures, *done.undrawn):
        typer.echo(line, err=True)
    if short is not None:
        room.write_short(short, done, paper)
    typer.echo(f"{', '.join(str(file) for file in done.files)}")


@app.command()
@_told
def sweep(
    case: Annotated[str, typer.Argument(metavar="CASE|SWEEP.toml", help="A case, or a sweep file.")],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set", "-s", metavar="KEY=VALUES", help='Swept, or one value: -s drive.speed="100..700 rpm step 60 rpm" -s chamber.ribs=0,12.'
        ),
    ] = None,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="Runs at once; else the physical cores.")] = None,
    cluster: Annotated[str | None, typer.Option(help="Run on a Dask cluster: local, a scheduler's address, or its file (.json).")] = None,
    to: Annotated[Path | None, typer.Option(help="Folder for results and table; else sweeps/<case>.")] = None,
    quick: Quick = False,
) -> None:
    """Run a case with all combinations of some values; the same call again does what is left."""
    from nutamill.campaign.command import run_sweep

    if not run_sweep(case, changes or [], jobs, cluster, to, quick, typer.echo):
        raise typer.Exit(MillError.exit_code)


@app.command()
@_told
def fit(
    file: Annotated[Path, typer.Argument(metavar="FIT.toml", help="The fit file: case, free keys, measured values.")],
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", min=1, help="Runs at once; else the physical cores.")] = None,
    cluster: Annotated[str | None, typer.Option(help="Run on a Dask cluster: local, a scheduler's address, or its file (.json).")] = None,
    to: Annotated[Path | None, typer.Option(help="Folder for results; else fits/<file>.")] = None,
) -> None:
    """Identify keys of a case from measured values, with their uncertainty and correlation."""
    from nutamill.campaign.command import run_fit

    typer.echo("\n".join(run_fit(file, jobs, cluster, to)))


@app.command("mount-test")
@_told
def mount_test(
    file: Annotated[Path, typer.Argument(metavar="TEST.csv", help="Columns time [s], displacement [mm], force [N], in any units.")],
    to: Annotated[Path | None, typer.Option(help="Picture; else beside the file.")] = None,
) -> None:
    """Stiffness and damping of a mount from a force-displacement test at one frequency."""
    from nutamill.mount_figures import draw_loop
    from nutamill.mount_test import mount_properties, read_mount_test

    test = read_mount_test(file)
    found = mount_properties(test)
    picture = to or file.with_suffix(".png")
    draw_loop(test, found).savefig(picture)
    typer.echo("\n".join([*found.lines(), f"picture {picture}"]))


def _load(name: str, overrides: list[str] | None) -> "Case":
    from nutamill.case import load_case

    return load_case(name, overrides or [])


def _watched(title: str, path: Path, act: Callable[["Screen"], "Result"]) -> None:
    """Run with the live screen, then print the summary and draw the pictures beside the result."""
    from nutamill.result import open_result
    from nutamill.screen import Screen

    missed = None
    try:
        with Screen(title) as screen:
            result = act(screen)
    except NotSteadyError as error:
        missed, result = error, open_result(path)
    except KeyboardInterrupt:
        said = f"interrupted, saved. Go on with: nutamill resume {path}" if path.exists() else "interrupted before the first step"
        typer.echo(said, err=True)
        raise typer.Exit(INTERRUPTED) from None
    with result:
        summary, warnings = _summary(result)
        typer.echo("\n".join(summary))
        for warning in warnings:
            typer.echo(warning, err=True)
        pictures = _draw(result, path)
    typer.echo(f"{path}   picture{'s' * (len(pictures) > 1)} {', '.join(map(str, pictures))}")
    if missed is not None:
        raise missed


def _summary(result: "Result") -> tuple[list[str], list[str]]:
    """What a result came to, and what is odd about it, as lines."""
    from nutamill.analysis import summary_lines, warning_lines
    from nutamill.mechanism_analysis import is_mechanism, mechanism_summary_lines, mechanism_warning_lines

    if is_mechanism(result):
        return mechanism_summary_lines(result), mechanism_warning_lines(result)
    return summary_lines(result), warning_lines(result)


def _draw(result: "Result", path: Path) -> list[Path]:
    """Draw the pictures of a run beside its result; their files."""
    from nutamill.figures import draw_ledger, draw_run
    from nutamill.mechanism_analysis import is_mechanism
    from nutamill.mechanism_figures import draw_reactions

    picture, ledger = path.with_suffix(".png"), path.with_name(f"{path.stem}-power.png")
    if is_mechanism(result):
        draw_reactions(result).savefig(picture)
        return [picture]
    draw_run(result).savefig(picture)
    draw_ledger(result).savefig(ledger)
    return [picture, ledger]


if __name__ == "__main__":
    sys.exit(app())
