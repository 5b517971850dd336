"""Torque, force and lag of the NuMill at 700 rpm with a film of liquid on pellets and walls: a prediction.

    python -m validation.wet_pellets FOLDER          run what FOLDER lacks, one after the other on one thread
    python -m validation.wet_pellets FOLDER table    table and picture of the runs that FOLDER holds

There is no measurement of a wet NuMill to compare with.  The runs are short: rigid mounts, a ramp of half a
second, two seconds in all, and contacts between pellets nine times softer than the published ones.
"""

import sys
import time
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt

import nutamill as nm
from nutamill import __version__
from nutamill.analysis.power import power_split
from nutamill.analysis.values import read, reading_of
from nutamill.base.steady import Estimate
from nutamill.result import is_finished

ROOT = Path(__file__).parents[1]
TABLE, PICTURE = ROOT / "validation/results/wet-pellets.txt", ROOT / "docs/pictures/wet_pellets.png"
SHORT = {
    "mechanism.mounting": "rigid",
    "drive.ramp": "1400 rpm/s",
    "run.until": "2 s",
    "run.threads": 1,
    "contact.stiffness": "direct",
    "contact.pairs.steel-steel.normal_stiffness": "55.6 kN/m",
    "contact.pairs.steel-acrylic.normal_stiffness": "15.75 kN/m",
}
"""What all runs share."""
READINGS = {
    "driveshaft_torque": "torque (N m)",
    "crank_pin_force_resultant": "pin force (N)",
    "charge_phase_lag": "lag (rad)",
}
"""Series whose steady means are read, and their heads."""

SINKS = ("pellet-wall", "pellet-pellet", "liquid")
"""Where the power that is put in goes, as columns of the table."""


class Film(NamedTuple):
    """The film of all contacts of a run."""

    viscosity: float
    """[mPa s]; 0 where the charge is dry."""
    thickness: float = 0.0
    """[um]"""
    roughness: float = 0.0
    """[um]"""

    @property
    def name(self) -> str:
        """Name of the result file."""
        if self.viscosity == 0.0:
            return "dry"
        return f"{self.viscosity:g}-mPas-{self.thickness:g}-to-{self.roughness:g}-um"

    @property
    def words(self) -> str:
        """The film in the table."""
        if self.viscosity == 0.0:
            return "dry"
        return f"{self.viscosity:g} mPa s, {self.thickness:g} to {self.roughness:g} um"

    @property
    def changes(self) -> dict[str, str | int]:
        """What the case of this film differs in from the published one."""
        if self.viscosity == 0.0:
            return SHORT
        changes = SHORT | {"contact.film": "viscous"}
        for pair in ("steel-steel", "steel-acrylic"):
            changes |= {
                f"contact.pairs.{pair}.liquid_viscosity": f"{self.viscosity:g} mPa s",
                f"contact.pairs.{pair}.film_thickness": f"{self.thickness:g} um",
                f"contact.pairs.{pair}.film_roughness": f"{self.roughness:g} um",
            }
        return changes


FILMS = (
    Film(0.0),
    Film(20.0, 100.0, 1.0),
    Film(50.0, 100.0, 1.0),
    Film(200.0, 100.0, 10.0),
    Film(20.0, 20.0, 1.0),
    Film(50.0, 20.0, 1.0),
    Film(200.0, 50.0, 10.0),
    Film(500.0, 100.0, 10.0),
)
"""Films of the runs. A rougher surface lets thicker liquids be resolved in the same substep."""


def run_all(folder: Path) -> None:
    """Run the films that `folder` lacks."""
    for film in FILMS:
        begun = time.process_time()
        nm.run(nm.load_case("numill").with_(film.changes), folder / f"{film.name}.h5")
        print(f"{film.words}: {time.process_time() - begun:.0f} s of processor time", flush=True)


def table(folder: Path) -> list[str]:
    """Return the table of the runs that `folder` holds, and draw its picture."""
    rows: list[tuple[Film, list[Estimate], dict[str, float]]] = []
    for film in FILMS:
        file = folder / f"{film.name}.h5"
        if file.exists():
            with nm.open_result(file) as result:
                if is_finished(result.state):
                    means = read(result, [reading_of(name) for name in READINGS])
                    rows.append((film, list(means.values()), power_split(result).sinks))
    heads = "".join(f"{head:>16} {'±':>7}" for head in READINGS.values())
    date = time.strftime("%Y-%m-%d", time.gmtime())
    text = [
        f"nutamill {__version__}, wet pellets in the NuMill at 700 rpm, {date}",
        "A prediction: nobody has measured a wet NuMill. Short runs: rigid mounts, 2 s, ramp of 0.5 s,",
        "contacts between pellets nine times softer. ± is the 95 % interval of the mean over the turns;",
        "the last columns are powers in W.",
        "",
        f"{'film of all contacts':24}{heads} " + " ".join(f"{sink:>13}" for sink in SINKS),
    ]
    for film, means, sinks in rows:
        numbers = "".join(f"{mean.mean:16.4g} {mean.half_width:7.2g}" for mean in means)
        powers = " ".join(f"{sinks.get(sink, 0.0):13.4g}" for sink in SINKS)
        text.append(f"{film.words:24}{numbers} {powers}")
    draw([row[0] for row in rows], [row[1] for row in rows])
    return text


def draw(films: list[Film], means: list[list[Estimate]]) -> None:
    """Draw the steady means with their intervals, run by run."""
    figure, panels = plt.subplots(1, len(READINGS), figsize=(10.0, 3.6), sharey=True, layout="constrained")
    places = range(len(films))
    for k, (panel, head) in enumerate(zip(panels, READINGS.values(), strict=True)):
        panel.errorbar(
            [mean[k].mean for mean in means], places, xerr=[mean[k].half_width for mean in means],
            fmt="o", capsize=3,
        )  # fmt: skip
        panel.axvline(means[0][k].mean, color="0.7", zorder=0)
        panel.set(xlabel=head)
    panels[0].set_yticks(list(places), [film.words for film in films])
    panels[0].invert_yaxis()
    figure.suptitle("Prediction without measurement: NuMill, 700 rpm, wet pellets (95 % intervals)")
    figure.savefig(PICTURE, dpi=110)


def main(arguments: list[str]) -> int:
    """Run, or print and write the table."""
    if len(arguments) == 1:
        run_all(Path(arguments[0]))
        return 0
    if len(arguments) != 2 or arguments[1] != "table":
        print(__doc__)
        return 2
    text = "\n".join(table(Path(arguments[0])))
    print(text)
    TABLE.write_text(text + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
