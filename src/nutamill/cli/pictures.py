"""Commands that show a result: figures, scenes, films, pages, files for other programs."""

import re
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from nutamill.base.atomic_file import megabytes
from nutamill.base.errors import CaseError, Fault
from nutamill.base.files import is_folder
from nutamill.cli import completion
from nutamill.cli.common import Overrides, ResultFile, app, load, quantity, reports_errors, to

if TYPE_CHECKING:
    from nutamill.view.cameras import View
    from nutamill.view.looks import Colour, Look


class Form(StrEnum):
    """Formats in which a result can be written for other programs."""

    VTKHDF = "vtkhdf"
    CSV = "csv"
    PARQUET = "parquet"
    FMU = "fmu"
    LAMMPS = "lammps"


class Exported(StrEnum):
    """What of a machine is exported."""

    MECHANISM = "mechanism"
    WHOLE = "whole"


class Drives(StrEnum):
    """What moves the drives of an exported machine."""

    PROGRAMME = "programme"
    SPEED = "speed"
    TORQUE = "torque"


class Platforms(StrEnum):
    """Platforms that an exported machine has libraries for."""

    THIS = "this"
    ALL = "all"


Camera = Annotated[
    str, typer.Option(metavar="NAME", help="front, inside (riding on the chamber) or axis (down the shaft).")
]
ColourBy = Annotated[
    str,
    typer.Option(
        "--colour",
        "--color",
        metavar="NAME",
        help="What colours the charge: speed, height, force, material or size.",
    ),
]
Size = Annotated[str, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the picture in pixels.")]
ColourRange = Annotated[
    str | None,
    typer.Option(
        "--range", metavar="LOW..HIGH UNIT", help='Ends of the colour bar: "0..3 m/s"; else of what is shown.'
    ),
]
CutAt = Annotated[
    str | None,
    typer.Option(
        "--cut",
        metavar="PLANE",
        help='Take away what is before a plane: x, y or z through the axis of the mill, or "y=20 mm".',
    ),
]
Background = Annotated[
    str, typer.Option(metavar="COLOUR", help="white, black, #202830; of a picture also transparent.")
]
Azimuth = Annotated[
    str | None, typer.Option(metavar="ANGLE", help='Turn the camera about the mill, "-60 deg" from x.')
]
Elevation = Annotated[
    str | None, typer.Option(metavar="ANGLE", help='Raise the camera, "30 deg" above the horizon.')
]


@app.command()
@reports_errors
def plot(
    file: ResultFile,
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="FIGURE...",
            help="run, power, impacts, wall, flow, orbit, history:SERIES,..., spectrum:SERIES, "
            "orders:SERIES.",
            autocompletion=completion.figures,
        ),
    ],
    to: Annotated[Path | None, to("Folder of the pictures; else that of the result.", "FOLDER")] = None,
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
    to: Annotated[Path | None, to("The picture (PNG); else beside the result.")] = None,
    camera: Camera = "front",
    colour: ColourBy = "speed",
    time: Annotated[
        list[str] | None,
        typer.Option(
            metavar="TIME",
            help="The snapshot nearest to this time; else the last. Several times are drawn side by side.",
        ),
    ] = None,
    size: Size = "1280x960",
    colour_range: ColourRange = None,
    cut: CutAt = None,
    background: Background = "white",
    azimuth: Azimuth = None,
    elevation: Elevation = None,
) -> None:
    """Draw a snapshot in three dimensions, or several side by side. Needs the extra "view"."""
    from nutamill.result import open_result
    from nutamill.view.scene import draw_scene

    times = [quantity("--time", one, "time") for one in time or ()]
    look = _look(camera, colour, colour_range, cut, background, azimuth, elevation)
    pixels = _pixels(size)
    with open_result(file) as result:
        typer.echo(draw_scene(result, to or file.with_name(f"{file.stem}-{camera}.png"), look, times, pixels))


def _look(
    camera: str,
    colour: str,
    colour_range: str | None,
    cut: str | None,
    background: str,
    azimuth: str | None,
    elevation: str | None,
) -> "Look":
    """Return how a picture or a film looks, of the options of both."""
    from nutamill.view.looks import Look, cut_of, range_of

    return Look(
        cast("View", camera),
        cast("Colour", colour),
        None if colour_range is None else range_of(colour_range, colour),
        None if cut is None else cut_of(cut),
        background,
        None if azimuth is None else quantity("--azimuth", azimuth, "angle"),
        None if elevation is None else quantity("--elevation", elevation, "angle"),
    )


def _pixels(size: str) -> tuple[int, int]:
    """Return width and height of a picture [px] from ``1280x960``."""
    match = re.fullmatch(r"(\d{2,4})x(\d{2,4})", size)
    if match is None:
        from nutamill.base.schema import spelled

        what = f"must be width and height in pixels, from 10 to 9999, got {spelled(size)}"
        raise CaseError(Fault("--size", what, "Write e.g. --size 1920x1080"))
    return int(match[1]), int(match[2])


