"""A hundred pellets thrown about for a fifth of a second, and a page in which they move."""

import nutamill as nm

CASE = [
    "mechanism.mounting=rigid",
    "charge.mass=0.05 kg",
    "drive.ramp=10000 rpm/s",
    "run.until=0.2 s",
    'run.snapshots={rate="400 Hz", last="0.2 s"}',
]


def main(folder: str = "results") -> float:
    """Run, write the page, and return how far the ledger is from closing, as a share of the motor's work."""
    with nm.run(nm.load_case("numill", CASE), to=f"{folder}/moving.h5") as result:
        print(nm.write_view(result, result.path.with_suffix(".html")))
        series = result.series.isel(time=-1)
        open_share = float(abs(series["ledger_residual"]) / series["motor_work"])
    print(f"ledger open by {100 * open_share:.3f} %")
    return open_share


if __name__ == "__main__":
    main()
