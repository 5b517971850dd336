"""Commands that show a result: figures, scenes, films, pages, files for other programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from nutamill.base.atomic_file import megabytes
from nutamill.base.files import is_folder
from nutamill.cli.common import ResultFile, app, reports_errors

if TYPE_CHECKING:
    from nutamill.view.cameras import View
    from nutamill.view.scene import Colour

Camera = Annotated[str, typer.Option(help="front, inside (riding on the chamber) or axis (down the shaft).")]
ColourBy = Annotated[
    str, typer.Option("--colour", help="What colours the charge: speed, height, force or material.")
]


@app.command()
@reports_errors
def plot(
    file: ResultFile,
    what: Annotated[
        list[str],
        typer.Argument(
            help="run, power, impacts, wall, flow, orbit; history:SERIES,..., spectrum:SERIES, orders:SERIES."
        ),
    ],
    to: Annotated[Path | None, typer.Option(help="Folder of the pictures; else that of the result.")] = None,
) -> None:
    """Draw figures of a result."""
    from nutamill.result import open_result
    from nutamill.view.figures.named import write_figures

    with open_result(file) as result:
        typer.echo("\n".join(map(str, write_figures(result, what, to or file.parent))))


@app.command()
@reports_errors
def picture(
    file: ResultFile,
    png: Annotated[Path, typer.Argument(help="The picture.")],
    camera: Camera = "front",
    colour: ColourBy = "speed",
) -> None:
    """Draw the last snapshot in three dimensions. Needs the extra "view"."""
    from nutamill.result import open_result
    from nutamill.view.scene import draw_scene

    with open_result(file) as result:
        typer.echo(draw_scene(result, png, cast("View", camera), cast("Colour", colour)))


@app.command()
@reports_errors
def movie(
    file: ResultFile,
    mp4: Annotated[Path, typer.Argument(help="The film.")],
    camera: Camera = "front",
    colour: ColourBy = "speed",
    slow: Annotated[float, typer.Option(min=1.0, help="How many times slower than real.")] = 40.0,
) -> None:
    """Film all snapshots in three dimensions. Needs the extra "view"."""
    from nutamill.result import open_result
    from nutamill.view.scene import film_scene

    with open_result(file) as result:
        view, coloured_by = cast("View", camera), cast("Colour", colour)
        film = film_scene(result, mp4, view, coloured_by, slow, log=lambda text: typer.echo(text, err=True))
        typer.echo(film)


@app.command()
@reports_errors
def view(
    file: ResultFile,
    html: Annotated[Path | None, typer.Option(help="The page to write; else beside the result.")] = None,
    frames: Annotated[int, typer.Option(min=1, help="Most moments to show.")] = 200,
) -> None:
    """Write one HTML file in which the mill turns and the charge moves. It opens in any browser, without a
    network.
    """
    from nutamill.result import open_result
    from nutamill.view.webview import write_view

    with open_result(file) as result:
        page = write_view(result, html or file.with_suffix(".html"), frames)
    typer.echo(f"{page}   {megabytes(page.stat().st_size)}, open it in a browser")


@app.command()
@reports_errors
def export(
    file: ResultFile,
    vtkhdf: Annotated[Path, typer.Option(help="File for ParaView: charge and machine over time.")],
) -> None:
    """Write the snapshots of a result for another program."""
    from nutamill.result import open_result
    from nutamill.view.vtkhdf import write_vtkhdf

    with open_result(file) as result:
        typer.echo(write_vtkhdf(result, vtkhdf))


@app.command()
@reports_errors
def report(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULT.h5 ...|FOLDER", help="Results, or the folder of a sweep or of a comparison."
        ),
    ],
    to: Annotated[
        Path | None, typer.Option(help="The page; else beside the first result, or in the folder.")
    ] = None,
) -> None:
    """Write one HTML page: case, steady values, power, figures, the moving charge and provenance, or the
    tables of a campaign.
    """
    from nutamill.view.report import write_report

    beside = (
        files[0] / "report.html"
        if is_folder(files[0])
        else files[0].with_name(f"{files[0].stem}-report.html")
    )
    page = write_report(files, to or beside)
    typer.echo(f"{page}   {megabytes(page.stat().st_size)}")
