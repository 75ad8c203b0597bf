"""Solids to closed meshes within a tolerance, with the error and the time written beside them.

>>> import genus
>>> part = genus.sphere(10) - genus.cylinder(h=30, r=3, center=True)
>>> mesh = part.mesh(tolerance=0.1)
>>> mesh.is_closed
True
"""

from genus import _core
from genus._core import *  # noqa: F403
from genus._core import __version__

# Names of _core are public unless they begin with an underscore; heavier modules of the package
# (genus.report, genus.cli) are imported by those who use them.
__all__ = ["__version__", *(name for name in dir(_core) if not name.startswith("_"))]  # noqa: PLE0604
