"""Natural frequencies of the NuMill on its mounts, with and without charge, and the speeds to avoid.

Checked: the frame's sway is that of a mass on springs with the foot-to-mass-centre coupling, the torsion that
of one inertia.
"""

import math

import nutamill as nm
from nutamill.design.figures import draw_campbell, draw_modes
from nutamill.design.modes import avoid_lines, campbell, machine_modes, modes_lines
from nutamill.design.sticks import sticks

case = nm.load_case("numill")
rest = machine_modes(case)
print("\n".join(modes_lines(rest)))
print("\n".join(modes_lines(machine_modes(case, charge=True))))
diagram = campbell(case)
print("\n".join(avoid_lines(diagram)))
draw_modes(sticks(case), rest).savefig("modes.png")
draw_campbell(diagram).savefig("campbell.png")

coupling, shaft = case.shaft_coupling, case.intermediate_shaft
torsion = math.sqrt(coupling.torsion_stiffness / shaft.inertia_axial) / (2.0 * math.pi)
assert abs(rest.frequency[-1] - torsion) < 0.01 * torsion
