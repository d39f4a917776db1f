"""Outputs behind filters: weights that differ from frequency to frequency."""

from collections.abc import Sequence

import numpy as np

from ..exact.rational import exact
from ..runtime.array_like import ArrayLike
from .checks import numbers
from .descriptor import Descriptor, descriptors
from .descriptor_system import DescriptorSystem
from .joined import joined_family
from .kinds import Plant, checked_plant
from .outputs import Output
from .reduction import Reduction


def filtered(
    plant: Plant,
    output: Output,
    numerator: Sequence[float],
    denominator: Sequence[float],
    U: ArrayLike | None = None,
) -> DescriptorSystem:
    r"""The plant with an output behind a filter, whose states join the plant's.

    A norm counts all frequencies alike. Behind a filter W(s) with a large
    \|W(j omega)\| where they matter it counts them by that weight.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        The plant, or several.
    output : Output
        The y before the filter; each of its rows has a filter of its own.
    numerator, denominator : sequence of float
        The coefficients of W, the highest power of s first; W is proper and stable.
    U : (a, n) array_like, optional
        Which errors are integrated, as in `design_pid`.

    Returns
    -------
    DescriptorSystem
        Its states are [z; z'; x3] and those of the filters, its output is W y; of an
        Uncertain it has the same parameters. A gain
        that is designed for it has columns for the filters' states, so that the
        controller runs the filters, too; a given gain has zeros there.

    Raises
    ------
    ValueError
        If W isn't proper or not stable, or the rows don't fit the plant.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem(1, 1, 1, B=1, F=1)
    >>> low = filtered(cart, Output(position=1), [1], [0.5, 1])
    >>> low.order, low.n
    (3, 1)
    """
    if not isinstance(output, Output):
        raise ValueError(
            f"output must be an Output, such as Output(position=1), got {output!r}"
        )
    num = _coefficients("numerator", numerator)
    den = _coefficients("denominator", denominator)
    if not den[0] or not num[0]:
        raise ValueError("the first coefficients of a filter must not be zero")
    if len(num) > len(den):
        raise ValueError(
            "the filter isn't proper: its numerator has a higher power than its "
            "denominator; give the denominator as many poles"
        )
    if len(den) > 1 and np.roots(den).real.max() >= 0:
        raise ValueError("the filter isn't stable: its poles must lie in Re s < 0")
    checked = checked_plant(plant, of="filtered")
    vertices: Sequence[Descriptor]
    if isinstance(checked, DescriptorSystem):
        if U is not None:
            raise ValueError("a DescriptorSystem takes no U: put it into its matrices")
        vertices = checked.vertices
    else:
        vertices = descriptors(checked, U)

    def one(d):
        return _joined(output.seen(d), num, den)

    if checked.family is not None:
        return joined_family(checked.family, one, U).polytope()
    joined = [*map(one, vertices)]
    return DescriptorSystem.of(joined, Reduction.in_states(checked, len(joined[0].E)))


def _coefficients(name, value):
    found = numbers(name, value)
    if found.ndim != 1 or not len(found) or not np.isfinite(found).all():
        raise ValueError(f"{name} must be a list of numbers, the highest power first")
    return found


def _joined(d, num, den):
    """A `Descriptor` d with the states of the filters of its output's rows."""
    q, N, k = len(d.C), len(d.E), len(den) - 1
    number = exact if d.E.dtype == object else np.asarray

    def zero(*shape):
        return number(np.zeros(shape))

    num = np.concatenate([np.zeros(k + 1 - len(num)), num])
    direct = num[0] / den[0]
    rest = num - direct * den
    # den[0] xi_k' = y - den[k] xi_1 - ... - den[1] xi_k, and xi_j' = xi_(j + 1)
    chain, last = np.eye(k), np.eye(k, k, 1)
    if k:
        chain[-1, -1], last[-1] = den[0], -den[:0:-1]
    into = number(np.kron(np.eye(q), np.eye(k)[:, -1:]) if k else np.zeros((0, q)))
    several = chain, last, rest[:0:-1][None]
    chain, last, seen = (number(np.kron(np.eye(q), x)) for x in several)
    direct = number(np.array([[direct]]))[0, 0]
    Du = zero(q, d.Bu.shape[1]) if d.Du is None else d.Du
    Dw = zero(q, d.Bw.shape[1]) if d.Dw is None else d.Dw
    Ca = zero(q, N) if d.Ca is None else d.Ca
    E = np.block([[d.E, zero(N, q * k)], [-into @ Ca, chain]])
    A = np.block([[d.A, zero(N, q * k)], [into @ d.C, last]])
    Bu, Bw = np.vstack([d.Bu, into @ Du]), np.vstack([d.Bw, into @ Dw])
    C = np.hstack([direct * d.C, seen])
    Ca = np.hstack([direct * Ca, zero(q, q * k)])
    return Descriptor(E, A, Bu, Bw, C, direct * Du, direct * Dw, Ca)
