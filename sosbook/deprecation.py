"""Names and calls that were changed go on working, with a DeprecationWarning."""

import functools
import sys
import warnings
from collections.abc import Callable
from inspect import Parameter, signature
from typing import TypeVar

_F = TypeVar("_F", bound=Callable)  # a decorated function keeps its type

__all__ = ["named_after", "renamed", "renamed_arguments", "renamed_attribute"]


def renamed(module, **names):
    """A module's ``__getattr__`` that knows its former names.

    Parameters
    ----------
    module : str
        The module's ``__name__``.
    **names : str
        The present name for each former one; with a dot it is looked up
        there, as ``discretize.segments``.

    Returns
    -------
    callable
        Returns the present object and warns; raises AttributeError for a name
        that the module never had.

    Examples
    --------
    >>> former = renamed("math", exponential="exp")
    >>> import warnings
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     print(former("exponential")(0.0), caught[0].message)
    1.0 math.exponential is now called exp
    """

    def former(name):
        if name not in names:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        warnings.warn(
            f"{module}.{name} is now called {names[name]}",
            DeprecationWarning,
            stacklevel=2,
        )
        return functools.reduce(getattr, names[name].split("."), sys.modules[module])

    return former


def renamed_attribute(former, present):
    """A property for an attribute's or a method's former name.

    Parameters
    ----------
    former, present : str
        The two names.

    Returns
    -------
    property
        Gives the present attribute and warns.
    """

    def get(self):
        warnings.warn(
            f"{type(self).__name__}.{former} is now called {present}",
            DeprecationWarning,
            stacklevel=2,
        )
        return getattr(self, present)

    get.__doc__ = f"The former name of `{present}`."
    return property(get)


def renamed_arguments(**names):
    """A decorator for a function some of whose keywords were renamed.

    Parameters
    ----------
    **names : str
        The present keyword for each former one.

    Returns
    -------
    callable
        The decorator. A call with a former keyword warns; with the former and
        the present one it raises TypeError.
    """

    def decorate(function):
        @functools.wraps(function)
        def call(*args, **given):
            for former in names.keys() & given.keys():
                present = names[former]
                if present in given:
                    raise TypeError(
                        f"{function.__name__}: {former} is the former name of "
                        f"{present}; give one of them"
                    )
                warnings.warn(
                    f"{function.__name__}: the argument {former} is now called "
                    f"{present}",
                    DeprecationWarning,
                    stacklevel=2,
                )
                given[present] = given.pop(former)
            return function(*args, **given)

        return call

    return decorate


def named_after(count: int) -> Callable[[_F], _F]:
    """Let only the first ``count`` arguments be given without a name.

    The others still work by position, with a DeprecationWarning that
    says what to write.

    Parameters
    ----------
    count : int
        How many arguments may be given by position.

    Examples
    --------
    >>> @named_after(1)
    ... def f(a, *, b=0):
    ...     return a + b
    >>> f(1, b=2)
    3
    >>> f(1, 2, 3)
    Traceback (most recent call last):
    TypeError: f takes at most 2 arguments: a, b; got 3
    """

    def decorate(function):
        kinds = signature(function).parameters.values()
        names = [p.name for p in kinds if p.kind is not Parameter.VAR_KEYWORD]

        @functools.wraps(function)
        def call(*given, **named):
            late = dict(zip(names[count:], given[count:]))
            if len(given) > len(names):
                raise TypeError(
                    f"{function.__name__} takes at most {len(names)} arguments: "
                    f"{', '.join(names)}; got {len(given)}"
                )
            for name in late.keys() & named.keys():
                raise TypeError(
                    f"{function.__name__} got {name} twice: by position and by name"
                )
            if late:
                write = ", ".join(f"{name}=..." for name in late)
                warnings.warn(
                    f"{function.__name__}: give {' and '.join(late)} by name, "
                    f"{function.__name__}({', '.join(names[:count])}, {write})",
                    DeprecationWarning,
                    stacklevel=2,
                )
            return function(*given[:count], **late, **named)

        return call

    return decorate
