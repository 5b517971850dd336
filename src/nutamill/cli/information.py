"""Commands about the installation, its speed, the keys and schemas of files, and how to cite."""

import json
from typing import Annotated

import typer

from nutamill.base.errors import ExitCode
from nutamill.cli import completion
from nutamill.cli.common import app, reports_errors
from nutamill.cli.paragraphs import echo_lines


@app.command()
@reports_errors
def doctor() -> None:
    """Check the installation: versions, memory, optional parts, compiled kernels, a self-test of some
    seconds.
    """
    from nutamill.design.doctor import doctor as examined

    faults = 0
    for check in examined():
        echo_lines([check.line])
        faults += check.state == "FAULT"
    if faults:
        raise typer.Exit(ExitCode.FAILED)


@app.command()
@reports_errors
def explain(
    key: Annotated[
        str, typer.Argument(metavar="KEY", help="chamber.ribs, or a table.", autocompletion=completion.names)
    ],
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE", help="Where its value is taken from.", autocompletion=completion.cases
        ),
    ] = "numill",
) -> None:
    """Print what a key of a case means: quantity, units, choices, value, and where the value comes from."""
    from nutamill.case.toml.explain import explained

    echo_lines(explained(key, case))


@app.command()
@reports_errors
def cite(
    bibtex: Annotated[bool, typer.Option("--bibtex", help="As entries of BibTeX.")] = False,
) -> None:
    """Print how to cite nutamill, and the papers whose machine and measurements it ships."""
    from nutamill.base.citation import citation_lines

    echo_lines(citation_lines(bibtex))


@app.command()
@reports_errors
def schema(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="mill, mechanism, sweep, fit, identify, ratings, ore or mapping."
        ),
    ] = "mill",
) -> None:
    """Print the JSON schema of a kind of file, for completion in editors."""
    from nutamill.studies.new_file import schema_of

    typer.echo(json.dumps(schema_of(kind), indent=2))


@app.command()
@reports_errors
def bench() -> None:
    """Measure the speed of this version on this machine. It takes about two minutes."""
    from nutamill.simulation.speed import measure

    for line in measure():
        typer.echo(line)
