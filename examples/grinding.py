"""What a tumbling mill does to an ore and to its liner at three speeds: which grinds better for the same
energy.

Checked: the product has the size that the ore asks for, impacts that come twice as often need half the
energy, and the liner loses no more than all power would wear off if it went into friction.
"""

import tempfile
from pathlib import Path

import nutamill as nm

ORE, HARDNESS, COEFFICIENT = nm.load_ore("smc-sample-a"), 6e9, 1e-4
answers, liner = [], nm.liner_of(HARDNESS, COEFFICIENT)
with tempfile.TemporaryDirectory() as folder:
    for speed in (35, 47, 60):
        case = nm.load_case(
            "tumbling-mill", [f"drives.motor.speed={speed} rpm", "run.until=4.5 s", "run.checkpoint=0.35 s"]
        )
        with nm.run(case, to=Path(folder) / f"{speed}-rpm.h5") as result:
            grinding = nm.grinding_of(result)
            answers.append(nm.breakage(grinding, ORE, answers[0].energies[-1] if answers else None))
            worn = nm.wall_wear(result, liner)
print("\n".join(nm.breakage_lines(answers[0]) + nm.comparison_lines(answers)))
print("\n".join(nm.wear_lines(nm.by_surface(worn), 0.01)))
nm.draw_breakage(answers).savefig("grinding.png")
nm.draw_wear(worn, nm.by_surface(worn)).savefig("wear.png")

assert abs(answers[0].p80[-1] / ORE.product - 1.0) < 1e-3
often = grinding._replace(whole=grinding.whole._replace(rate=2.0 * grinding.whole.rate))
assert abs(nm.breakage(often, ORE).energy / answers[-1].energy - 0.5) < 1e-3
volume = float((worn.sliding * worn.area).sum())
assert 0.0 < volume < COEFFICIENT * grinding.power / HARDNESS / 0.3
