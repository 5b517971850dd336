"""Commands that run a case: run, resume; and lists of what the package contains."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nutamill.base.atomic_file import RESULTS, refuse_suffix
from nutamill.base.errors import CaseError, ExitCode, Fault, Interrupted, NotSteadyError, ResultError
from nutamill.base.files import exists, is_folder
from nutamill.cli import completion
from nutamill.cli.common import CaseName, Overrides, Quick, app, load, reports_errors, to
from nutamill.cli.help import App
from nutamill.cli.paragraphs import echo_lines
from nutamill.simulation.signals import stop_at_once

if TYPE_CHECKING:
    from nutamill.case import Case, Machine
    from nutamill.cli.screen import Screen
    from nutamill.result import Result
    from nutamill.result.fields import Field
from nutamill.cli.cases import _summary

info_app = App(no_args_is_help=True, rich_markup_mode=None, help="List what the package contains.")
app.add_typer(info_app, name="info")
TrustFmu = Annotated[
    bool, typer.Option("--trust-fmu", help="Run the FMUs of the case, native code, without asking.")
]
Threads = Annotated[int | None, typer.Option(min=1, metavar="N", help="Threads of the charge.")]


@app.command()
@reports_errors
def run(
    case: CaseName,
    overrides: Overrides = None,
    to: Annotated[Path | None, to("Result file; else results/<case>-<digest>.h5.")] = None,
    quick: Quick = False,
    threads: Threads = None,
    again: Annotated[
        bool,
        typer.Option(
            "--again", help="Run the case again; an earlier result stays until the new one is whole."
        ),
    ] = False,
    trust_fmu: TrustFmu = False,
) -> None:
    """Run a case to a result file. If it is complete already, show it."""
    with stop_at_once():
        _run(load(case, overrides), to, quick, threads, again, trust_fmu)


def _run(
    loaded: "Case | Machine",
    to: Path | None,
    quick: bool,
    threads: int | None,
    again: bool,
    trust_fmu: bool,
) -> None:
    from nutamill.simulation.lammps.ranks import follows

    if threads is not None and not loaded.charge.parts:
        raise CaseError(Fault("--threads", "has no use for a machine without a charge", "Leave it out"))
    if quick:
        from nutamill.simulation.setup.quick import banner
        from nutamill.simulation.setup.quick import quick as quickened

        shorter = quickened(loaded)
        if not follows():
            typer.echo(banner(loaded))
        loaded = shorter
    if threads is not None:
        loaded = loaded.with_("run.threads", threads)
    for warning in () if follows() else loaded.warnings:
        echo_lines([f"warning: {warning}"], err=True)
    path = to or loaded.file_in()
    refuse_suffix(path, RESULTS)
    from nutamill.simulation import runs

    trusted = _trusted(loaded, trust_fmu)
    _run_on_screen(
        loaded.title or loaded.name,
        path,
        lambda screen: runs.run(
            loaded, to=path, progress=screen, log=screen.message, again=again, trust_fmu=trusted
        ),
    )


@app.command()
@reports_errors
def resume(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="RESULT.h5",
            help="The result of a run that was interrupted or is to go on.",
            autocompletion=completion.results,
        ),
    ],
    until: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help='New end, e.g. "20 s"; with run.until = "steady" the new longest time.'
        ),
    ] = None,
    trust_fmu: TrustFmu = False,
) -> None:
    """Continue a run from its last checkpoint."""
    with stop_at_once():
        from nutamill.simulation import runs

        trusted = _trusted_earlier(file, trust_fmu) if exists(file) and not is_folder(file) else False

        _run_on_screen(
            file.stem,
            file,
            lambda screen: runs.resume(
                file, until=until, progress=screen, log=screen.message, trust_fmu=trusted
            ),
        )


@info_app.command()
@reports_errors
def fields(
    of: Annotated[
        str | None,
        typer.Argument(
            metavar="[CASE|RESULT.h5]",
            help="List only the series that it records.",
            autocompletion=completion.cases_and_results,
        ),
    ] = None,
) -> None:
    """List every recorded quantity: name, unit, meaning."""
    from nutamill.result.fields import PART_SERIES, SERIES, SNAPSHOT

    lists: list[tuple[str, Sequence[Field]]] = [
        ("series", SERIES),
        ("series of a mechanism's parts", PART_SERIES),
        ("snapshots", SNAPSHOT),
    ]
    if of is not None:
        lists = [("series", _fields_of(of))]
    width = max(len(field.name) for _, known in lists for field in known)
    for heading, known in lists:
        typer.echo(heading)
        for field in known:
            echo_lines([f"  {field.name:{width}}  {field.unit:8}  {field.meaning}"])


def _fields_of(name: str) -> "list[Field]":
    """Return the series of a result file, or those that a case will record."""
    if Path(name).suffix in RESULTS:
        from nutamill.result import open_result

        with open_result(name) as result:
            return [result.field(str(series)) for series in result.series.variables]
    from nutamill.simulation.setup.model import recorded_fields

    return recorded_fields(load(name, []).machine)


@info_app.command()
@reports_errors
def mills() -> None:
    """List the machines that come with the package."""
    from nutamill.case import library_file, library_names, load_case

    files = {name: library_file(name) for name in library_names()}
    short = {file.stem: name for name, file in files.items() if file is not None and file.stem != name}
    names = [name for name in library_names() if name not in short.values()]
    for name in names:
        also = f"; short: {short[name]}" if name in short else ""
        typer.echo(f"{name:{max(map(len, names))}}  {load_case(name).title}{also}")


def _trusted(case: "Case | Machine", trusted: bool) -> bool:
    """Show the FMUs of a case and ask once whether to run them, where a terminal can answer."""
    if trusted or not case.machine.fmus:
        return trusted
    from nutamill.simulation.fmus.trust import code_lines

    if not sys.stdin.isatty():
        return False
    typer.echo("\n".join(["The case runs native code of other programs:", *code_lines(case.machine)]))
    return typer.confirm("Run it?")


def _trusted_earlier(file: Path, trusted: bool) -> bool:
    """Show the FMUs of the case of a result file and ask once, as `_trusted` does."""
    from nutamill.case import case_of_text
    from nutamill.result import open_result

    with open_result(file) as earlier:
        text = earlier.case_text
    return _trusted(case_of_text(text, file.stem), trusted) if text else False


def _run_on_screen(title: str, path: Path, march: Callable[["Screen"], "Result"]) -> None:
    """Run with the live screen, then print the summary and draw the pictures beside the result."""
    from nutamill.cli.screen import Screen
    from nutamill.result import open_result
    from nutamill.simulation.lammps.ranks import follows

    if follows():
        march(Screen(title, quiet=True))  # the first process has the screen; this one ends in it
    not_steady = None
    try:
        with Screen(title) as screen:
            result = march(screen)
    except NotSteadyError as error:
        not_steady, result = error, open_result(path)
    except Interrupted as stop:
        typer.echo(f"interrupted, saved. Go on with: nutamill resume {stop.path}", err=True)
        raise typer.Exit(ExitCode.INTERRUPTED) from None
    except KeyboardInterrupt:
        typer.echo("interrupted before the first step, there was nothing to save", err=True)
        raise typer.Exit(ExitCode.INTERRUPTED) from None
    with result:
        summary, warnings = _summary(result)
        echo_lines(summary)
        echo_lines(warnings, err=True)
        pictures = _draw(result, path)
    typer.echo(f"{path}   picture{'s' * (len(pictures) > 1)} {', '.join(map(str, pictures))}")
    if not_steady is not None:
        raise not_steady


def _draw(result: "Result", path: Path) -> list[Path]:
    """Draw the pictures of a run beside its result, and return their files."""
    from nutamill.view.figures.named import figure_of
    from nutamill.view.figures.saving import save_figure

    picture, ledger = path.with_suffix(".png"), path.with_name(f"{path.stem}-power.png")
    pictures = [save_figure(figure_of(result, "run"), picture)]
    try:
        return [*pictures, save_figure(figure_of(result, "power"), ledger)]
    except ResultError:  # nothing is lost in this machine, or nothing has happened yet
        return pictures
