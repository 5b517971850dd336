"""Commands about measured data."""

from pathlib import Path
from typing import Annotated

import typer

from nutamill.base.atomic_file import RESULTS, refuse_suffix
from nutamill.base.errors import CaseError, Fault
from nutamill.cli.common import Last, ResultFile, app, quantity, reports_errors, to


@app.command("import")
@reports_errors
def import_measured(
    file: Annotated[Path, typer.Argument(metavar="TEST", help="A test file: CSV, TDMS, MAT or UFF.")],
    mapping: Annotated[
        Path, typer.Option("--map", metavar="MAPPING.toml", help="What its columns are: a mapping file.")
    ],
    to: Annotated[Path | None, to("The file to write; else beside the test file.")] = None,
) -> None:
    """Read measured data, so that plot and compare can use them."""
    from nutamill.analysis.measured_import import import_test

    if to is not None:
        refuse_suffix(to, RESULTS)
    typer.echo(import_test(file, mapping, to or file.with_suffix(".h5")))


@app.command()
@reports_errors
def compare(
    run: ResultFile,
    measured: Annotated[
        Path, typer.Argument(metavar="MEASURED.h5", help="What `nutamill import` has written.")
    ],
    last: Last = "3 s",
    cut: Annotated[
        str | None,
        typer.Option("--filter", metavar="FREQUENCY", help='Low-pass filter for both, e.g. "200 Hz".'),
    ] = None,
    to: Annotated[Path | None, to("The overlay; else beside the run.")] = None,
) -> None:
    """Lay measured data over a run: steady values with errors, and a figure."""
    from nutamill.analysis.measured_comparison import compare, comparison_lines
    from nutamill.base.units import Kind
    from nutamill.result import open_result
    from nutamill.studies.papers.library import paper_names
    from nutamill.view.figures.measured import draw_comparison
    from nutamill.view.figures.saving import save_figure

    window, edge = (
        quantity("--last", last, Kind.TIME),
        None if cut is None else quantity("--filter", cut, Kind.FREQUENCY),
    )
    if str(measured) in paper_names():
        what = "must be a file that nutamill import has written, got the name of a paper"
        raise CaseError(Fault(str(measured), what, f"It is for: nutamill validate {measured}"))
    with open_result(run) as result, open_result(measured) as test:
        rows = compare(result, test, window, edge)
        typer.echo("\n".join(comparison_lines(rows)))
        figure = draw_comparison(result, test, [row.name for row in rows], window, edge)
        drawn = save_figure(figure, to or run.with_name(f"{run.stem}-{measured.stem}.png"))
    typer.echo(drawn)
