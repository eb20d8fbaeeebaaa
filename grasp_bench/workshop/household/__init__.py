"""The 180 household objects, modelled in code, grouped by theme.

Importing this package registers all of them in :data:`grasp_bench.workshop.model.REGISTRY`.
"""

from importlib import import_module
from pkgutil import iter_modules

for _module in sorted(m.name for m in iter_modules(__path__)):
    import_module(f"{__name__}.{_module}")
