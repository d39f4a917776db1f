"""Exact proofs of decay rates under delay, as files."""

import numpy as np

from ..exact.definite import definite, exact, round_digits
from ..exact.proof import first_proven
from ..exact.proof_file import GainProof, given_gain
from ..exact.rational import decimal, decimals, read_array, read_number
from ..exact.refusal import MultiplierRefusal
from ..plants.as_data import plant_data, read_plant
from ..plants.checks import as_written
from ..synthesis.proofs import frame_data, read_frame
from .forms import FORMS
from .request import DelayedLoop, DelayRequest


class DelayProof(GainProof):
    """An exact proof of a decay rate under delay, or its failure; ``text`` is its file.

    It has the plant, the delay, the gain and the matrices of the functional as
    decimals, in the coordinates of the LMIs. The exponentials of the theorem are
    rounded to rationals on the side on which the theorem stays true.
    """

    kind = "delay"

    @property
    def functional(self):
        """The matrices of the functional and the multipliers, by name."""
        return {
            name: read_array(rows, None, None)
            for name, rows in self.data["unknowns"].items()
        }

    @classmethod
    def contents(cls, request, K, values):
        """The data of the file for a request, a rounded K and exact values."""
        return {
            **problem_data(request),
            "K": decimals(K),
            "unknowns": {name: decimals(x) for name, x in values.items()},
        }


class DelayRefusal(MultiplierRefusal):
    """Multipliers that exclude every functional; its ``text`` is the file's."""

    kind = "infeasible delay"

    @property
    def part(self):
        """Which part of the loop they are about, in words; empty if all of it."""
        data, Z = self.data, self.multipliers
        if data["plant"]["kind"] == "loop":
            N = len(data["plant"]["A"])
            moved = [z.diagonal() != 0 for z in Z.values()]
            seen = {i % N + 1 for rows in moved for i in np.flatnonzero(rows)}
            if len(seen) < N:
                return f"the states {', '.join(map(str, sorted(seen)))} alone"
        if any(definite(z)[0] for z in Z.values()) or not Z:
            return ""
        return "what the delay doesn't reach fixed"

    @classmethod
    def contents(cls, request):
        """The data of the file for a request, without the multipliers."""
        return {
            **problem_data(request),
            "K": None if request.gain is None else decimals(request.gain),
        }


def prove_delay(request, K, unknowns, digits=None):
    """The proof of a ``request``, of K in ``digits`` and ``unknowns`` by name."""

    def attempt(digits, places):
        values = {
            name: round_digits(x, places) for name, x in unknowns.items() if name != "X"
        }
        gain = round_digits(K, digits)
        contents = DelayProof.contents(request, gain, values)
        return DelayProof.of(contents)

    return first_proven(attempt, digits, **given_gain(request.gain))


def refuse_delay(request, Z):
    """The file of the multipliers Z of a request, made exact; None where that fails."""
    expressions, unknowns = request.in_unknowns(exact)
    data = DelayRefusal.contents(request)
    return DelayRefusal.mended(data, expressions, unknowns, Z, str)


def delay_refusal(request, Z):
    """The file of exact multipliers of a request: Z, from a block to Z_k >= 0."""
    data = DelayRefusal.contents(request)
    return DelayRefusal.of(DelayRefusal.written_from(data, Z, str))


def problem_data(request):
    """The loop, the delay and what is asked by a request: words and decimals."""
    if isinstance(request.plant, DelayedLoop):
        loop = request.plant
        plant = {"kind": "loop", "A": decimals(loop.A), "A_d": decimals(loop.A_d)}
    else:
        plant = plant_data(request.plant)
    return {
        "plant": plant,
        "U": [] if request.U is None else decimals(request.U),
        "K_A": None,
        "tau": decimal(request.tau),
        "mu": decimal(request.mu),
        "delta": decimal(request.delta),
        "alpha": decimal(request.alpha) if _has_alpha(request) else None,
        "method": request.method,
        "order": request.order if FORMS[request.method].first_order else None,
        "misprints": list(request.misprints),
        "analysis": request.gain is not None,
        "coordinates": frame_data(request.frame),
        "exponentials": [str(q) for q in _exponentials(request)],
    }


def _exponentials(request):
    """The rationals that stand for exponentials."""
    if not FORMS[request.method].shifted:
        times = request.times(exact)
        return times.epsilon1, times.epsilon2
    return [q for _, q in request.factors(exact)] if request.delta else ()


def _has_alpha(request):
    """True if the file of a request has an alpha: where its LMIs depend on one."""
    return request.alpha is not None and request.needs_alpha


@as_written()
def read_delay_request(data, framed=True):
    """The `DelayRequest` of the ``data`` that `problem_data` writes.

    In the coordinates of the file, if ``framed``.
    """
    plant = data["plant"]
    if plant["kind"] == "loop":
        N = len(plant["A"])
        plant = DelayedLoop(*(read_array(plant[x], N, N) for x in ("A", "A_d")))
    else:
        plant = read_plant(plant)
    U, given = data["U"], data["K"] if data["analysis"] else None
    request = DelayRequest(
        plant,
        read_array(U, None, plant.n) if U else None,
        *(read_number(data[x]) for x in ("tau", "mu", "delta")),
        None if data["alpha"] is None else read_number(data["alpha"]),
        data["method"],
        data["order"],
        tuple(data["misprints"]),
        None if given is None else read_array(given, plant.m, None),
    )
    if request.alpha is not None and not _has_alpha(request):
        raise ValueError("alpha belongs to a design")
    if not framed:
        return request
    return in_frame(request, read_frame(data["coordinates"], request.states))


def in_frame(request, frame):
    """The request in the coordinates of a file, which are a `Frame`: frame."""
    vars(request)["frame"] = frame  # where it would be remembered
    return request
