"""The steering of a search of a gain, in one object that every design takes."""

from dataclasses import dataclass, fields
from typing import Literal

from ..plants.checks import count, is_word, positive
from ..runtime.read_only import ReadOnly, put
from ..runtime.time_limit import checked_seconds
from .design import Design


@dataclass(frozen=True, eq=False)
class Search(ReadOnly):
    """The way to search a design; what is asked of it stays the same.

    Parameters
    ----------
    backoff : float
        With ``minimize`` or ``maximize``: the fraction by which the design's bound is
        looser than the best that was found.
    start : Design, optional
        A neighbouring design, of the same plant or one like it, to start from:
        faster, the answer is the same. One that isn't feasible is no help and is
        passed over.
    prefer : {None, "centre", "least"}
        ``"centre"`` is the analytic centre, which is far from every bound.
        ``"least"`` is a small gain, for one plant: K = 0 where that will do, else the
        least effort that moves the modes outside of the region and no others, else
        the H-infinity Riccati equation with the most weight of u. Without a word it
        is the centre below 40 states. From there on it is a small gain where poles
        alone are asked, for nothing bounds their centre's, and else the centre if it
        is found in a few seconds. `Design.effort` tells what a gain asks.
    starts : int, optional
        Of a law's gain: how many descents the search makes; without it 16, and 8 on a
        sampled loop.
    seed : int
        Of their random numbers; the same seed gives the same gain.
    time_limit : float
        Seconds after which the request is undecided, unless a design was found by
        then. It is looked at in each step of the solver and in each row of an exact
        factorisation; the answer comes after that.

    Raises
    ------
    ValueError
        If a value isn't as above, and by the designs that don't take one of them.

    Examples
    --------
    >>> Search(starts=4)
    Search(starts=4)
    >>> Search(prefer="smallest")
    Traceback (most recent call last):
    ValueError: prefer must be None, "centre" or "least", got 'smallest'
    """

    backoff: float = 0.01
    start: Design | None = None
    prefer: Literal["centre", "least"] | None = None
    starts: int | None = None
    seed: int = 0
    time_limit: float = 300.0

    def __post_init__(self) -> None:
        put(self, backoff=positive("backoff", self.backoff))
        if self.start is not None and not isinstance(self.start, Design):
            raise ValueError(f"start must be a Design, got {type(self.start).__name__}")
        if self.prefer is not None and not is_word(self.prefer, ("centre", "least")):
            raise ValueError(
                f'prefer must be None, "centre" or "least", got {self.prefer!r}'
            )
        if self.starts is not None:
            put(self, starts=count("starts", self.starts, 1))
        put(self, seed=count("seed", self.seed))
        put(self, time_limit=checked_seconds(self.time_limit, needed=True))

    def __repr__(self) -> str:
        return f"Search({', '.join(f'{k}={v!r}' for k, v in self._given().items())})"

    def _given(self):
        both = ((f.name, getattr(self, f.name), f.default) for f in fields(self))
        return {name: value for name, value, default in both if value != default}

    def taking(self, names: str, whose: str) -> "Search":
        """The search, if it has only what ``names`` lists in words; else a ValueError
        that says ``whose`` it isn't.
        """
        for name in self._given():
            if name not in names.split():
                raise ValueError(
                    f"search has {name}, which is not for {whose}: leave it out"
                )
        return self


USUAL = Search()
