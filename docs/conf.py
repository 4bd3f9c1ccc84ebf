"""The site: ``sphinx-build -W docs out/site``."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "ext"))

project = "vibro"
copyright = ""
version = release = version_of("vibro")

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
    "sphinx-mathjax-offline",
    "commands",
    "equations",
]
exclude_patterns = ["ext", "images", "_made"]
nitpicky = False

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

autosummary_generate = True
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "image_scrapers": ("figures",),
    "within_subsection_order": "figures.place",
    "reset_modules": (),
    "write_computation_times": False,
    "min_reported_time": float("inf"),
    "show_signature": False,
    "download_all_examples": False,
    "notebook_examples": False,
}

html_theme = "furo"
html_static_path = ["css"]
html_css_files = ["gallery.css"]
html_title = "vibro"
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
