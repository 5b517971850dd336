"""Where the wall wears: work of the pellets on every patch of the bore, and the depth after Archard.

The wear coefficient is that of your wall and your charge; 1e-12 1/Pa is a place holder for acrylic.
Checked: the work on all patches is the loss at the wall in the ledger, but for what springs store meanwhile.
"""

import nutamill as nm

COEFFICIENT, FRICTION, YEAR = 1e-12, 0.2, 3600.0 * 8000.0  # 1/Pa; 1; s of running in a year

case = nm.load_case(
    "numill",
    [
        "mechanism.mounting=rigid",
        "charge.diameter=10 mm",
        "charge.count=30",
        "drive.ramp=40000 rpm/s",
        "run.until=0.12 s",
        "run.checkpoint=20 ms",
        "run.threads=1",
    ],
)
with nm.run(case, to="results/wear.h5") as result:
    done = nm.charge_window(result, "0.1 s")
    nm.write_figures(result, ["wall"], result.path.parent)
    series = result.series
    inside = series.sel(time=[done.attrs["start"], done.attrs["end"]], method="nearest")
table = nm.wear_table(done)
depth = 1e3 * COEFFICIENT / FRICTION * YEAR * table["shear_intensity"]
for name in dict.fromkeys(table["patch_surface"].values.tolist()):
    of = table["patch_surface"] == name
    mean, most = float(depth.where(of).mean()), float(depth.where(of).max())
    print(f"{name:8} mean {mean:7.3g} mm a year, most {most:7.3g}")
taken = float(sum(done[f"wall_{kind}_work"].sum() for kind in ("normal", "shear", "rolling")))
losses = [name for name in series.data_vars if name.startswith("wall_") and name.endswith("_loss")]
lost = sum(float(inside[name][1] - inside[name][0]) for name in losses)
stored = float(inside["elastic_energy"].max())
print(f"work on the wall {taken:.4f} J, loss in the ledger {lost:.4f} J, stored in springs {stored:.4f} J")
assert abs(taken - lost) < stored
