"""Answers for a designer from a case: each prints a table and saves a figure."""

from typing import TYPE_CHECKING, Annotated

import typer

from nutamill.base.errors import CaseError, Fault
from nutamill.cli.common import CaseName, Overrides, app, load, quantity, reports_errors
from nutamill.cli.working import working

if TYPE_CHECKING:
    pass
from nutamill.cli.answer_picture import Picture, picture_name, picture_place, print_answer

ChargeMass = Annotated[
    bool, typer.Option("--charge", help="With the mass of the charge fixed to the chamber's base.")
]


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
    picture = picture_place(to, picture_name(loaded, "modes", speed if turning else None, charge=charge))
    answer = machine_modes(loaded, turning, charge)
    print_answer(modes_lines(answer), draw_modes(sticks(loaded), answer), picture)


@app.command()
@reports_errors
def campbell(
    case: CaseName, overrides: Overrides = None, charge: ChargeMass = False, to: Picture = None
) -> None:
    """Draw the Campbell diagram of a machine, and print the speeds to avoid."""
    from nutamill.design.campbell import avoid_lines
    from nutamill.design.campbell import campbell as diagram
    from nutamill.design.figures import draw_campbell

    loaded = load(case, overrides)
    picture = picture_place(to, picture_name(loaded, "campbell", charge=charge))
    with working("modes over the speed"):
        answer = diagram(loaded, charge=charge)
    print_answer(avoid_lines(answer), draw_campbell(answer), picture)


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
    picture = picture_place(to, picture_name(loaded, "runup", *(ramp or ()), sensor, charge=charge))
    rates = [
        quantity("--ramp", text, "ramp of speed")
        for text in ramp or ("35 rpm/s", "70 rpm/s", "140 rpm/s", "350 rpm/s")
    ]
    runs = []
    for number, rate in enumerate(rates, start=1):
        with working(f"run-up {number} of {len(rates)}"):
            runs += run_up(loaded, [rate], sensor, charge=charge)
    print_answer(run_up_lines(runs), draw_run_up(runs), picture)


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
    picture = picture_place(to, picture_name(loaded, "isolation", charge=charge))
    with working("a slow run-up through all speeds"):
        answer = passed_on(loaded, charge)
    print_answer(isolation_lines(answer), draw_isolation(answer), picture)


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
    picture = picture_place(to, picture_name(loaded, "balance", *(plane or ()), speed, charge=charge))
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
    print_answer(balance_lines(answer, loaded, grade), draw_balancing(answer, loaded), picture)
