"""The channel of a norm: from which disturbances, to which outputs."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from ..exact.definite import exact
from ..exact.rational import inverse
from ..plants.checks import count, positive
from ..plants.descriptor import Descriptor
from ..plants.outputs import Output
from ..runtime.names import sane_name
from ..runtime.read_only import put
from .base import Requirement
from .vocabulary import PARAMETERS, Parameter


class Channel(Requirement):
    """A bound of a norm from some disturbances to an output. A class of it has the
    fields ``outputs``, ``inputs`` and ``name`` beside its bound, and says in ``plain``
    what its bound is called where nobody gave it a name.
    """

    plain: Parameter
    needs_equations = False  # whether it can't weigh x' with P's of the plants' own
    inputs: Any

    def __post_init__(self):
        """Check the bound, the outputs, the inputs and the name."""
        if self.bound is not None:
            key = self.plain.key
            put(self, **{key: positive(key, self.bound)})
        if self.outputs is not None and not isinstance(self.outputs, Output):
            raise ValueError(
                f"outputs must be an Output, got {type(self.outputs).__name__}: stack "
                "several by &"
            )
        if self.inputs is not None:
            put(self, inputs=places("inputs", self.inputs))
        if sane_name(self.name) in PARAMETERS and self.named:
            raise ValueError(
                f"name={self.name!r} is that of another bound: take one of its own"
            )

    @property
    def named(self) -> bool:
        """True if the bound has a name of its own."""
        return self.name != self.plain.key

    @property
    def parameter(self) -> Parameter:
        """The bound; a name of its own is its key, so that it can be minimised."""
        if not self.named:
            return self.plain
        words = f"{self.plain.words}, {self.name}"
        label = f"{self.plain.label} ({self.name})"
        return replace(self.plain, key=self.name, words=words, label=label)

    @property
    def promise(self) -> str:
        """The name of the promise."""
        return self.name

    @property
    def bound(self) -> float | None:
        return getattr(self, self.plain.key)

    def with_bound(self, bound: float) -> "Requirement":
        return replace(self, **{self.plain.key: bound})

    def check(self, request: Any) -> None:
        """Raise ValueError if the plant of ``request`` lacks outputs or inputs."""
        super().check(request)
        if request.plant.n == 0 and self.outputs is None:
            raise ValueError(
                f"{self.name} needs a plant with outputs, but the plant has no C: say "
                "which of its states, or mixtures of them, must answer little"
            )
        for i in self.inputs or ():
            if i >= request.plant.p:
                raise ValueError(
                    f"inputs: there is no disturbance {i}, for the plant has "
                    f"{request.plant.p}, counted from 0"
                )
        seen = [self.seen(d) for d in request.vertices]  # raises for other widths
        free = request.gain is not None and not self.needs_equations
        if not (free or self.fits_one_P(request)):
            raise ValueError(
                f"{self.name} weighs an acceleration, and its mass is uncertain: it "
                "would be divided by that mass. "
                + (
                    "Weigh another signal, or the equation's force"
                    if self.needs_equations
                    else 'Take coupling="slack", without one P for all plants'
                )
            )
        if not len(seen[0].C):
            raise ValueError(
                f"{self.name} bounds an output without rows: give C or outputs a row"
            )

    def of_plant(self) -> "Requirement":
        return replace(self, outputs=None, inputs=None)

    def fits_one_P(self, request: Any) -> bool:
        between = any(i != j for i, j in request.pairs)
        if self.needs_equations and not request.coupling.one_P:
            between = len(request.distinct) > 1
        seen = (Channel.seen(self, d) for d in request.ground.certain)
        return not between or _given_by_equations(seen)

    def data(self) -> dict:
        data = super().data()
        if self.outputs is not None:
            data["outputs"] = self.outputs.data()
        if self.inputs is not None:
            data["inputs"] = list(self.inputs)
        empty = [k for k in ("outputs", "inputs") if data[k] is None]
        return {k: x for k, x in data.items() if k not in empty}

    @classmethod
    def of_data(cls, data: dict) -> "Requirement":
        rest = dict(data)
        outputs, name = rest.pop("outputs", None), rest.pop("name")
        inputs = rest.pop("inputs", None)
        one = super().of_data(rest)
        outputs = None if outputs is None else Output.read(outputs)
        return replace(one, outputs=outputs, inputs=inputs, name=name)

    def claim(self) -> str:
        from ..exact.checker.requirements import claim

        return claim(self.data())


def places(name, some):
    """``some`` disturbances or inputs as a tuple; ``name``: the argument's."""
    if isinstance(some, str) or not isinstance(some, Iterable):
        raise ValueError(f"{name} must be a list of numbers, counted from 0")
    found = tuple(count(name, i) for i in some)
    if not found or len(set(found)) < len(found):
        raise ValueError(f"{name} must name one or more, each once")
    return found


def _given_by_equations(seen: "Iterable[Descriptor]") -> bool:
    """True if one mixture of the equations gives what the output has of x'."""
    first, *others = seen
    if first.Ca is None:
        return True
    L = exact(first.Ca) @ inverse(exact(first.E))
    return all((L @ exact(d.E) == exact(d.Ca)).all() for d in others)
