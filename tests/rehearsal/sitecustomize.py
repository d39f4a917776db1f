"""Another processor's rounding: noise on what numpy and scipy compute.

A folder with this file on PYTHONPATH is enough: Python imports it when it
starts, and so do Jupyter's kernels, pytest's workers and joblib's processes.
It does nothing unless SOSBOOK_REHEARSAL_NOISE holds a seed. Then the results
of factorisations, eigenvalue problems and linear solves are multiplied, entry
by entry, by 1 + 1e-13 u with u in [-1, 1].

u is a hash of the seed and of the entry's magnitude. So the noise depends on
no history, and what every LAPACK gives stays: zeros, signs, equal entries,
conjugate pairs, triangles, the order of sorted values, and the unit entries
of a factor. Integers, pivots and numbers in single precision are left alone.
"""

import functools
import importlib.machinery
import os
import re
import sys

SIZE = 1e-13
SEED = "SOSBOOK_REHEARSAL_NOISE"
SPECTRAL = re.compile("eig|svd")  # a one among these is luck, not structure
SHAKEN = {
    "numpy.linalg": re.compile(
        "cholesky|cond|det|eig(h|vals|valsh)?|inv|lstsq|pinv|qr|slogdet|solve"
        "|svd(vals)?|tensor(inv|solve)"
    ),
    "scipy.linalg": re.compile(
        "cholesky(_banded)?|cho_(factor|solve)(_banded)?|det|expm|hessenberg"
        "|eig(h|vals|valsh|_banded|h_tridiagonal|valsh_tridiagonal)?|inv|ldl"
        "|logm|lstsq|lu(_factor|_solve)?|null_space|orth|ordqz|pinvh?|polar"
        "|qr|qz|rq|schur|solve(_[a-z_]+)?|solveh_banded|sqrtm|svd(vals)?"
    ),
    "scipy.linalg.lapack": re.compile(
        "[dz](potr[fis]|trtr[is]|trsyl|getr[fis]|gesv|posv|geqrf|orgqr|ungqr"
        "|gees|geev|syevd?|heevd?|gesdd|sytrf|sysv)"
    ),
}


def unit(magnitudes, seed):
    """Numbers in [-1, 1], a hash (splitmix64) of the seed and the bits."""
    import numpy as np

    z = magnitudes.view(np.uint64) ^ np.uint64(seed * 0x9E3779B97F4A7C15 % 2**64)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        z = (z ^ (z >> np.uint64(shift))) * np.uint64(factor)
    z ^= z >> np.uint64(31)
    return (z >> np.uint64(11)) * 2.0**-52 - 1


def factors(values, seed, spectral):
    """What real `values` are multiplied by: 1 where they stay."""
    import numpy as np

    magnitudes = np.array(abs(values), dtype=float, ndmin=1, copy=True)
    u = unit(magnitudes, seed)
    if not spectral:
        u[magnitudes == 1] = 0
    return (1 + SIZE * u).reshape(np.shape(values))


def shaken(result, seed, spectral=False, given=()):
    """`result` of a function of the arrays `given`, with noise.

    Arrays and scalars in double precision, real or complex, alone or in
    (named) tuples; everything else is returned as it is. A result that lies
    in the memory of an argument is changed there.
    """
    import numpy as np

    if isinstance(result, tuple):
        parts = [shaken(part, seed, spectral, given) for part in result]
        return type(result)(*parts) if hasattr(result, "_fields") else tuple(parts)
    if isinstance(result, (float, complex)) and not isinstance(result, np.generic):
        return type(result)(shaken(np.asarray(result), seed, spectral)[()])
    numeric = isinstance(result, (np.ndarray, np.generic))
    if not numeric or result.dtype.char not in "dD":
        return result
    if not isinstance(result, np.ndarray):
        return shaken(np.asarray(result), seed, spectral)[()]
    noisy = result.copy(order="K")
    if np.iscomplexobj(result):
        noisy.real *= factors(result.real, seed, spectral)
        noisy.imag *= factors(result.imag, seed, spectral)
    else:
        noisy *= factors(result, seed, spectral)
        if spectral and result.ndim:
            noisy = resorted(result, noisy)
    if not result.flags.writeable:
        noisy.flags.writeable = False
    elif any(
        np.may_share_memory(result, a) for a in given if isinstance(a, np.ndarray)
    ):
        result[...] = noisy
        return result
    return noisy


def resorted(before, after):
    """`after`, whose last axis is sorted if that of `before` was."""
    import numpy as np

    steps = np.diff(before)
    if (steps >= 0).all():
        return np.sort(after)
    if (steps <= 0).all():
        return -np.sort(-after)
    return after


def noisy(function, module, name, seed):
    """The function of this name and module, with noise on its result."""

    @functools.wraps(function)
    def call(*args, **keywords):
        result = function(*args, **keywords)
        given = (*args, *keywords.values())
        return shaken(result, seed, bool(SPECTRAL.search(name)), given)

    call.__module__, call.__name__, call.__qualname__ = module, name, name
    return call


def shake(module, seed):
    """Put noise on a module's functions."""
    for name in filter(SHAKEN[module.__name__].fullmatch, dir(module)):
        function = getattr(module, name)
        if callable(function) and not isinstance(function, type):
            setattr(module, name, noisy(function, module.__name__, name, seed))


class Hook:
    """Shakes the modules that are to be shaken as soon as they are imported."""

    def __init__(self, seed):
        self.seed = seed

    def find_spec(self, name, path=None, target=None):
        if name not in SHAKEN:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None:
            load = spec.loader.exec_module

            def exec_module(module):
                load(module)
                shake(module, self.seed)

            spec.loader.exec_module = exec_module
        return spec


if os.environ.get(SEED):
    sys.meta_path.insert(0, Hook(int(os.environ[SEED])))
