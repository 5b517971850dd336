"""One function, one figure: a result or an answer in, a Matplotlib figure out.  Saving is left to the
caller.
"""
