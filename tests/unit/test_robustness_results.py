"""300 damaged results: each is refused in a sentence or read as it was written;
`python -m validation.robustness results` has more.
"""

import importlib

outcomes, results = (
    importlib.import_module(f"validation.robustness.{name}") for name in ("outcome", "results")
)


def test_damaged_results_are_refused_in_a_sentence_and_never_used_without_a_word():
    bad = []
    for _, name, read in results.attempts(300, seed=7, thorough=0.0):
        outcome = outcomes.outcome(read, longest=60.0)
        bad += [] if outcome.good else [f"{name}: {outcome.kind}: {outcome.detail}"]
    assert not bad
