"""Answers for a designer from a result: each prints a table and saves a figure."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nutamill.cli.common import Last, ResultFile, app, quantity, reports_errors

if TYPE_CHECKING:
    pass
from nutamill.cli.answer_picture import Picture, picture_name, picture_place, print_answer


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
        picture = picture_place(to, picture_name(file, "orders", name, drive), file.parent)
        answer, field = sensor_orders(result, name, drive=drive), result.field(name)
        falls = waterfall(result, name, drive=drive)
        print_answer(orders_lines(answer, field), draw_orders(answer, falls, field), picture)


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
        picture = picture_place(to, picture_name(file, "loads", chosen, last), file.parent)
        rods = rods_lines(yoke_rods(result, last)) if drawn_rods(result) else []
        print_answer(loads_lines(table, chosen) + rods, figure, picture)


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
        picture = picture_place(to, picture_name(file, "mounts", last), file.parent)
        lines = mounts_lines(result, last)
        if lengths:
            lines.append(
                clearance_line(
                    chamber_clearance(result, lengths, quantity("--opening", opening, "length"), fixed_to)
                )
            )
        print_answer(lines, draw_floor(result, last), picture)


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
        stem = picture_name(file, "life", ratings.stem, *(bearing or ()), last)
        picture = picture_place(to, stem, file.parent)
        bearings = [bearing_life(result, joint, rated, last) for joint in bearing or rated.bearings]
        sections = [] if bearing else [section_life(result, name, rated, last) for name in rated.sections]
    lines = (bearings_lines(bearings) if bearings else []) + (sections_lines(sections) if sections else [])
    print_answer(lines, draw_lives(bearings, sections), picture)
