"""The balance mass the NuMill needs: one plane, two planes, and two planes with the charge's mass.

Checked: two planes leave less than one, and the weights' moments come near the machine's unbalance of 0.16 kg
m.
"""

import nutamill as nm

ONE, TWO = [(0.08, 0.42)], [(0.08, 0.42), (0.08, 0.2)]

case = nm.load_case("numill")
one, two, loaded = (
    nm.balance_mill(case, ONE),
    nm.balance_mill(case, TWO),
    nm.balance_mill(case, TWO, charge=True),
)
for title, balancing in (
    ("one plane", one),
    ("two planes", two),
    ("two planes, with the charge's mass", loaded),
):
    print("\n".join([title, *nm.balance_lines(balancing, case)]))
nm.draw_balancing(two, case).savefig("balancing.png")

assert two.after < 0.2 * one.after < 0.2 * one.before
assert abs(sum(weight.mass * weight.radius for weight in two.weights) - 0.16) < 0.01
