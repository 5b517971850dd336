"""The documentation site: ``sphinx-build -W -b html docs build/docs`` makes it (extra ``docs``).

Pages about the code are written from the code first, into docs/generated.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from generate import write_pages  # noqa: E402

import nutamill  # noqa: E402

project = "nutamill"
author = "the nutamill developers"
version = release = nutamill.__version__
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
html_theme = "pydata_sphinx_theme"
html_title = "nutamill"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {"header_links_before_dropdown": 4, "show_nav_level": 1, "navigation_with_keys": False}
exclude_patterns = ["build"]
suppress_warnings = [
    "myst.xref_missing"
]  # links into the source tree, which a reader of the repository follows

write_pages(HERE.parent, HERE / "generated")
