"""Libraries that only some uses of the package need.

From a plant to a proof the package needs numpy, scipy and python-flint.
Everything else is imported through `library`, where it is used.
"""

from importlib import import_module

#: From an extra of the package to the libraries that are imported for it.
EXTRAS = {
    "control": ("control",),
    "plot": ("matplotlib",),
    "cones": ("cvxpy", "clarabel"),
    "notebook": ("ipywidgets", "IPython"),
    "hdf5": ("h5py",),
    "parallel": ("joblib", "tqdm", "threadpoolctl"),
    "book": ("nbformat", "nbclient", "playwright", "pypdf"),
}


def library(name):
    """Import an optional library, or say how to install it.

    ``name``: the module's name, such as "matplotlib.pyplot". Returns the imported
    module. Raises ModuleNotFoundError if the library isn't installed. Its text has the
    command that installs it.

    >>> library("scipy.linalg").__name__
    'scipy.linalg'
    """
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
    """The extra that installs the library of this name, or None.

    Examples
    --------
    >>> extra_of("cvxpy")
    'cones'
    """
    return next((extra for extra, names in EXTRAS.items() if name in names), None)
