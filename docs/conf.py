"""How Sphinx makes pages of docs/ and of the docstrings: `make docs`. They fetch nothing from elsewhere."""

import inverse

project = "inverse"
author = "The inverse authors"
project_copyright = author
release = version = inverse.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_heading_anchors = 3  # links to headings, as on the pages of repositories
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("BoolArray", "FloatArray", "IntArray")}
python_use_unqualified_type_names = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = f"inverse {release}"
html_show_sourcelink = False
html_copy_source = False
templates_path: list[str] = []
exclude_patterns = ["images"]
