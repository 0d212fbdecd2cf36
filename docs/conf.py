# SPDX-License-Identifier: Apache-2.0
"""How Sphinx makes build/docs of the repository's pages: ``make docs``.

The source is the repository itself, so that the pages are those that one reads there. What a page
links to besides pages, a block of the RTL or a test, becomes a page of highlighted source.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

try:
    import tomllib
except ModuleNotFoundError:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parent.parent

project = "wavehaptics"
version = release = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
author = "the wavehaptics developers"
html_show_copyright = False

extensions = ["myst_parser", "autoapi.extension", "source_pages",
              "sphinx.ext.mathjax", "sphinx-mathjax-offline"]  # fmt: skip
root_doc = "README"
include_patterns = ["*.md", "docs/**.md", "boards/**.md", "formal/*.md", "rtl/*.md",
                    "sim/scenes/*.md", "build/api/**.rst"]  # fmt: skip

# Pictures with a width, two beside each other where there is room, are there what they are here.
myst_enable_extensions = ["html_image"]
# A block of an equation, as the repository's site has it. Its script comes with the pages.
myst_fence_as_directive = ["math"]
# What the repository's site does with headings: the places in links are the same.
myst_heading_anchors = 4
# Names that a tuple or loop makes; `range`, a type that is also a field's name.
suppress_warnings = ["autoapi.python_import_resolution", "ref.python"]

# Grouped by what a reader wants: to do something, to look something up, or to understand it.
toctrees = {
    "How-to guides": ["docs/board", "docs/identify", "docs/use_in_your_design", "docs/python",
                      "docs/c", "boards/README", "docs/wiring/README",
                      "docs/wiring/switching_on", "docs/development", "CONTRIBUTING",
                      "SECURITY"],
    "Explanation": ["docs/principle", "docs/paper", "docs/architecture", "docs/simulation",
                    "docs/port_anchor", "docs/environments", "docs/gallery", "docs/surfaces",
                    "docs/brushless", "docs/drive", "docs/sensing",
                    "docs/encoders"],
    "Results": ["docs/report", "docs/holding", "docs/reliability"],
    "Reference": ["sim/scenes/README", "docs/words", "docs/link", "rtl/faults", "docs/glossary",
                  "formal/README", "formal/MUTATE",
                  "Python reference <build/api/wavehaptics/index>", "CHANGELOG"],
    "Boards": ["boards/icebreaker/README", "boards/hx8k/README",
               "boards/ulx3s/README", "boards/ulx3s_three/README",
               "boards/ulx3s_space/README",
               "boards/ulx3s_brushless/README", "boards/ulx3s_gan/README",
               "boards/ulx3s_gan_brushed/README",
               "boards/colorlight_i5/README", "boards/orangecrab/README",
               "boards/ecp5_evn/README", "boards/icesugar_pro/README",
               "boards/icesugar_pro_eight/README", "boards/icesugar_pro_brushless/README"],
}  # fmt: skip

# Read and not imported: nothing is compiled, and no simulator is needed.
autoapi_dirs = ["sim/wavehaptics"]
autoapi_root = "build/api"
autoapi_ignore = ["*/cli/*", "*/__main__.py"]  # the command's own --help tells of it
autoapi_add_toctree_entry = False
autoapi_options = ["members", "show-module-summary", "undoc-members"]
autoapi_member_order = "bysource"
autoapi_python_class_content = "both"

html_theme = "furo"
html_title = "wavehaptics"
html_copy_source = False
html_show_sourcelink = False
html_static_path = ["site"]
html_css_files = ["site.css"]
