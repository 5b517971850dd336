"""The empty mill on rigid mounts: how hard the crank pulls on the chamber, over speed.

The force grows with the square of the speed (published: 14.7 N at 100 rpm, 235 N at 400 rpm). This prints
14.5 N and 231.7 N.
"""

import nutamill as nm

FORCE = "crank_pin_force_resultant_tared"


def main(folder: str = "results") -> dict[float, float]:
    """Run two speeds, print and return the mean force [N] at each speed [rpm]."""
    forces = {}
    for rpm in (100.0, 400.0):
        case = nm.load_case(
            "numill",
            ["mechanism.mounting=rigid", "charge.kind=none", "drive.ramp=1000 rpm/s", "run.until=2 s"],
        )
        with nm.run(case.with_("drive.speed", f"{rpm:g} rpm"), to=f"{folder}/empty-{rpm:g}.h5") as result:
            forces[rpm] = nm.steady_mean(result, FORCE).mean
            print(f"{rpm:g} rpm: {forces[rpm]:.1f} N")
            nm.write_figures(result, ["run"], result.path.parent)
    return forces


if __name__ == "__main__":
    main()
