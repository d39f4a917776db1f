"""The package's answer to what an explorer asks, in the page's words.

In Jupyter an explorer asks the package instead of the page's own solver; both take
the same request and give an answer of the same form.
"""

import time

import numpy as np

from ...analysis.linear import peak_input
from ...laws.pid import PIDLaw
from ...plants.second_order import Polytope, SecondOrderSystem
from ...plants.uncertain import Uncertain
from ...requirements.cost import QuadraticCost
from ...requirements.hinf import HInfinity
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion
from ...synthesis.pid import design_pid
from ...synthesis.reasons import NO_COMMON_P
from ...synthesis.search import Search

EMPTY = "The region is empty."


class Answers:
    """Answers for one explorer: each design starts from the last.

    Examples
    --------
    >>> mass = {"M": [[1]], "D": [[1]], "S": [[1]], "B": [[1]]}
    >>> request = {"vertices": [mass], "U": [], "K_A": None, "coupling": "pairs"}
    >>> answers = Answers()
    >>> answers("move", request | {"asked": {"sigma": 1, "rho": 3}})["status"]
    'feasible'
    >>> answers("move", request | {"asked": {"sigma": 3, "rho": 3}})["reason"]
    'The region is empty.'
    """

    def __init__(self):
        self.last = None
        self.known = None, None  # the last request of a law, and its design

    def __call__(self, kind, request):
        """The answer to a request of the page.

        ``kind``, {"move", "probe", "prove"}: whether a design is drawn, only its status
        counts, or a proof is wanted; ``request``: the plant's "vertices", "U", "K_A",
        "coupling", and "asked". Returns dict: as JSON has it: "status", "reason", "ms",
        and of a design "K", "poles", "margins", "bounded", "norm", "peak", "cost";
        "proof" where one is wanted.
        """
        begin = time.perf_counter()
        answer = self._answer(kind, request)
        return answer | {"ms": 1000 * (time.perf_counter() - begin)}

    def _answer(self, kind, request):
        """The answer to one ``request`` of a ``kind``."""
        asked = request["asked"]
        if asked.get("rho", np.inf) <= asked.get("sigma", -np.inf):
            return {"status": "infeasible", "reason": EMPTY}
        try:
            if request.get("law"):
                return self._of_law(kind, request)
            design = design_pid(**asked_of(request), search=Search(start=self.last))
        except ValueError as fault:
            return {"status": "undecided", "reason": str(fault)}
        answer = {"status": design.status, "reason": _said(design.reason)}
        if design.status == "feasible":
            if kind == "move":
                self.last = design
            if kind != "probe":
                answer |= _found(design, asked.get("x0"))
        if kind == "prove":
            answer |= {"proof": _proof(design)}
        return answer

    def _of_law(self, kind, request):
        """The gains of a law by name, "own" on what the page measures, and a proof."""
        if self.known[0] != request:
            self.known = request, design_pid(**asked_of(request))
        _, design = self.known
        answer = {"status": design.status, "reason": design.reason}
        if design.status == "feasible":
            tau = request["law"].get("filter") or 1
            rows = [K / tau if name == "K_D" else K for name, K in design.gains.items()]
            answer["own"] = np.hstack(rows).tolist()
            answer["gains"] = {name: K.tolist() for name, K in design.gains.items()}
        return answer | ({"proof": _proof(design)} if kind == "prove" else {})


def _said(reason):
    """A reason in the page's words, whose elements ask for one P."""
    more = "; the package goes on with one for each vertex."
    return reason.replace(NO_COMMON_P, NO_COMMON_P[:-1] + more)


def asked_of(request):
    """Keywords of `design_pid` for a ``request`` of the page.

    Examples
    --------
    >>> mass = {"M": [[1]], "D": [[1]], "S": [[1]], "B": [[1]]}
    >>> request = {"vertices": [mass], "U": [], "K_A": None, "coupling": "pairs"}
    >>> asked_of(request | {"asked": {"sigma": 1.5}})["region"].sigma
    1.5
    """
    asked = request["asked"]
    plants = [SecondOrderSystem(**v) for v in request["vertices"]]
    law, family = request.get("law"), request.get("family")
    if law and family:
        plants = [Uncertain.read(SecondOrderSystem, family, rows=True)]
    region = {key: asked[key] for key in ("sigma", "theta", "rho") if key in asked}
    given = {
        "plant": plants[0] if len(plants) == 1 else Polytope(plants),
        "U": None if law else request["U"] or None,
        "K_A": request["K_A"],
        "coupling": "auto" if law else request["coupling"],
        "region": PoleRegion(**region) if region else None,
        "law": PIDLaw(**law) if law else None,
    }
    if "gamma" in asked:
        given["gamma"] = HInfinity(asked["gamma"], asked.get("mu"))
    if "u_max" in asked:
        given["saturation"] = Saturation(asked["u_max"], asked["x0"])
    if "cost" in asked:
        weights = asked["Q"], asked["R"], asked["noise"]
        given["requirements"] = [QuadraticCost(*weights, asked["cost"])]
    return given


def _found(design, x0):
    """A design as the page draws and tells it."""
    request = design.request
    poles = np.reshape(design.poles(), (len(request.vertices), -1))
    peak = None
    if request.saturation is not None:
        peak = design.peak_input()
    elif x0 is not None:
        peak = max(peak_input(d, design.K, x0) for d in request.vertices)
    return {
        "K": design.K.tolist(),
        "poles": [[[s.real, s.imag] for s in loop] for loop in poles.tolist()],
        "margins": {str(name): float(x) for name, x in design.margins.items()},
        "bounded": not design.central,
        "norm": float(design.hinf()) if request.plant.p else None,
        "peak": None if peak is None else float(peak),
        "cost": None if request.cost is None else float(design.noise_cost()),
    }


def _proof(design):
    """The exact proof of a design, or of there being none."""
    if design.status == "feasible":
        proof = design.certify()
    elif (proof := design.infeasibility) is None:
        return None
    return {
        "proven": bool(proof.proven),
        "text": getattr(proof, "text", ""),
        "claims": list(proof.claims),
        "blocks": list(getattr(proof, "blocks", ())),
        "digits": getattr(proof, "digits", None),
    }
