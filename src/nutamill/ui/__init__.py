"""The local page: a form for a case, its check, runs and results in a browser, for who does not write TOML.

It is served on loopback by the standard library, calls what the commands call, and computes nothing.
"""
