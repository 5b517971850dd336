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
        from nutamill.units import Kind

        end = _quantity("--until", until, Kind.TIME)
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
    from nutamill.campaign.workers import cluster_client
    from nutamill.papers.table import print_table

    client = None if cluster is None or stored else cluster_client(cluster, jobs)
    done = room.validate(paper, quick, only or [], results, not stored, jobs, client, typer.echo)
    print_table(done.findings, done.paper)
    for line in (*done.failures, *done.undrawn):
        typer.echo(line, err=True)
    if short is not None:
        room.write_short(short, done, paper)
    typer.echo(f"{', '.join(str(file) for file in done.files)}")


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
        list[str], typer.Argument(help="run, power, impacts, wall, flow, orbit; history:SERIES,..., spectrum:SERIES, orders:SERIES.")
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

    picture, ledger = path.with_suffix(".png"), path.with_name(f"{path.stem}-power.png")
    if is_mechanism(result):
        from nutamill.mechanism_figures import draw_reactions

        draw_reactions(result).savefig(picture)
        return [picture]
    draw_run(result).savefig(picture)
    draw_ledger(result).savefig(ledger)
    return [picture, ledger]


# ---- answers of a case or a result: each prints a table and saves a figure

Picture = Annotated[Path | None, typer.Option("--to", help="Picture; else beside the results.")]
ChargeMass = Annotated[bool, typer.Option("--charge", help="With the mass of the charge fixed to the chamber's base.")]


def _answer(lines: list[str], figure: Any, picture: Path | None, stem: str) -> None:
    """Print a table, save its figure and say where."""
    typer.echo("\n".join(lines))
    path = picture or Path("results") / f"{stem}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    typer.echo(f"picture {path}")


def _load_mill(name: str, overrides: list[str] | None) -> "Case":
    """A case that is a mill, not a mechanism of listed parts."""
    from nutamill.case import MechanismCase

    loaded = _load(name, overrides)
    if isinstance(loaded, MechanismCase):
        raise CaseError(Fault(name, "must be a mill, it lists the parts of a mechanism", "Ask nutamill check, or run it"))
    return loaded


@app.command()
@_told
def modes(
    case: CaseName,
    overrides: Overrides = None,
    speed: Annotated[str, typer.Option(help='Driveshaft speed, e.g. "700 rpm".')] = "0 rpm",
    charge: ChargeMass = False,
    to: Picture = None,
) -> None:
    """Natural frequencies, damping and shapes of the mill on its mounts, at rest or at speed."""
    from nutamill.design.modes import machine_modes, modes_lines
    from nutamill.design_figures import draw_modes

    loaded = _load_mill(case, overrides)
    found = machine_modes(loaded, _quantity("--speed", speed, "speed of rotation"), charge)
    _answer(modes_lines(found), draw_modes(loaded, found), to, f"{loaded.name}-modes")


@app.command()
@_told
def campbell(case: CaseName, overrides: Overrides = None, charge: ChargeMass = False, to: Picture = None) -> None:
    """Campbell diagram of the mill, and the speeds to avoid."""
    from nutamill.design.modes import avoid_lines
    from nutamill.design.modes import campbell as diagram
    from nutamill.design_figures import draw_campbell

    loaded = _load_mill(case, overrides)
    found = diagram(loaded, charge=charge)
    _answer(avoid_lines(found), draw_campbell(found), to, f"{loaded.name}-campbell")


Last = Annotated[str, typer.Option(help="Length of the steady window.")]


@app.command()
@_told
def orders(
    file: ResultFile,
    sensor: Annotated[str, typer.Option(help="A recorded series; `nutamill info fields` lists them.")] = "crank_pin_force_resultant",
    to: Picture = None,
) -> None:
    """Amplitude and phase of a series once and twice per turn over a run, and its waterfall."""
    from nutamill.reading_figures import draw_orders
    from nutamill.readings.orders import orders_lines, sensor_orders, waterfall
    from nutamill.readings.source import open_mill_result

    with open_mill_result(file) as result:
        found = sensor_orders(result, sensor)
        _answer(orders_lines(found, sensor), draw_orders(found, waterfall(result, sensor), sensor), to, f"{file.stem}-orders")


@app.command()
@_told
def loads(
    file: ResultFile,
    axes: Annotated[str, typer.Option(help='"ground", "frame", "crank" or "chamber".')] = "frame",
    last: Last = "3 s",
    to: Picture = None,
) -> None:
    """Reaction of every joint: mean, r.m.s., peak, orders, polar plots; and the forces in the rods of a yoke."""
    from nutamill.case import Case
    from nutamill.reading_figures import draw_loads
    from nutamill.readings.load_paths import load_paths, loads_lines
    from nutamill.readings.rods import rods_lines, yoke_rods
    from nutamill.readings.source import open_mill_result

    with open_mill_result(file) as result:
        figure = draw_loads(result, axes, last)
        rods = rods_lines(yoke_rods(result, last)) if Case.from_toml(result.case_text).rods else []
        _answer(loads_lines(load_paths(result, last), axes) + rods, figure, to, f"{file.stem}-loads-{axes}")


