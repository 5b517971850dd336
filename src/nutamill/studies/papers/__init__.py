"""The two NuMill papers as data: what was measured, what their authors simulated, and the runs of ours that
answer them.

``library`` reads a paper's file, ``runs`` names the cases and result files it needs, ``quantities`` takes
numbers from one result, ``compare`` sets them against the paper row by row, ``table`` writes the comparison.
Nothing here steps a mill.
"""
