"""How an object shows itself in a notebook, without its room knowing the room of tables and pictures."""

import importlib
from typing import Any


def notebook_html(function: str, shown: Any) -> str:
    """Return the HTML of an object: what a function of the room ``notebook`` makes of it.

    The function is loaded when a notebook asks, as the names of the public face are.

    Parameters
    ----------
    function : module and name in ``nutamill.notebook``, as ``"results.result_html"``
    shown : the object
    """
    module, _, name = function.partition(".")
    return getattr(importlib.import_module(f"nutamill.notebook.{module}"), name)(shown)
