"""The command line: reads what was typed, calls the package, prints; computes nothing.

Exit codes: 0 done, 1 the run failed, 2 bad input, 130 interrupted.  Heavy imports stand inside the commands, so that
``--help`` answers at once.
"""

import functools
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nutamill import __version__
from nutamill.errors import CaseError, Fault, MillError

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
ResultFile = Annotated[Path, typer.Argument(metavar="RESULT.h5", help="A result file.")]
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
    until: Annotated[str | None, typer.Option(help='New end, e.g. "20 s"; else the end the case asks for.')] = None,
) -> None:
    """Continue a run from its last checkpoint."""
    end = None
    if until is not None:
        from nutamill.units import Kind

        end = _quantity("--until", until, Kind.TIME)
    from nutamill import march

    _watched(file.stem, file, lambda screen: march.resume(file, until=end, progress=screen, tell=screen.message))


@app.command()
@_told
def show(case: Annotated[str, typer.Argument(metavar="CASE|RESULT.h5", help="A case or a result.")], overrides: Overrides = None) -> None:
    """Print a case with every default written out, or the summary of a result."""
    if Path(case).suffix in (".h5", ".hdf5"):
        from nutamill.analysis import summary_lines, warning_lines
        from nutamill.result import open_result

        with open_result(case) as result:
            facts = {"state": result.state, **result.summary, **result.provenance}
            lines = [f"{key:16}  {value}" for key, value in facts.items()]
            typer.echo("\n".join([*summary_lines(result), *warning_lines(result), *lines]))
    else:
        typer.echo(_load(case, overrides).to_toml(), nl=False)


@info_app.command()
@_told
def fields() -> None:
    """List every recorded quantity: name, unit, meaning."""
    from nutamill.fields import SERIES, SNAPSHOT

    width = max(len(field.name) for field in (*SERIES, *SNAPSHOT))
    for heading, known in (("series", SERIES), ("snapshots", SNAPSHOT)):
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
def view(
    file: ResultFile,
    html: Annotated[Path | None, typer.Option(help="The page to write; else beside the result.")] = None,
    frames: Annotated[int, typer.Option(min=1, help="Most moments to show.")] = 200,
) -> None:
    """Write one HTML file in which the mill turns and the charge moves; it opens in any browser, without a network."""
    from nutamill.result import open_result
    from nutamill.webview import write_view

    with open_result(file) as result:
        page = write_view(result, html or file.with_suffix(".html"), frames)
    typer.echo(f"{page}   {page.stat().st_size / 1e6:.1f} MB, open it in a browser")


Camera = Annotated[str, typer.Option(help="front, inside (riding on the chamber) or axis (down the shaft).")]
ColourBy = Annotated[str, typer.Option("--colour", help="What colours the charge: speed, height, force or material.")]


@app.command()
@_told
def picture(
    file: ResultFile, png: Annotated[Path, typer.Argument(help="The picture.")], camera: Camera = "front", colour: ColourBy = "speed"
) -> None:
    """Draw the last snapshot in three dimensions; needs the extra "view"."""
    from nutamill.result import open_result
    from nutamill.scene import draw_scene

    with open_result(file) as result:
        typer.echo(draw_scene(result, png, camera, colour))


@app.command()
@_told
def movie(
    file: ResultFile,
    mp4: Annotated[Path, typer.Argument(help="The film.")],
    camera: Camera = "front",
    colour: ColourBy = "speed",
    slow: Annotated[float, typer.Option(min=1.0, help="How many times slower than real.")] = 40.0,
) -> None:
    """Film all snapshots in three dimensions; needs the extra "view"."""
    from nutamill.result import open_result
    from nutamill.scene import film_scene

    with open_result(file) as result:
        typer.echo(film_scene(result, mp4, camera, colour, slow))


@app.command()
@_told
def export(file: ResultFile, vtkhdf: Annotated[Path, typer.Option(help="File for ParaView: charge and machine over time.")]) -> None:
    """Write the snapshots of a result for another program."""
    from nutamill.export.vtkhdf import write_vtkhdf
    from nutamill.result import open_result

    with open_result(file) as result:
        typer.echo(write_vtkhdf(result, vtkhdf))


