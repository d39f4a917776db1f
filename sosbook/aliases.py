"""Short names of modules: ``sosbook.maps`` for ``sosbook.studies.maps``.

Both names give the same module, so nothing is imported twice.
"""

import sys
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec

MODULES = {
    "atlas": "book.elements",
    "counterexamples": "book.counterexamples",
    "couplings": "studies.polytopes",
    "maps": "studies.maps",
    "mip": "pendulum",
    "notebooks": "book.notebooks",
    "plots": "book.plots",
    "reproduction": "book.reproduction",
    "tables": "book.tables",
    "thesis": "book.thesis",
    "widgets": "book.widgets",
}


class _Alias(MetaPathFinder, Loader):
    """Finds the module behind a short name."""

    def find_spec(self, fullname, path=None, target=None):
        package, _, rest = fullname.partition(".")
        short, _, tail = rest.partition(".")
        if package != __package__ or short not in MODULES:
            return None
        name = f"{package}.{MODULES[short]}" + (tail and "." + tail)
        behind = find_spec(name)
        if behind is None:
            return None
        return ModuleSpec(
            fullname,
            self,
            origin=behind.origin,
            loader_state=behind,
            is_package=behind.submodule_search_locations is not None,
        )

    def create_module(self, spec):
        return import_module(spec.loader_state.name)

    def exec_module(self, module):
        """It has run already; the import system set its spec anew."""
        module.__spec__ = module.__spec__.loader_state

    def get_code(self, fullname):
        """For ``python -m sosbook.mip``."""
        behind = self.find_spec(fullname).loader_state
        return behind.loader.get_code(behind.name)


def install():
    """Let the import system know the short names."""
    if not any(isinstance(f, _Alias) for f in sys.meta_path):
        sys.meta_path.insert(0, _Alias())
