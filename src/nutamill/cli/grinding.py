"""Answers about what the charge of a run grinds and wears: each prints a table and saves a figure."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nutamill.base.errors import CaseError, Fault
from nutamill.cli import completion
from nutamill.cli.answer_picture import Picture, picture_name, picture_place, print_answer
from nutamill.cli.common import Last, ResultFile, app, quantity, reports_errors

if TYPE_CHECKING:
    from nutamill.analysis.breakage.answer import Breakage

ResultFiles = Annotated[
    list[Path],
    typer.Argument(metavar="RESULT.h5...", help="Result files.", autocompletion=completion.results),
]


def _positive(where: str, text: str, kind: str) -> float:
    """Return the SI value of an option that must be positive."""
    value = quantity(where, text, kind)
    if not value > 0.0:
        raise CaseError(Fault(where, f'must be positive, got "{text}"'))
    return value


@app.command()
@reports_errors
def breakage(
    files: ResultFiles,
    ore: Annotated[
        str,
        typer.Option(
            metavar="ORE",
            help="An ore file, or an ore of the package such as smc-sample-a.",
            autocompletion=completion.ores,
        ),
    ],
    energy: Annotated[
        str | None,
        typer.Option(
            metavar="ENERGY",
            help='Compare after this specific energy, e.g. "10 kWh/t"; else what the first run needs.',
        ),
    ] = None,
    last: Last = "3 s",
    to: Picture = None,
) -> None:
    """Print how the impacts of runs would grind an ore: rates, fineness over energy, which run needs less."""
    from nutamill.analysis.breakage.answer import breakage as answer_for
    from nutamill.analysis.breakage.answer import breakage_lines, comparison_lines
    from nutamill.analysis.breakage.impacts import grinding_of
    from nutamill.analysis.breakage.ore import load_ore
    from nutamill.result import open_result
    from nutamill.view.figures.breakage import draw_breakage

    rock = load_ore(ore)
    up_to = None if energy is None else _positive("--energy", energy, "specific energy")
    stem = picture_name(files[0], "breakage", Path(ore).stem, energy, last)
    picture = picture_place(to, stem, files[0].parent)
    answers: list[Breakage] = []
    for file in files:
        with open_result(file) as result:
            grinding = grinding_of(result, last)
        answers.append(answer_for(grinding, rock, answers[0].energies[-1] if answers else up_to))
    lines = [line for one in answers for line in breakage_lines(one)]
    if len(answers) > 1:
        lines += comparison_lines(answers)
    print_answer(lines, draw_breakage(answers), picture)


@app.command()
@reports_errors
def wear(
    file: ResultFile,
    hardness: Annotated[str, typer.Option(metavar="PRESSURE", help='Hardness of the walls, e.g. "6 GPa".')],
    coefficient: Annotated[
        float, typer.Option(metavar="K", help="Wear coefficient of sliding after Archard.")
    ] = 0.0,
    cutting: Annotated[
        float,
        typer.Option(metavar="SHARE", help="Share of the impacts that cut as sharp grains do, after Finnie."),
    ] = 0.0,
    thickness: Annotated[
        str | None, typer.Option(metavar="LENGTH", help='Print the life of a liner, e.g. "10 mm" thick.')
    ] = None,
    after: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help='Write the walls worn by this time as meshes, e.g. "500 h", for a next run.'
        ),
    ] = None,
    last: Last = "3 s",
    to: Picture = None,
) -> None:
    """Print how deep the charge wears its walls in mm per 1000 h, and draw it on the unrolled liner."""
    from nutamill.analysis.source import any_case_of
    from nutamill.analysis.wear import by_surface, liner_of, wall_wear, wear_lines
    from nutamill.result import open_result
    from nutamill.view.figures.wear import draw_wear

    liner = liner_of(quantity("--hardness", hardness, "pressure"), coefficient, cutting)
    thick = None if thickness is None else _positive("--thickness", thickness, "length")
    time = None if after is None else _positive("--after", after, "time")
    picture = picture_place(to, picture_name(file, "wear", last), file.parent)
    with open_result(file) as result:
        worn = wall_wear(result, liner, last)
        case = any_case_of(result)
    surfaces = by_surface(worn)
    print_answer(wear_lines(surfaces, thick), draw_wear(worn, surfaces), picture)
    if time is not None:
        from nutamill.export.worn import write_worn

        for path in write_worn(case, worn, time, file.parent):
            typer.echo(f"mesh {path}")