@app.command()
@reports_errors
def movie(
    file: ResultFile,
    to: Annotated[Path | None, to("The film (MP4); else beside the result.")] = None,
    camera: Camera = "front",
    colour: ColourBy = "speed",
    slow: Annotated[
        float, typer.Option(min=1.0, metavar="N", help="How many times slower than real.")
    ] = 40.0,
    size: Size = "1280x960",
    colour_range: ColourRange = None,
    cut: CutAt = None,
    background: Background = "white",
    azimuth: Azimuth = None,
    elevation: Elevation = None,
    trace: Annotated[
        bool, typer.Option("--trace", help="Draw the force over time below, with a mark at the moment shown.")
    ] = False,
) -> None:
    """Film the time that has snapshots in three dimensions. Needs the extra "view"."""
    from nutamill.result import open_result
    from nutamill.view.film import film_scene

    look = _look(camera, colour, colour_range, cut, background, azimuth, elevation)
    pixels = _pixels(size)
    with open_result(file) as result:
        path = to or file.with_name(f"{file.stem}-{camera}.mp4")
        log = lambda text: typer.echo(text, err=True)  # noqa: E731
        typer.echo(film_scene(result, path, look, slow, log, pixels, trace))


@app.command()
@reports_errors
def view(
    file: ResultFile,
    to: Annotated[Path | None, to("The page to write; else beside the result.")] = None,
    frames: Annotated[int, typer.Option(min=1, metavar="N", help="Most moments to show.")] = 200,
) -> None:
    """Write one HTML file in which the mill turns and the charge moves. It opens in any browser, without a
    network.
    """
    from nutamill.result import open_result
    from nutamill.view.webview import write_view

    with open_result(file) as result:
        page = write_view(result, to or file.with_suffix(".html"), frames)
    typer.echo(f"{page}   {megabytes(page.stat().st_size)}, open it in a browser")


@app.command()
@reports_errors
def export(
    form: Annotated[
        Form,
        typer.Argument(
            metavar="FORMAT",
            help="vtkhdf: charge and machine over time, for ParaView. csv, parquet: all series. "
            "fmu: the mechanism of a case, for other simulation programs. "
            "lammps: the charge in the recorded motion of its chamber, as a script for LAMMPS.",
        ),
    ],
    file: Annotated[
        Path, typer.Argument(metavar="RESULT.h5|CASE", help="A result file; for fmu a case, such as numill.")
    ],
    to: Annotated[Path | None, to("The file, for lammps the folder; else beside the result.")] = None,
    series: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SERIES", help="A series to write, repeatable; all if left out. For csv and parquet."
        ),
    ] = None,
    overrides: Overrides = None,
    fmi: Annotated[int, typer.Option(metavar="2|3", min=2, max=3, help="fmu: version of FMI.")] = 2,
    what: Annotated[
        Exported,
        typer.Option(metavar="mechanism|whole", help="fmu: the machine without or with its charge."),
    ] = Exported.MECHANISM,
    drives: Annotated[
        Drives, typer.Option(metavar="programme|speed|torque", help="fmu: what moves the drives.")
    ] = Drives.PROGRAMME,
    platforms: Annotated[
        Platforms, typer.Option(metavar="this|all", help="fmu: platforms that libraries are made for.")
    ] = Platforms.THIS,
) -> None:
    """Write a result for ParaView, a spreadsheet, pandas or LAMMPS, or the machine of a case as an FMU."""
    if form is not Form.FMU and overrides:
        refused = f"has no use for {form}, which writes a run as it was"
        raise CaseError(Fault("--set", refused, "Leave it out, or run the case with it first"))
    if form is Form.FMU:
        from nutamill.export.fmu.write import export_machine

        if series:
            refused = "has no use for fmu, whose outputs are all series"
            raise CaseError(Fault("--series", refused, "Leave it out, or export csv or parquet"))
        machine = load(str(file), overrides).machine
        path = to or Path(f"{machine.name}.fmu")
        log = lambda text: typer.echo(text, err=True)  # noqa: E731
        written = export_machine(machine, path, what, fmi, drives, platforms, log)
        typer.echo(f"{written}   {megabytes(written.stat().st_size)}")
        return
    from nutamill.result import open_result
    from nutamill.view.series_table import write_csv, write_parquet
    from nutamill.view.vtkhdf import write_vtkhdf

    if form in (Form.VTKHDF, Form.LAMMPS) and series:
        refused = f"has no use for {form}, which holds snapshots"
        raise CaseError(Fault("--series", refused, "Leave it out, or export csv or parquet"))
    if form is Form.LAMMPS:
        from nutamill.export.lammps.write import export_charge

        with open_result(file) as result:
            for written in export_charge(result, to or file.with_name(f"{file.stem}-lammps")):
                typer.echo(f"{written}   {megabytes(written.stat().st_size)}")
        return
    path = to or file.with_suffix(f".{form}")
    with open_result(file) as result:
        if form is Form.VTKHDF:
            written = write_vtkhdf(result, path)
        else:
            write = write_csv if form is Form.CSV else write_parquet
            written = write(result, path, series or ())
    typer.echo(f"{written}   {megabytes(written.stat().st_size)}")


@app.command()
@reports_errors
def report(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULT.h5 ...|FOLDER", help="Results, or the folder of a sweep or of a comparison."
        ),
    ],
    to: Annotated[Path | None, to("The page; else beside the first result, or in the folder.")] = None,
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
