"""Commands about many runs: sweeps, fits, validation against published papers."""

from pathlib import Path
from typing import Annotated

import typer

from nutamill.base.errors import ExitCode
from nutamill.cli import completion
from nutamill.cli.common import Cluster, Jobs, Quick, app, load, reports_errors, to


@app.command()
@reports_errors
def sweep(
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE|SWEEP.toml", help="A case, or a sweep file.", autocompletion=completion.cases
        ),
    ],
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            "-s",
            metavar="KEY=VALUES",
            autocompletion=completion.keys,
            help='Swept, or one value: -s drive.speed="100..700 rpm step 60 rpm" -s chamber.ribs=0,12.',
        ),
    ] = None,
    jobs: Jobs = None,
    cluster: Cluster = None,
    to: Annotated[Path | None, to("Folder for results and table; else sweeps/<case>.", "FOLDER")] = None,
    quick: Quick = False,
) -> None:
    """Run a case with all combinations of some values. The same call again does what is left."""
    from nutamill.studies.command import run_sweep

    if not run_sweep(case, changes or [], jobs, cluster, to, quick, typer.echo):
        raise typer.Exit(ExitCode.FAILED)


@app.command()
@reports_errors
def submit(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="A case file with a charge in LAMMPS.")],
    nodes: Annotated[int, typer.Option(min=1, metavar="N", help="Nodes of the cluster.")] = 1,
    ranks: Annotated[int, typer.Option(min=1, metavar="N", help="Processes on all nodes together.")] = 1,
    hours: Annotated[float, typer.Option(min=0.0, metavar="HOURS", help="Longest time of the job.")] = 24.0,
    to: Annotated[Path | None, to("The script; else beside the case.")] = None,
) -> None:
    """Write the SLURM job script of one run on many processes, and submit it where there is a queue."""
    from nutamill.export.job_script import submitted, write_job

    loaded = load(str(case), None)
    place = to or case.with_suffix(".sh")
    script = write_job(loaded, case, place, loaded.file_in(), nodes, ranks, hours)
    answer = submitted(script) or f"written; there is no sbatch here. On the cluster: sbatch {script}"
    typer.echo(f"{script}   {answer}")


@app.command()
@reports_errors
def fit(
    file: Annotated[
        Path, typer.Argument(metavar="FIT.toml", help="The fit file: case, free keys, measured values.")
    ],
    jobs: Jobs = None,
    cluster: Cluster = None,
    to: Annotated[Path | None, to("Folder for results; else fits/<file>.", "FOLDER")] = None,
) -> None:
    """Identify keys of a case from measured values, with their uncertainty and correlation."""
    from nutamill.studies.command import run_fit

    typer.echo("\n".join(run_fit(file, jobs, cluster, to)))


@app.command()
@reports_errors
def identify(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="IDENTIFY.toml", help="The identification file: case, unknowns, rows, stages."
        ),
    ],
    until: Annotated[
        str | None, typer.Option(metavar="STAGE", help="Take the stages to this one only.")
    ] = None,
    jobs: Jobs = None,
    cluster: Cluster = None,
    to: Annotated[Path | None, to("Folder for results; else identified/<file>.", "FOLDER")] = None,
    steps: Annotated[
        int | None,
        typer.Option(metavar="N", min=100, help="Steps of the posterior's chain at most; else 20000."),
    ] = None,
    learn: Annotated[
        list[str] | None,
        typer.Option(metavar="TITLE", help="Learn from a row to predict. May be given several times."),
    ] = None,
) -> None:
    """Identify unknown numbers with their posterior, and predict other rows with intervals."""
    from nutamill.studies.command import run_identification

    typer.echo("\n".join(run_identification(file, until, jobs, cluster, to, steps, learn or [])))


@app.command("mount-test")
@reports_errors
def mount_test(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="TEST.csv",
            help="Columns time [s], displacement [mm], force [N], in any order and units.",
        ),
    ],
    to: Annotated[Path | None, to("The picture; else beside the file.")] = None,
) -> None:
    """Print stiffness and damping of a mount from a force-displacement test at one frequency."""
    from nutamill.analysis.mount_test import mount_properties, read_mount_test
    from nutamill.view.figures.mount import draw_loop
    from nutamill.view.figures.saving import save_figure

    test = read_mount_test(file)
    properties = mount_properties(test)
    picture = save_figure(draw_loop(test, properties), to or file.with_suffix(".png"))
    typer.echo("\n".join([*properties.lines(), f"picture {picture}"]))


@app.command()
@reports_errors
def validate(
    paper: Annotated[
        str, typer.Argument(metavar="PAPER", help="saimm2025, mca2026, ... or a file of the same form.")
    ],
    quick: Annotated[bool, typer.Option("--quick", help="Start the few decisive runs only.")] = False,
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="NAME", help="A row, a configuration or a run; repeatable."),
    ] = None,
    to: Annotated[
        Path | None, to("Folder of the results; else results/validation/<paper>.", "FOLDER")
    ] = None,
    jobs: Jobs = None,
    cluster: Cluster = None,
    stored: Annotated[bool, typer.Option("--stored", help="Start no run: evaluate what is there.")] = False,
    short: Annotated[
        Path | None,
        typer.Option(
            "--markdown",
            metavar="FILE",
            help="Write headline rows, or all rows, between the marks of this file.",
        ),
    ] = None,
    identified: Annotated[
        Path | None,
        typer.Option(
            "--identified",
            metavar="FILE",
            help="identify.json of an identification: its 90 % intervals are a column of --markdown.",
        ),
    ] = None,
) -> None:
    """Compare a published paper with runs of all its configurations, row by row."""
    from nutamill.studies import validate as room
    from nutamill.studies.papers.table import print_table, read_identified
    from nutamill.studies.workers import cluster_client

    intervals = None if identified is None else read_identified(identified, Path(paper).stem)
    client = None if cluster is None or stored else cluster_client(cluster, jobs)
    done = room.validate(paper, quick, only or [], to, not stored, jobs, client, typer.echo)
    print_table(done.findings, done.paper)
    for line in (*done.failures, *done.undrawn):
        typer.echo(line, err=True)
    if short is not None:
        room.write_tables(short, done, paper, intervals)
    typer.echo(f"{', '.join(str(file) for file in done.files)}")
