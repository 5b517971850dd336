"""How often the 95 % interval of a steady mean holds the true mean: `python benchmarks/steady.py`, about ten
seconds.

Records of one number per turn, autoregressive of first order with coefficient phi, whose correlation length
is (1 + phi)/(1 - phi).
"""

import numpy as np

from nutamill.base.steady import estimate_of_turns

RECORDS, BEFORE = 1000, 300


def main() -> None:
    random = np.random.default_rng(1)
    print("| turns | correlation length | interval holds the mean | called steady |")
    print("|---|---|---|---|")
    for turns in (20, 60, 200):
        for phi in (0.0, 0.5, 0.8):
            noise = random.standard_normal((RECORDS, turns + BEFORE))
            records = np.empty_like(noise)
            records[:, 0] = noise[:, 0]
            for k in range(1, turns + BEFORE):
                records[:, k] = phi * records[:, k - 1] + noise[:, k]
            found = [estimate_of_turns(record[BEFORE:]) for record in records]
            held = np.mean([abs(one.mean) < one.half_width for one in found])
            print(
                f"| {turns} | {(1 + phi) / (1 - phi):.0f} | {100 * held:.0f} % | "
                f"{100 * np.mean([one.steady for one in found]):.0f} % |"
            )


if __name__ == "__main__":
    main()
