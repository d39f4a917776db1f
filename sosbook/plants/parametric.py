"""Numbers that depend on parameters: exact quotients of polynomials."""

from contextvars import ContextVar
from dataclasses import fields

import numpy as np
from flint import Ordering, fmpq_mpoly, fmpq_mpoly_ctx

#: A list while a builder is called: plants that it makes may hold parameters. It has
#: the errors of comparisons, which a builder may catch, and go on as if answered.
building: ContextVar = ContextVar("building", default=None)

OWN_RANGE = "give the result a range of its own"
CURES = {
    "sqrt": "give the root a range of its own and write its square",
    "sin": "give s = sin(q) and c = cos(q), or sin(q)/q, ranges of their own",
    "cos": "give s = sin(q) and c = cos(q) ranges of their own",
}
FUNCTIONS = (  # numpy asks an object for a method of that name
    "sqrt cbrt sin cos tan arcsin arccos arctan arctan2 sinh cosh tanh exp exp2 expm1 "
    "log log2 log10 log1p hypot deg2rad rad2deg radians degrees floor ceil rint trunc"
)


class ParameterError(TypeError, ValueError):
    """Code that isn't rational in a parameter, or isn't the same in its whole range."""


class Parametric:
    """A quotient of polynomials in parameters, ``num`` / ``den``, without a zero of den
    in the ``box``: comparisons are answered where the answer is the same in all of it.
    It lives in object arrays, and without ``__array_ufunc__`` and priority numpy takes
    it for a number.

    >>> from sosbook.plants.bernstein import Box
    >>> m, k = parameters(Box.of(m=(1, 2), k=(3, 4))).values()
    >>> k / (2 * m) - 0.1 * m, k > m
    ((-0.2*m^2 + k)/(2*m), True)
    """

    __slots__ = ("box", "den", "num")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, num, den, box):
        if not den.is_constant():
            common = num.gcd(den)
            num, den = num / common, den / common
        if den.is_constant():
            num, den = num / den.leading_coefficient(), num.context().constant(1)
        self.num, self.den, self.box = num, den, box

    def read(self, x):
        """A number or sympy's expression x as such a `Parametric`, or None."""
        from .bernstein import rational

        if isinstance(x, np.ndarray) and x.ndim == 0:
            x = x[()]
        if isinstance(x, Parametric):
            if x.box is not self.box:
                raise ParameterError("parameters of two families are mixed")
            return x
        if isinstance(x, (complex, np.complexfloating)):
            raise ParameterError("a plant is real: a complex number met a parameter")
        if isinstance(x, (bool, np.bool_)):
            raise ParameterError("True and False are no numbers: write 1 and 0")
        if hasattr(x, "free_symbols"):
            return self.read(_of_sympy(x, parameters(self.box)))
        one = self.den.context().constant(1)
        try:
            return Parametric(one * rational("a constant", x), one, self.box)
        except ValueError:
            return None

    def _with(self, x, made):
        if isinstance(x, np.ndarray) and x.ndim:
            return NotImplemented  # numpy does it entry by entry
        x = self.read(x)
        return NotImplemented if x is None else made(x)

    def __add__(self, x):
        def added(x):
            if self.den == x.den:
                return Parametric(self.num + x.num, self.den, self.box)
            num = self.num * x.den + x.num * self.den
            return Parametric(num, self.den * x.den, self.box)

        return self._with(x, added)

    def __mul__(self, x):
        return self._with(
            x, lambda x: Parametric(self.num * x.num, self.den * x.den, self.box)
        )

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return Parametric(-self.num, self.den, self.box)

    def __pos__(self):
        return self

    def __sub__(self, x):
        return self._with(x, lambda x: self + -x)

    def __rsub__(self, x):
        return self._with(x, lambda x: x + -self)

    def __truediv__(self, x):
        return self._with(x, lambda x: self * x._inverse())

    def __rtruediv__(self, x):
        return self._with(x, lambda x: x * self._inverse())

    def _inverse(self):
        if self.num.is_zero():
            raise ParameterError("division by an expression that is zero")
        if not self.never_zero:
            raise ParameterError(
                f"division by {self}, which may be zero for {self.box}: narrow the "
                "ranges"
            )
        return Parametric(self.den, self.num, self.box)

    def __pow__(self, power):
        if isinstance(power, Parametric) or power != int(power):
            raise ParameterError(
                f"({self})**{power}: only whole powers are rational; {CURES['sqrt']}"
            )
        power = int(power)
        if power < 0:
            return self._inverse() ** -power
        return Parametric(self.num**power, self.den**power, self.box)

    def __rpow__(self, base):
        raise ParameterError(f"{base}**({self}) isn't rational: {OWN_RANGE}")

    @property
    def real(self):
        """The number itself."""
        return self

    @property
    def imag(self):
        """Zero."""
        return 0

    def conjugate(self):
        """The number itself."""
        return self

    @property
    def never_zero(self):
        """True if the number is provably not zero for any values of the parameters."""
        return self._answers(_not_zero, _zero) == {True}

    def _answers(self, sure, never):
        """See `Box.answers`; the zeros of the numerator count, and signs of both."""
        return self.box.answers((self.num * self.den).to_dict(), sure, never)

    def _compared(self, sign, x, sure, never):
        """True if the bounds of the difference answer it on the whole box."""

        def answered(x):
            answers = (self - x)._answers(sure, never)
            if len(answers) == 1:
                return answers.pop()
            known = "isn't the same" if {True, False} <= answers else "isn't decided"
            error = ParameterError(
                f"`{self} {sign} {x}` {known} for all {self.box}: make one "
                "family for each case"
            )
            if building.get() is not None:
                building.get().append(error)
            raise error

        return self._with(x, answered)

    def __lt__(self, x):
        return self._compared("<", x, lambda a, b: b < 0, lambda a, b: a >= 0)

    def __le__(self, x):
        return self._compared("<=", x, lambda a, b: b <= 0, lambda a, b: a > 0)

    def __gt__(self, x):
        return self._compared(">", x, lambda a, b: a > 0, lambda a, b: b <= 0)

    def __ge__(self, x):
        return self._compared(">=", x, lambda a, b: a >= 0, lambda a, b: b < 0)

    def __eq__(self, x):
        return self._compared("==", x, _zero, _not_zero)

    def __ne__(self, x):
        return self._compared("!=", x, _not_zero, _zero)

    def __bool__(self):
        return self != 0

    def __abs__(self):
        return self if self >= 0 else -self

    def __float__(self):
        raise ParameterError(
            f"{self} depends on a parameter, and stands where only a plain number can: "
            "in float(...), in a function of math, or in a float array (write "
            "np.zeros(shape, dtype=object))"
        )

    __int__ = __index__ = __complex__ = __float__

    def __round__(self, digits=None):
        return float(self)

    def __repr__(self):
        num, den = (self.words(x) for x in (self.num, self.den))
        return num if self.den.is_one() else f"({num})/({den})"

    def __format__(self, spec):
        return repr(self)

    def at(self, point):
        """The value at a ``point`` of rationals, in the order of the names."""
        return self.num(*point) / self.den(*point)

    def words(self, polynomial):
        """A ``polynomial`` in these parameters, in words."""
        from .polynomials import in_words

        return in_words(polynomial.to_dict(), self.box.names)


