"""The charge engine beside published references; `python -m validation.charge` from the root of the
repository.
"""
