"""What all commands share: the application, options that many take, and how faults are printed."""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nutamill import __version__
from nutamill.base.errors import CaseError, ExitCode, Fault, MillError, printable
from nutamill.cli import completion
from nutamill.cli.help import App, PlainGroup
from nutamill.cli.paragraphs import echo_lines

if TYPE_CHECKING:
    from nutamill.case import Case, Machine

app = App(
    cls=PlainGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
CaseName = Annotated[
    str,
    typer.Argument(
        metavar="CASE",
        help="A case file, or a machine of the package such as numill.",
        autocompletion=completion.cases,
    ),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        "-s",
        metavar="KEY=VALUE",
        help='Change one key: -s drive.speed="500 rpm".',
        autocompletion=completion.keys,
    ),
]
ResultFile = Annotated[
    Path,
    typer.Argument(metavar="RESULT.h5", help="A result file.", autocompletion=completion.results),
]
Last = Annotated[str, typer.Option(metavar="TIME", help="Length of the steady window.")]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", "-j", min=1, metavar="N", help="Runs at once; else the physical cores."),
]
Cluster = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS", help="Run on a Dask cluster: local, a scheduler's address, or its file (.json)."
    ),
]
Quick = Annotated[
    bool,
    typer.Option("--quick", help="Demonstration: rigid mounts, short ramp, a few turns, softer contacts."),
]


def to(what: str, metavar: str = "FILE") -> Any:
    """Return the one option that says where output goes."""
    return typer.Option("--to", "-o", metavar=metavar, help=what)


def reports_errors(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that prints its faults, one line each, instead of raising them."""

    @functools.wraps(command)
    def reporting(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
        except MillError as error:
            echo_lines(map(printable, str(error).split("\n")), err=True)
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            raise typer.Exit(ExitCode.INTERRUPTED) from None

    return reporting


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"nutamill {__version__}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Simulate nutating mills: the machine and the charge inside it, coupled."""


def quantity(where: str, text: str, kind: Any) -> float:
    """Return the SI value of an option with a unit."""
    from nutamill.base import units

    try:
        return units.parse(text, kind)
    except units.UnitError as error:
        raise CaseError(Fault(where, error.what, error.hint)) from None


def load(name: str, overrides: list[str] | None) -> "Case | Machine":
    """Return the case of a name or file with the overrides of the command line."""
    from nutamill.case import load_case

    return load_case(name, overrides or [])
