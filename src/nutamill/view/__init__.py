"""From numbers to pictures: figures, scenes, pages.  ``nm.view(result)`` shows a result in a notebook."""

import sys
from types import ModuleType
from typing import Any


class _Room(ModuleType):
    """A package that can be called, since the public face has a function of its name: importing anything of
    the package puts the package, not the function, at ``nutamill.view``.
    """

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Return the page of a result, as `nutamill.view.inline.inline_view` does."""
        from nutamill.view.inline import inline_view

        return inline_view(*args, **kwargs)


sys.modules[__name__].__class__ = _Room
