"""What a designer asks of a case: modes, run-up, balance, isolation.  Each answer runs the mechanism of the
empty mill.
"""
