"""How Sphinx builds these pages. `make docs` runs it, with warnings as errors and without the network."""

import sys
from pathlib import Path

from fenics_mech import __version__

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "fenics_mech"
author = "The fenics_mech developers"
release = version = __version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "generated_reference",
    "mathml",
]
exclude_patterns = ["_build", "_extensions"]

myst_enable_extensions = ["amsmath", "dollarmath", "deflist", "html_image"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

numpydoc_show_class_members = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
nitpick_ignore_regex = [("py:.*", ".*")]  # no inventory of numpy or xarray is fetched

html_theme = "furo"
html_title = f"fenics_mech {release}"
html_static_path = ["_static"]
html_css_files = ["tables.css"]
html_copy_source = False
html_show_copyright = False
