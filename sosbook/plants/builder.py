"""A function that makes a plant, called with its parameters."""

import linecache
import types
import warnings

import numpy as np

from ..exact.rational import exact
from .checks import matrix
from .descriptor import OF_ARGUMENTS
from .descriptor_system import of_next
from .parametric import ParameterError, Symbolic, building, parameters
from .suspicions import divided

CHECKED_TO = 1e-9  # relative: plants by floats differ by their rounding errors
MAKERS = frozenset(
    ("zeros", "ones", "empty", "eye", "identity", "full")
    + ("zeros_like", "ones_like", "empty_like", "full_like")
)


def built(builder, box):
    """The plant's class, its matrices by name (object arrays of `Parametric`) and the
    other arguments that a ``builder``'s plant has for all parameters of a ``box``.
    Raises ParameterError, which quotes the line, where the code isn't rational in a
    parameter, and ValueError where the builder has other arguments or returns no plant.
    """
    made = _called(builder, box)
    if not isinstance(made, Symbolic):
        if not hasattr(made, "vertices"):
            raise ValueError(
                f"the builder must return a plant, got {type(made).__name__}"
            )
        raise ValueError(
            f"the plant doesn't depend on {', '.join(box.names)}: give the plant itself"
        )
    one = next(iter(parameters(box).values()))
    matrices, rest = {}, {}
    for name, given in made.given.items():
        if name in ("coordinates", "states", "dt"):
            rest[name] = given
        elif given is not None:
            matrices[name] = _entries(name, given, one)
    return made.kind, matrices, rest


def _called(builder, box):
    """The builder's result; a second try is with arrays that take expressions."""
    given, refused = parameters(box), []
    token = building.set(refused)

    def made_by(function):
        refused.clear()
        made = function(**given)
        if refused:
            raise refused[0]
        return made

    try:
        return made_by(builder)
    except Exception as first:
        again = _remade(builder)
        try:
            if again is builder:
                raise first
            return made_by(again)
        except ParameterError as second:
            raise _told(second, builder) from second
        except Exception:
            raise _told(first, builder) from first
    finally:
        building.reset(token)


def _told(error, builder):
    """The error in words: what isn't rational, and in which line of the builder."""
    text, kind = str(error), ParameterError
    if isinstance(error, ParameterError):
        pass
    elif "unexpected keyword" in text or "missing" in text:
        kind, text = ValueError, f"builder and ranges have other names: {text}"
    elif "ufunc" in text.lower() or "dtype" in text or "linalg" in text.lower():
        text = (
            f"numpy can't do this with a parameter ({text.splitlines()[0]}): write the "
            "equations so that no inverse is needed, with arrays of dtype=object, or "
            "give the result a range of its own"
        )
    elif isinstance(error, TypeError):
        text = f"this works for numbers, not for parameters: {text}"
    else:
        return error
    return kind(text + _line(error, builder))


def _line(error, builder):
    """The line of the builder's file where it was raised, quoted."""
    code = getattr(builder, "__code__", None)
    found, step = None, error.__traceback__
    while step and code:
        if step.tb_frame.f_code.co_filename == code.co_filename:
            found = step.tb_frame.f_code.co_name, step.tb_lineno
        step = step.tb_next
    if not found:
        return ""
    line = linecache.getline(code.co_filename, found[1]).strip()
    return f" [{found[0]}, line {found[1]}" + (f": {line:.90}]" if line else "]")


class _Numpy(types.ModuleType):
    """numpy, but new arrays of floats can hold expressions."""

    def __getattr__(self, name):
        return _object_maker(getattr(np, name))


def _object_maker(function):
    """A function of numpy, whose new array can hold expressions if it makes one."""

    def make(*args, **kwargs):
        array = function(*args, **kwargs)
        return array.astype(object) if array.dtype == float else array

    return make if getattr(function, "__name__", "") in MAKERS else function


def _remade(builder):
    """Copies of the builder and its module's functions with such a numpy."""
    if not isinstance(builder, types.FunctionType):
        return builder
    around: dict = {}

    def copied(f):
        again = types.FunctionType(
            f.__code__, around, f.__name__, f.__defaults__, f.__closure__
        )
        again.__kwdefaults__ = f.__kwdefaults__
        return again

    makers = {id(getattr(np, name)): getattr(np, name) for name in MAKERS}
    for name, value in builder.__globals__.items():
        if value is np:
            value = _Numpy("numpy")
        elif id(value) in makers:
            value = _object_maker(value)
        elif isinstance(value, types.FunctionType):
            if value.__globals__ is builder.__globals__:
                value = copied(value)
        around[name] = value
    return copied(builder)


