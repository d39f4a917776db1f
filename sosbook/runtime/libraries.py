"""Libraries that some uses need: a proof asks for numpy, scipy and python-flint."""

from importlib import import_module

#: From an extra of the package to the libraries that are imported for it.
EXTRAS = {
    "control": ("control",),
    "plot": ("matplotlib",),
    "cones": ("cvxpy", "clarabel"),
    "notebook": ("ipywidgets", "IPython"),
    "hdf5": ("h5py",),
    "uff": ("pyuff",),
    "parallel": ("joblib", "tqdm", "threadpoolctl"),
    "book": ("nbformat", "nbclient", "playwright", "pypdf"),
}


def library(name):
    """Import an optional library, ``name``, or say what command installs it."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        top = name.partition(".")[0]
        if error.name is None or error.name.partition(".")[0] != top:
            raise  # installed, but something that it needs is missing
        extra = extra_of(top)
        wanted = top if extra is None else f"sosbook[{extra}]"
        raise ModuleNotFoundError(
            f'{top} is needed for this and isn\'t installed: pip install "{wanted}"',
            name=top,
        ) from None


def extra_of(name):
    """The extra that installs the library of this ``name``, or None."""
    return next((extra for extra, names in EXTRAS.items() if name in names), None)
