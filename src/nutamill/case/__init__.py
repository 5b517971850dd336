"""The case: everything that is needed to repeat a run, read from TOML and written back.

The only room that reads or writes TOML.
"""

from nutamill.case.library import library_names
from nutamill.case.model import Case, load_case

__all__ = ["Case", "library_names", "load_case"]
