"""The command that verifies a result file."""

import typer

from nutamill.base.errors import ResultError
from nutamill.cli.common import ResultFile, app, reports_errors


@app.command()
@reports_errors
def verify(file: ResultFile) -> None:
    """Compare everything in a result with its checksums: what is damaged, which checkpoint is whole."""
    from nutamill.result import verify as verified

    contents = verified(file)
    typer.echo("\n".join(contents.lines()))
    if contents.faults:
        raise ResultError(f"{file}: is damaged. Copy it again, or run the case again.")
