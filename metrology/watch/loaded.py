"""All that a report imports where it needs it, loaded beforehand: the processes of a `Runner` branch off from it."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages

import metrology

LIBRARIES = (
    *(
        "fontTools.subset",
        "jinja2.sandbox",
        "matplotlib.backends.backend_svg",
        "matplotlib.figure",
        "matplotlib.mathtext",
    ),
    *("scipy.integrate", "scipy.interpolate", "scipy.ndimage", "scipy.optimize", "scipy.signal", "scipy.stats"),
    *("matplotlib.backends.backend_agg", "numba", "uncertainties", "xml.dom.minidom"),
)
ELSEWHERE = ("api", "batch", "cli", "draft", "export", "lsp", "signoff", "watch", "__main__")
"""Subpackages that no report needs."""

for _name in LIBRARIES:
    import_module(_name)
for _found in walk_packages(metrology.__path__, "metrology."):
    if _found.name.split(".")[1] not in ELSEWHERE:
        import_module(_found.name)