def _zero(low, high):
    return low == high == 0


def _not_zero(low, high):
    return low > 0 or high < 0


def _refused(name):
    def method(self, *_):
        """Raise a ParameterError: it isn't rational."""
        raise ParameterError(
            f"{name}({self}) isn't rational in the parameters: "
            f"{CURES.get(name, OWN_RANGE)}"
        )

    return method


for _name in FUNCTIONS.split():
    setattr(Parametric, _name, _refused(_name))


def parameters(box):
    """The parameters of a ``box`` as `Parametric`, by name."""
    context = fmpq_mpoly_ctx.get(box.names, Ordering.lex)
    one: fmpq_mpoly = context.constant(1)
    return {name: Parametric(x, one, box) for name, x in zip(box.names, context.gens())}


def made_of(entries, box):
    """An array of `Parametric` in a ``box``; ``entries``: terms by exponents."""
    one = next(iter(parameters(box).values()))
    context, array = (
        one.num.context(),
        np.empty((len(entries), len(entries[0])), object),
    )
    for place in np.ndindex(array.shape):
        terms = context.from_dict(entries[place[0]][place[1]])
        array[place] = Parametric(terms, one.den, box)
    return array


def _of_sympy(expression, known):
    """The value of an expression of sympy, its symbols read by their names."""
    from sympy import lambdify

    symbols = list(expression.free_symbols)
    missing = sorted({s.name for s in symbols} - known.keys())
    if missing:
        raise ParameterError(f"{', '.join(missing)} has no range and no value")
    return lambdify(symbols, expression)(*(known[s.name] for s in symbols))


class Symbolic:
    """A plant with parameters: its ``kind`` and the arguments ``given`` to it."""

    def __init__(self, kind, given):
        self.kind, self.given = kind, given

    def __getattr__(self, name):
        raise ParameterError(
            f"the builder asks for .{name} of a plant whose parameters have no values "
            "yet: it may only make the plant"
        )


class MayBeSymbolic:
    """A plant's base; it leaves a `Symbolic` if args or kwargs hold a parameter."""

    def __new__(cls, *args, **kwargs):
        if building.get() is not None:
            given = dict(zip((f.name for f in fields(cls)), args)) | kwargs
            if any(map(_depends, given.values())):
                return Symbolic(cls, given)
        return object.__new__(cls)


def _depends(x):
    """True if a parameter is somewhere in a number, an array or nested lists."""
    if isinstance(x, np.ndarray):
        return x.dtype == object and any(map(_depends, x.flat))
    if isinstance(x, (list, tuple)):
        return any(map(_depends, x))
    return isinstance(x, Parametric) or bool(getattr(x, "free_symbols", ()))