def _entries(name, given, one):
    """A matrix as an object array of `Parametric`, or an error that has its name."""
    if hasattr(given, "toarray"):
        given = given.toarray()
    elif hasattr(given, "free_symbols") and hasattr(given, "tolist"):
        given = given.tolist()
    try:
        array = np.array(given, dtype=object)
    except ValueError:  # several shapes
        array = np.empty(0)
    if array.ndim == 0:
        array = array.reshape(1, 1)
    if array.ndim != 2:
        raise ValueError(f"{name} must be a matrix (two dimensions)")
    entries = np.empty(array.shape, object)
    for place, x in np.ndenumerate(array):
        entry = one.read(x)
        if entry is None:
            raise ValueError(f"{name}[{place[0]}, {place[1]}] = {x!r:.40} is no number")
        entries[place] = entry
    return entries


def check_by_numbers(builder, box, expected):
    """Raise where floats give a ``builder`` another plant somewhere in its ``box`` than
    ``expected``, from a point to matrices by name as the builder's own rows have them.
    Its plants' warnings are given once.
    """
    said: list = []
    for point in (box.low, box.high, box.inner):
        token = building.set([])
        try:
            given = {k: int(x.p) / int(x.q) for k, x in zip(box.names, point)}
            with warnings.catch_warnings(record=True) as heard:
                warnings.simplefilter("always")
                plant = builder(**given)
            said += heard
        finally:
            building.reset(token)
        if isinstance(plant, Symbolic):  # made of symbols of sympy, not of arguments
            return _tell(said, False)
        for name, mine in expected(point).items():
            given = np.asarray(_matrix_of(_first(plant), name), float)
            largest = np.abs(given).max(initial=0.0)
            if given.shape != mine.shape or (
                np.abs(given - mine).max(initial=0.0) > CHECKED_TO * largest
            ):
                raise ParameterError(
                    f"the builder gives another {name} when it is called with numbers: "
                    f"it isn't a function of {', '.join(box.names)} alone, or asks "
                    "for their type"
                )
    last = expected(box.inner)
    _tell(said, "S" in last and divided(last["M"], last["S"]))


def _tell(said, lagrange):
    """Warn of what a builder's calls said, once a line; not of a mass that isn't
    symmetric where its rows are Lagrange's, divided.
    """
    for w in {(w.category, w.lineno): w for w in reversed(said)}.values():
        if not (lagrange and "M isn't symmetric" in str(w.message)):
            warnings.warn_explicit(w.message, w.category, w.filename, w.lineno)


def _first(plant):
    """The first vertex as the builder has it: of discrete time with x(k+1)."""
    d, dt = plant.vertices[0], getattr(plant, "dt", None)
    return d if dt is None else of_next(d, dt)


def _matrix_of(vertex, name):
    """The matrix of a plant, or of a `Descriptor`, by its constructor's name."""
    if hasattr(vertex, "Bu"):
        name = OF_ARGUMENTS.get(name, name)
    return getattr(vertex, name)


def along(base, changes, rows):
    """A builder and ranges, of a ``base`` to which multiples of p u w' are added.

    ``changes``: by name (low, high, [(u, w), ...]), see `Uncertain.of`; ``rows``: by
    the kind of a plant the names of the matrices that its equations have.
    """
    if type(base) not in rows or len(base.vertices) > 1:
        raise ValueError(
            "base must be one SecondOrderSystem or DescriptorSystem, got "
            f"{type(base).__name__}"
        )
    names, vertex = rows[type(base)], _first(base)
    parts = [_matrix_of(vertex, name) for name in names]
    high, wide = len(parts[0]), sum(x.shape[1] for x in parts)
    ranges, steps = {}, {}
    for name, given in changes.items():
        try:
            low, top, pairs = given
            pairs = [(matrix("u", [u]), matrix("w", [w])) for u, w in pairs]
        except (TypeError, ValueError) as error:
            raise ValueError(
                f"{name} must be (low, high, [(u, w), ...]) with numbers, columns and "
                f"rows: {error}"
            ) from None
        if not pairs or any((u.size, w.size) != (high, wide) for u, w in pairs):
            raise ValueError(
                f"{name} needs pairs of a u with {high} entries and a w with {wide}, "
                f"a column and a row of [{' '.join(names)}]"
            )
        ranges[name] = low, top
        steps[name] = sum(exact(u.T) @ exact(w) for u, w in pairs)
    whole, cuts = exact(np.hstack(parts)), np.cumsum([x.shape[1] for x in parts])[:-1]
    second = hasattr(vertex, "M")
    beside = (
        {"coordinates": base.coordinates} if second else base.outputs | {"dt": base.dt}
    )

    def builder(**values):
        total = whole.view(np.ndarray)
        for name, p in values.items():
            step = steps[name].view(np.ndarray)
            total = total + step * (exact(p) if isinstance(p, float) else p)
        if all(isinstance(p, float) for p in values.values()):
            total = total.astype(float)
        matrices = dict(zip(names, np.split(total, cuts, axis=1)))
        return type(base)(**matrices, **beside)

    return builder, ranges
