"""Answers for a designer, of a case or a result: each prints a table and saves a figure."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nutamill.base.errors import CaseError, Fault
from nutamill.cli.common import (
    CaseName,
    Last,
    Overrides,
    ResultFile,
    app,
    load,
    quantity,
    reports_errors,
    to,
)
from nutamill.cli.paragraphs import echo_lines
from nutamill.cli.working import working

if TYPE_CHECKING:
    from nutamill.case import Case, Machine

Picture = Annotated[Path | None, to("The picture; else beside the result, or in results/.")]
ChargeMass = Annotated[
    bool, typer.Option("--charge", help="With the mass of the charge fixed to the chamber's base.")
]
RESULTS = Path("results")


def _place(picture: Path | None, stem: str, folder: Path = RESULTS) -> Path:
    """Return where a picture goes, that of a case among the results, that of a result beside it. Refuse a
    place that cannot be written.
    """
    from nutamill.base.atomic_file import check_writable
    from nutamill.view.figures.saving import SUFFIXES

    path = picture or folder / f"{stem}.png"
    check_writable(path, SUFFIXES)
    return path


def _print_answer(lines: list[str], figure: Any, picture: Path) -> None:
    """Print a table, save its figure and say where."""
    from nutamill.view.figures.saving import save_figure

    echo_lines(lines)
    typer.echo(f"picture {save_figure(figure, picture)}")


def _picture_name(
    subject: "Case | Machine | Path", question: str, *options: str | None, charge: bool = False
) -> str:
    """Return the name of a picture without its suffix, one for each answer, so that none overwrites another.

    It holds the name of the case with its digest, or that of the result, as result files have it; the
    question; and the options that were given.
    """
    stem = subject.stem if isinstance(subject, Path) else subject.file_in().stem
    given = [option for option in (*options, "charge" if charge else None) if option]
    return "-".join([stem, question, *(re.sub(r"[^\w.+-]", "", option) for option in given)])


@app.command()
@reports_errors
def modes(
    case: CaseName,
    overrides: Overrides = None,
    speed: Annotated[
        str, typer.Option(metavar="SPEED", help='Speed of the drive, e.g. "700 rpm".')
    ] = "0 rpm",
    charge: ChargeMass = False,
    to: Picture = None,
) -> None:
    """Print natural frequencies, damping and shapes of a machine on its mounts, at rest or at speed."""
    from nutamill.design.figures import draw_modes
    from nutamill.design.modes import machine_modes, modes_lines
    from nutamill.design.sticks import sticks

    loaded, turning = load(case, overrides), quantity("--speed", speed, "speed of rotation")
    picture = _place(to, _picture_name(loaded, "modes", speed if turning else None, charge=charge))
    answer = machine_modes(loaded, turning, charge)
    _print_answer(modes_lines(answer), draw_modes(sticks(loaded), answer), picture)


@app.command()
@reports_errors
def campbell(
    case: CaseName, overrides: Overrides = None, charge: ChargeMass = False, to: Picture = None
) -> None:
    """Draw the Campbell diagram of a machine, and print the speeds to avoid."""
    from nutamill.design.figures import draw_campbell
    from nutamill.design.modes import avoid_lines
    from nutamill.design.modes import campbell as diagram

    loaded = load(case, overrides)
    picture = _place(to, _picture_name(loaded, "campbell", charge=charge))
    with working("modes over the speed"):
        answer = diagram(loaded, charge=charge)
    _print_answer(avoid_lines(answer), draw_campbell(answer), picture)


@app.command()
@reports_errors
def runup(
    case: CaseName,
    overrides: Overrides = None,
    ramp: Annotated[
        list[str] | None,
        typer.Option(metavar="RAMP", help='Rates of the ramp, e.g. --ramp "35 rpm/s" --ramp "140 rpm/s".'),
    ] = None,
    sensor: Annotated[
        str | None,
        typer.Option(metavar="SERIES", help="A recorded series; the case's first accelerometer if left out."),
    ] = None,
    charge: ChargeMass = False,
    to: Picture = None,
) -> None:
    """Print how far the empty machine shakes on its way through the resonances, for several ramps."""
    from nutamill.design.figures import draw_run_up
    from nutamill.design.runup import run_up, run_up_lines

    loaded = load(case, overrides)
    picture = _place(to, _picture_name(loaded, "runup", *(ramp or ()), sensor, charge=charge))
    rates = [
        quantity("--ramp", text, "ramp of speed")
        for text in ramp or ("35 rpm/s", "70 rpm/s", "140 rpm/s", "350 rpm/s")
    ]
    runs = []
    for number, rate in enumerate(rates, start=1):
        with working(f"run-up {number} of {len(rates)}"):
            runs += run_up(loaded, [rate], sensor, charge=charge)
    _print_answer(run_up_lines(runs), draw_run_up(runs), picture)


@app.command()
@reports_errors
def isolation(
    case: CaseName, overrides: Overrides = None, charge: ChargeMass = False, to: Picture = None
) -> None:
    """Print which share of the shaking force the mounts pass on to the floor, over speed."""
    from nutamill.design.figures import draw_isolation
    from nutamill.design.isolation import isolation as passed_on
    from nutamill.design.isolation import isolation_lines

    loaded = load(case, overrides)
    picture = _place(to, _picture_name(loaded, "isolation", charge=charge))
    with working("a slow run-up through all speeds"):
        answer = passed_on(loaded, charge)
    _print_answer(isolation_lines(answer), draw_isolation(answer), picture)


@app.command()
@reports_errors
def balance(
    case: CaseName,
    overrides: Overrides = None,
    plane: Annotated[
        list[str] | None,
        typer.Option(metavar='"RADIUS, DEPTH"', help='A plane, e.g. "80 mm, 420 mm"; one or two.'),
    ] = None,
    speed: Annotated[
        str | None, typer.Option(metavar="SPEED", help="Driveshaft speed; the case's if left out.")
    ] = None,
    grade: Annotated[
        float,
        typer.Option(
            min=0.1, metavar="G", help="Balance quality grade G to compare with, ISO 21940-11 (mm/s)."
        ),
    ] = 16.0,
    charge: ChargeMass = False,
    to: Picture = None,
) -> None:
    """Balance masses on the driveshaft that make the machine shake least."""
    from nutamill.base.schema import spelled
    from nutamill.design.balancing import balance_lines, balance_mill
    from nutamill.design.figures import draw_balancing

    loaded = load(case, overrides)
    picture = _place(to, _picture_name(loaded, "balance", *(plane or ()), speed, charge=charge))
    given = [
        [quantity("--plane", length.strip(), "length") for length in text.split(",")] for text in plane or ()
    ]
    if any(len(lengths) != 2 for lengths in given):
        raise CaseError(
            Fault(
                "--plane",
                f"must be a radius and a depth, got {', '.join(map(spelled, plane or ()))}",
                'Write e.g. --plane "80 mm, 420 mm"',
            )
        )
    planes = [(radius, depth) for radius, depth in given]
    if not planes and (mill := loaded.drawing) is not None:
        planes = [(mill.balance.radius, mill.balance.depth)]
    turning = None if speed is None else quantity("--speed", speed, "speed of rotation")
    with working("runs with trial masses"):
        answer = balance_mill(loaded, planes, turning, charge)
    _print_answer(balance_lines(answer, loaded, grade), draw_balancing(answer, loaded), picture)


@app.command()
@reports_errors
def orders(
    file: ResultFile,
    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="SERIES",
            help="A recorded series; the crank-pin force, or the torque of the drive, if left out.",
        ),
    ] = None,
    drive: Annotated[
        str | None,
        typer.Option(
            metavar="DRIVE",
            help="Drive whose turns count; that of the period, or the only one, if left out.",
        ),
    ] = None,
    to: Picture = None,
) -> None:
    """Print amplitude and phase of a series once and twice per turn over a run, and draw its waterfall."""
    from nutamill.analysis.orders import default_series, orders_lines, sensor_orders, waterfall
    from nutamill.result import open_result
    from nutamill.view.figures.reading import draw_orders

    with open_result(file) as result:
        name = sensor or default_series(result, drive)
        picture = _place(to, _picture_name(file, "orders", name, drive), file.parent)
        answer, field = sensor_orders(result, name, drive=drive), result.field(name)
        falls = waterfall(result, name, drive=drive)
        _print_answer(orders_lines(answer, field), draw_orders(answer, falls, field), picture)


@app.command()
@reports_errors
def loads(
    file: ResultFile,
    axes: Annotated[
        str | None,
        typer.Option(
            metavar="AXES",
            help='"ground", or a body whose attitude is recorded: of a mill "frame", "crank", "chamber".',
        ),
    ] = None,
    last: Last = "3 s",
    to: Picture = None,
) -> None:
    """Print the reaction of every joint (mean, r.m.s., peak, orders) and the forces in the rods of a yoke,
    and draw polar plots.
    """
    from nutamill.analysis.load_paths import default_axes, load_paths, loads_lines
    from nutamill.analysis.rods import drawn_rods, rods_lines, yoke_rods
    from nutamill.result import open_result
    from nutamill.view.figures.reading import draw_loads

    with open_result(file) as result:
        chosen = axes or default_axes(result)
        table = load_paths(result, last)
        figure = draw_loads(result, chosen, last)
        picture = _place(to, _picture_name(file, "loads", chosen, last), file.parent)
        rods = rods_lines(yoke_rods(result, last)) if drawn_rods(result) else []
        _print_answer(loads_lines(table, chosen) + rods, figure, picture)


@app.command()
@reports_errors
def mounts(
    file: ResultFile,
    last: Last = "3 s",
    ring: Annotated[
        tuple[str, str] | None,
        typer.Option(
            metavar="RADIUS DEPTH",
            help='The chamber\'s widest edge, for its clearance: --ring "90 mm" "480 mm".',
        ),
    ] = None,
    opening: Annotated[
        str, typer.Option(metavar="LENGTH", help="Radius of the opening around it.")
    ] = "100 mm",
    fixed_to: Annotated[
        str, typer.Option(metavar="BODY", help='Where the opening is: "frame" or "ground".')
    ] = "frame",
    to: Picture = None,
) -> None:
    """Print travel and force of the mounts, the force on the floor, and the clearance of the chamber."""
    from nutamill.analysis.mounts import chamber_clearance, clearance_line, mounts_lines
    from nutamill.result import open_result
    from nutamill.view.figures.reading import draw_floor

    lengths = [quantity("--ring", text, "length") for text in ring or ()]
    with open_result(file) as result:
        picture = _place(to, _picture_name(file, "mounts", last), file.parent)
        lines = mounts_lines(result, last)
        if lengths:
            lines.append(
                clearance_line(
                    chamber_clearance(result, lengths, quantity("--opening", opening, "length"), fixed_to)
                )
            )
        _print_answer(lines, draw_floor(result, last), picture)


@app.command()
@reports_errors
def life(
    file: ResultFile,
    ratings: Annotated[
        Path, typer.Argument(metavar="RATINGS.toml", help="Bearings and sections with their catalogue data.")
    ],
    bearing: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOINT", help="Joints whose bearings are asked for; all that are rated if left out."
        ),
    ] = None,
    last: Last = "3 s",
    to: Picture = None,
) -> None:
    """Print the life of bearings (L10), shafts and pins (rainflow, Goodman, Miner) for the loads of a run."""
    from nutamill.analysis.bearings import bearing_life, bearings_lines
    from nutamill.analysis.fatigue import section_life, sections_lines
    from nutamill.analysis.ratings import load_ratings
    from nutamill.result import open_result
    from nutamill.view.figures.reading import draw_lives

    with open_result(file) as result:
        rated = load_ratings(ratings, result)
        picture = _place(to, _picture_name(file, "life", ratings.stem, *(bearing or ()), last), file.parent)
        bearings = [bearing_life(result, joint, rated, last) for joint in bearing or rated.bearings]
        sections = [] if bearing else [section_life(result, name, rated, last) for name in rated.sections]
    lines = (bearings_lines(bearings) if bearings else []) + (sections_lines(sections) if sections else [])
    _print_answer(lines, draw_lives(bearings, sections), picture)
