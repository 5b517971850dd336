"""Natural frequencies of the NuMill on its mounts, with and without charge, and the speeds to avoid.

Checked: the frame's sway is that of a mass on springs with the foot-to-mass-centre coupling, the torsion that
of one inertia.
"""

import math

import nutamill as nm

case = nm.load_case("numill")
rest = nm.machine_modes(case)
print("\n".join(nm.modes_lines(rest)))
print("\n".join(nm.modes_lines(nm.machine_modes(case, charge=True))))
diagram = nm.campbell(case)
print("\n".join(nm.avoid_lines(diagram)))
nm.draw_modes(nm.sticks(case), rest).savefig("modes.png")
nm.draw_campbell(diagram).savefig("campbell.png")

coupling, shaft = case.shaft_coupling, case.intermediate_shaft
torsion = math.sqrt(coupling.torsion_stiffness / shaft.inertia_axial) / (2.0 * math.pi)
assert abs(rest.frequency[-1] - torsion) < 0.01 * torsion
