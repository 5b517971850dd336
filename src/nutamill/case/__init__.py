"""The case: everything that is needed to repeat a run, read from TOML and written back.

The only room that reads or writes TOML.
"""

from nutamill.base.library import library_file, library_names
from nutamill.case.machine import Machine
from nutamill.case.mill import Case, case_of_text, load_case

__all__ = [
    "Case",
    "Machine",
    "case_of_text",
    "library_file",
    "library_names",
    "load_case",
]
