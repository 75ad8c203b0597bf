"""Solids to closed meshes within a tolerance, with the error and the time written beside them.

>>> import genus
>>> part = genus.sphere(10) - genus.cylinder(h=30, r=3, center=True)
>>> mesh = part.mesh(tolerance=0.1)
>>> mesh.is_closed
True
"""

# All public names come straight from the compiled module; heavier parts of the package
# (genus.report, genus.cli) are imported by those who use them.
from genus._core import *  # noqa: F403
from genus._core import __version__ as __version__