@app.command()
@_told
def mounts(
    file: ResultFile,
    last: Last = "3 s",
    ring: Annotated[tuple[str, str] | None, typer.Option(help="Radius and depth of the chamber's widest edge, for its clearance.")] = None,
    opening: Annotated[str, typer.Option(help="Radius of the opening around it.")] = "100 mm",
    fixed_to: Annotated[str, typer.Option(help='Where the opening is: "frame" or "ground".')] = "frame",
    to: Picture = None,
) -> None:
    """Travel and force of the mounts, the force on the floor, and the clearance of the chamber."""
    from nutamill.reading_figures import draw_floor
    from nutamill.readings.mounts import chamber_clearance, clearance_line, mounts_lines
    from nutamill.readings.source import open_mill_result

    lengths = [_quantity("--ring", text, "length") for text in ring or ()]
    with open_mill_result(file) as result:
        lines = mounts_lines(result, last)
        if lengths:
            lines.append(clearance_line(chamber_clearance(result, tuple(lengths), _quantity("--opening", opening, "length"), fixed_to)))
        _answer(lines, draw_floor(result, last), to, f"{file.stem}-mounts")


@app.command()
@_told
def life(
    file: ResultFile,
    ratings: Annotated[Path, typer.Argument(metavar="RATINGS.toml", help="Bearings and sections with their catalogue data.")],
    bearing: Annotated[list[str] | None, typer.Option(help="Joints whose bearings are asked for; all that are rated if left out.")] = None,
    last: Last = "3 s",
    to: Picture = None,
) -> None:
    """Life of bearings (L10), shafts and pins (rainflow, Goodman, Miner) under the loads of a run."""
    from nutamill.case.ratings import load_ratings
    from nutamill.reading_figures import draw_lives
    from nutamill.readings.bearings import bearing_life, bearings_lines
    from nutamill.readings.fatigue import section_life, sections_lines
    from nutamill.readings.source import open_mill_result

    rated = load_ratings(ratings)
    with open_mill_result(file) as result:
        bearings = [bearing_life(result, joint, rated, last) for joint in bearing or rated.bearings]
        sections = [] if bearing else [section_life(result, name, rated, last) for name in rated.sections]
    lines = (bearings_lines(bearings) if bearings else []) + (sections_lines(sections) if sections else [])
    _answer(lines, draw_lives(bearings, sections), to, f"{file.stem}-life")


@app.command()
@_told
def runup(
    case: CaseName,
    overrides: Overrides = None,
    ramp: Annotated[list[str] | None, typer.Option(help='Rates of the ramp, e.g. --ramp "35 rpm/s" --ramp "140 rpm/s".')] = None,
    sensor: Annotated[str | None, typer.Option(help="A recorded series; the case's first accelerometer if left out.")] = None,
    charge: ChargeMass = False,
    to: Picture = None,
) -> None:
    """How far the empty mill shakes on its way through the resonances, for several ramps."""
    from nutamill.design.runup import default_sensor, run_up, run_up_lines
    from nutamill.design_figures import draw_run_up

    loaded = _load_mill(case, overrides)
    rates = [_quantity("--ramp", text, "ramp of speed") for text in ramp or ("35 rpm/s", "70 rpm/s", "140 rpm/s", "350 rpm/s")]
    name = sensor or default_sensor(loaded)
    runs = run_up(loaded, rates, name, charge=charge)
    _answer(run_up_lines(runs, name), draw_run_up(runs, name), to, f"{loaded.name}-runup")


@app.command()
@_told
def isolation(case: CaseName, overrides: Overrides = None, charge: ChargeMass = False, to: Picture = None) -> None:
    """Which share of the shaking force the mounts pass on to the floor, over speed."""
    from nutamill.design.isolation import isolation as passed_on
    from nutamill.design.isolation import isolation_lines
    from nutamill.design_figures import draw_isolation

    loaded = _load_mill(case, overrides)
    found = passed_on(loaded, charge)
    _answer(isolation_lines(found), draw_isolation(found), to, f"{loaded.name}-isolation")


@app.command()
@_told
def balance(
    case: CaseName,
    overrides: Overrides = None,
    plane: Annotated[list[str] | None, typer.Option(metavar='"RADIUS, DEPTH"', help='A plane, e.g. "80 mm, 420 mm"; one or two.')] = None,
    speed: Annotated[str | None, typer.Option(help="Driveshaft speed; the case's if left out.")] = None,
    grade: Annotated[float, typer.Option(min=0.1, help="Balance quality grade G to compare with, ISO 21940-11 [mm/s].")] = 16.0,
    charge: ChargeMass = False,
    to: Picture = None,
) -> None:
    """Balance masses on the driveshaft that make the machine shake least."""
    from nutamill.design.balancing import balance_lines, balance_mill
    from nutamill.design_figures import draw_balancing

    loaded = _load_mill(case, overrides)
    given = [[_quantity("--plane", length.strip(), "length") for length in text.split(",")] for text in plane or ()]
    if any(len(lengths) != 2 for lengths in given):
        raise CaseError(Fault("--plane", "must be a radius and a depth", 'Write e.g. --plane "80 mm, 420 mm"'))
    planes = [tuple(lengths) for lengths in given] or [(loaded.balance.radius, loaded.balance.depth)]
    found = balance_mill(loaded, planes, None if speed is None else _quantity("--speed", speed, "speed of rotation"), charge)
    _answer(balance_lines(found, loaded, grade), draw_balancing(found, loaded), to, f"{loaded.name}-balance")


if __name__ == "__main__":
    sys.exit(app())
