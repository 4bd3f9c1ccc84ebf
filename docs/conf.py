"""The site: ``sphinx-build -W docs out/site``."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "ext"))

project = "vibro"
version = release = version_of("vibro")
language = "en"
smartquotes = False  # "--" is an option here
root_doc = "index"

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
    "commands",
    "equations",
    "maps",
    "reference",
    "rooms",
]
exclude_patterns = ["ext", "images", "_made", "_static", "_templates"]
nitpicky = True
# Of sweeps, described where they are listed.
nitpick_ignore = [("py:obj", "axes"), ("py:obj", "cycle"), ("py:obj", "fixed")]

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

autosummary_generate = False  # a page has several names
autodoc_typehints = "none"  # the sections of a docstring have types, in the reader's words
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
toc_object_entries_show_parents = "hide"

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "image_scrapers": ("figures",),
    "within_subsection_order": "figures.place",
    "reset_modules": (),
    "write_computation_times": False,
    "min_reported_time": float("inf"),
    "show_memory": False,
    "show_signature": False,
    "download_all_examples": False,
}

# One file draws all formulas, without a font; without its menu a formula is no stop of the Tab key.
mathjax = find_spec("sphinx-mathjax-offline")
if mathjax is None or mathjax.origin is None:
    raise ImportError("python -m pip install -e '.[docs]'")
mathjax_path = "tex-svg.js"
mathjax3_config = {"options": {"enableMenu": False}}

html_theme = "furo"
html_title = "vibro"
html_static_path = ["_static", str(Path(mathjax.origin).parent / "static" / "mathjax" / mathjax_path)]
html_css_files = ["site.css", "gallery.css"]
html_js_files = ["site.js"]
html_favicon = "_static/icon.svg"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
html_use_index = True
templates_path = ["_templates"]
html_theme_options = {"top_of_page_buttons": []}