@app.command()
@_told
def plot(
    file: ResultFile,
    what: Annotated[
        list[str], typer.Argument(help="run, power, impacts, wall, flow, orbit; history:SERIES,..., spectrum:SERIES, waterfall:SERIES.")
    ],
    to: Annotated[Path | None, typer.Option(help="Folder of the pictures; else that of the result.")] = None,
) -> None:
    """Draw figures of a result."""
    from nutamill.plots import write_figures
    from nutamill.result import open_result

    with open_result(file) as result:
        typer.echo("\n".join(map(str, write_figures(result, what, to or file.parent))))


@app.command()
@_told
def report(
    files: Annotated[list[Path], typer.Argument(metavar="RESULT.h5 ...", help="Results.")],
    to: Annotated[Path | None, typer.Option(help="The page; else beside the first result.")] = None,
) -> None:
    """Write one HTML page: case, steady values, where the power goes, figures, the moving charge, provenance."""
    from nutamill.report import write_report

    page = write_report(files, to or files[0].with_name(f"{files[0].stem}-report.html"))
    typer.echo(f"{page}   {page.stat().st_size / 1e6:.1f} MB")


@app.command("import")
@_told
def import_measured(
    file: Annotated[Path, typer.Argument(help="A test file: CSV, TDMS, MAT or UFF.")],
    mapping: Annotated[Path, typer.Option("--map", help="What its columns are: a mapping file.")],
    to: Annotated[Path | None, typer.Option(help="The file to write; else beside the test file.")] = None,
) -> None:
    """Read measured data, so that plot and compare can use them."""
    from nutamill.measured.importing import import_test

    typer.echo(import_test(file, mapping, to or file.with_suffix(".h5")))


@app.command()
@_told
def compare(
    run: ResultFile,
    measured: Annotated[Path, typer.Argument(metavar="MEASURED.h5", help="What `nutamill import` has written.")],
    last: Annotated[str, typer.Option(help="Length of the window at the end.")] = "3 s",
    cut: Annotated[str | None, typer.Option("--filter", help='Low-pass filter for both, e.g. "200 Hz".')] = None,
    picture: Annotated[Path | None, typer.Option(help="The overlay; else beside the run.")] = None,
) -> None:
    """Lay measured data over a run: steady values with errors, and a figure."""
    from nutamill.measured.comparison import compare, comparison_lines
    from nutamill.measured_figures import draw_comparison
    from nutamill.result import open_result
    from nutamill.units import Kind

    window, edge = _quantity("--last", last, Kind.TIME), None if cut is None else _quantity("--filter", cut, Kind.FREQUENCY)
    with open_result(run) as result, open_result(measured) as test:
        rows = compare(result, test, window, edge)
        typer.echo("\n".join(comparison_lines(rows)))
        drawn = picture or run.with_name(f"{run.stem}-{measured.stem}.png")
        draw_comparison(result, test, [row.name for row in rows], window, edge).savefig(drawn)
    typer.echo(drawn)


def _quantity(where: str, text: str, kind: Any) -> float:
    """SI value of an option with a unit."""
    from nutamill import units

    try:
        return units.parse(text, kind)
    except units.UnitError as error:
        raise CaseError(Fault(where, error.what, error.hint)) from None


def _load(name: str, overrides: list[str] | None) -> "Case":
    from nutamill.case import load_case

    return load_case(name, overrides or [])


def _watched(title: str, path: Path, act: Callable[["Screen"], "Result"]) -> None:
    """Run with the live screen, then print the summary and draw the picture beside the result."""
    from nutamill.analysis import summary_lines, warning_lines
    from nutamill.figures import draw_ledger, draw_run
    from nutamill.screen import Screen

    try:
        with Screen(title) as screen:
            result = act(screen)
    except KeyboardInterrupt:
        said = f"interrupted, saved. Go on with: nutamill resume {path}" if path.exists() else "interrupted before the first step"
        typer.echo(said, err=True)
        raise typer.Exit(INTERRUPTED) from None
    with result:
        typer.echo("\n".join(summary_lines(result)))
        for warning in warning_lines(result):
            typer.echo(warning, err=True)
        picture = path.with_suffix(".png")
        draw_run(result).savefig(picture)
        ledger = path.with_name(f"{path.stem}-power.png")
        draw_ledger(result).savefig(ledger)
    typer.echo(f"{path}   pictures {picture}, {ledger}")


if __name__ == "__main__":
    sys.exit(app())
