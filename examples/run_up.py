"""How far the frame of the NuMill shakes on its way through the resonance, for four ramps.

Checked: a quicker ramp passes the resonance later and with a lower peak (Lewis, Trans. ASME 54, 253-261,
1932).
"""

import itertools
import math

import nutamill as nm

RPM = math.pi / 30.0

case = nm.load_case("numill")
runs = nm.run_up(case, [35.0 * RPM, 70.0 * RPM, 140.0 * RPM, 350.0 * RPM])
print("\n".join(nm.run_up_lines(runs)))
nm.draw_run_up(runs).savefig("run_up.png")

once = [nm.peaks(run.orders)[0] for run in runs]
assert all(
    later.amplitude < sooner.amplitude and later.speed > sooner.speed
    for sooner, later in itertools.pairwise(once)
)
