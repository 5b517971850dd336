"""The command that serves the local page."""

from pathlib import Path
from typing import Annotated

import typer

from nutamill.cli.common import app, reports_errors


@app.command()
@reports_errors
def ui(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder of cases and results; else this one.")
    ] = Path(),
    port: Annotated[
        int, typer.Option(metavar="N", min=0, max=65535, help="Port on this machine; else a free one.")
    ] = 0,
    show: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
) -> None:
    """Serve a page in which a case is changed, checked, run and compared, without writing files.

    Only this machine reaches it, at the address that is printed. It ends with Ctrl+C, and so do its runs,
    saved.
    """
    import webbrowser

    from nutamill.ui.server import Server

    with Server(folder, port) as server:
        typer.echo(f"{server.address}\nOpen this address in a browser on this machine. Ctrl+C ends the page.")
        if show:
            webbrowser.open(server.address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            typer.echo("ending, runs are saved", err=True)
