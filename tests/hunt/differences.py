"""One request after the other, asked in all ways, and what doesn't agree."""

import json
import tempfile
import traceback
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import sosbook as sos
from sosbook.exact.checker.verdict import asked_of as what_it_asks
from sosbook.requirements.base import Requirement
from tests.asking import asked_by, asking, mended
from tests.hunt import clocks
from tests.hunt.laws import questions, searched
from tests.hunt.readers import alone, on_pages, package
from tests.hunt.requests import FACTORS, in_units, request
from tests.hunt.tampering import tampered, true_claims, vertices_in
from tests.hunt.truth import broken

LIMIT = 10  # seconds for one answer
CHANGES = 8  # of each proof file
LAWS, SPOILT = 0.4, 0.2  # of the requests: with known gains, and their files changed
CLOCKS = 0.3  # of the requests: their plants in a loop with a clock, too
BETWEEN = 6  # plants between the vertices that a claim is tried on


class Hunt:
    """What was asked, and every difference that was found, with its request's seed.

    ``page``: the page's solver; without it nobody asks it.
    """

    def __init__(self, page=None):
        self.page, self.counts, self.differences = page, Counter(), []

    def __str__(self):
        rows = [f"{count:7d}  {what}" for what, count in sorted(self.counts.items())]
        return "\n".join([*rows, f"{len(self.differences):7d}  DIFFERENCES"])

    def ask(self, seed):
        """Ask one request in all ways; the differences that are new, as words."""
        before, asked = len(self.differences), request(seed)
        rng = np.random.default_rng([seed, 1])
        try:
            self._ask(asked, rng)
        except Exception:  # whatever it is, the hunt has caught something
            last = traceback.format_exc(limit=-2).strip().replace("\n", " | ")
            self._differs(asked, f"an error that nobody expects: {last}")
        return self.differences[before:]

    def _differs(self, asked, what):
        self.differences.append(f"{asked}: {what}")

    def _ask(self, asked, rng):
        self.counts["requests"] += 1
        try:
            design = designed(asked)
        except ValueError as fault:
            self.counts[f"refused as input: {str(fault)[:40]} ..."] += 1
            return
        self.counts[f"answers: {design.status}"] += 1
        proof = self._backed(asked, design, rng)
        if proof is not None:
            self._tamper(asked, proof, rng)
        for what, proof in other_proofs(asked.vertices[0], rng):
            self.counts[f"proofs of {what}"] += 1
            self._read(asked, proof.text, rng, f"the proof of {what}")
            self._tamper(asked, proof, rng)
        self._elsewhere(asked, design, rng)
        if rng.random() < LAWS:
            self._known(asked, rng)
        if rng.random() < CLOCKS:
            self._clocked(asked, rng)
        if self.page is not None and on_pages(asked):
            self._on_page(asked, design, rng)

    def _backed(self, asked, design, rng):
        """The proof of an answer, if there is one; it is read by all."""
        if design.status == "feasible":
            proof = design.certify(time_limit=LIMIT)
        elif design.status == "infeasible":
            proof = design.infeasibility
        else:
            return None
        if not proof.proven:
            self.counts[f"{design.status} without a proof"] += 1
            if design.status == "infeasible":
                self._differs(asked, "infeasible, and nothing proves it")
            return None
        self._read(asked, proof.text, rng, "the package's proof")
        return proof

    def _read(self, asked, text, rng, whose):
        """All readers accept a proof, say the same of it, and it is true."""
        self.counts["proofs read by the package and the checker"] += 1
        mine, theirs = read_by_both(text)
        if mine is None or theirs is None:
            who = "the package" if mine is None else "the checker"
            self._differs(asked, f"{whose} is refused by {who}")
        elif theirs != "beyond" and mine != theirs:
            self._differs(asked, f"{whose}: the package reads {mine}, else {theirs}")
        else:
            self._true(asked, what_it_asks(json.loads(text)), mine, rng, whose)

    def _true(self, asked, file, claims, rng, whose):
        """Whether a file that asks this tells the truth."""
        if file["kind"] != "design":
            if true_claims(file) is False:
                self._differs(asked, f"{whose} is false")
            return
        if file["K_A"] is not None or file["plant"]["kind"] != "second order":
            return
        self.counts["claims compared with the truth"] += 1
        plants = [
            {x: np.array(v[x], float) for x in "MDSBF"} for v in vertices_in(file)
        ]  # a changed file may hold a number that no plant of the package has
        vertices = [
            SimpleNamespace(**v, n=len(v["M"]), p=v["F"].shape[1]) for v in plants
        ]
        n, U = vertices[0].n, file["U"]
        faults = broken(
            vertices,
            np.array(file["K"], float),
            np.array(U, float) if U else None,
            [Requirement.read(r) for r in file["requirements"]],
            rng,
            0 if "not the plants between" in claims[0] else BETWEEN,
        )
        if faults:
            self._differs(asked, f"{whose} is false (n = {n}): {faults[0]}")

    def _tamper(self, asked, proof, rng):
        """Changes of a file are accepted by all and true, or refused by all."""
        self._tamper_with(asked, json.loads(proof.text), mended, rng)
        self._tamper_with(asked, asked_by(proof), asking, rng)

    def _tamper_with(self, asked, whole, file_of, rng):
        """The files of contents that were changed."""
        changed = list(tampered(whole))
        for k in rng.permutation(len(changed))[:CHANGES]:
            path, other = changed[k]
            other = file_of(other)
            self.counts["changed files"] += 1
            text = json.dumps(other)
            mine, theirs = read_by_both(text)
            what = f"the proof with another {'.'.join(map(str, path))}"
            if theirs == "beyond" or (mine is None) == (theirs is None):
                if mine is not None:
                    self.counts["changed files that are proofs"] += 1
                    self._true(asked, what_it_asks(other), mine, rng, what)
                    if theirs not in ("beyond", mine):
                        self._differs(asked, f"{what}: {mine}, else {theirs}")
            else:
                who = "the package" if theirs is None else "the checker"
                self._differs(asked, f"{what} is accepted by {who} alone")

    def _elsewhere(self, asked, design, rng):
        """The verdict in other units doesn't contradict this one."""
        there = in_units(asked, *rng.choice(FACTORS, 3))
        if there is None:
            return
        self.counts["requests in other units"] += 1
        again = designed(there)
        if {design.status, again.status} == {"feasible", "infeasible"}:
            if len(design.request.pairs) != len(again.request.pairs):
                # vertices that are a box but for rounding: the pairs are asked there
                self.counts["units in which the last bit makes a box or not"] += 1
            else:
                self._differs(there, f"{again.status}, and {design.status} before")
        elif design.status != again.status:
            self.counts["units with an answer less or more"] += 1

    def _known(self, asked, rng):
        """Gains that are known are asked on both sides of the truth, laws searched."""
        for question in questions(asked, rng):
            design = question.answer(LIMIT)
            side = "kept" if question.kept else "broken"
            self.counts[f"known gains that a plant {side}: {design.status}"] += 1
            if fault := question.contradicts(design):
                self._differs(asked, fault)
            self._spoilt(asked, design, rng, question.words)
        words, design, fault = searched(asked, rng)
        self.counts[f"laws: {design.status}"] += 1
        if fault:
            self._differs(asked, fault)
        self._spoilt(asked, design, rng, words)

    def _spoilt(self, asked, design, rng, words):
        """All readers take the proof of an answer, and what is changed in it."""
        proof = design.infeasibility
        if design.status == "feasible":
            proof = design.certify(time_limit=LIMIT)
        if proof is None or not proof.proven:
            return
        self._read(asked, proof.text, rng, f"the proof of {words}")
        if rng.random() < SPOILT:
            self._tamper(asked, proof, rng)

    def _clocked(self, asked, rng):
        """A sampled loop: all read its proof, sequences of ticks fall as it says."""
        words, plant, K, clock = clocks.request(asked.vertices, rng)
        proof = sos.certify_sampled(plant, K, time_limit=LIMIT, **clock)
        if not proof.proven:
            self.counts["sampled loops: not proven"] += 1
            return
        who = "this package alone" if proof.examined.alone else "the checker"
        self.counts[f"sampled loops: proven by {who}"] += 1
        self._read(asked, proof.text, rng, f"the proof of {words}")
        self._tamper(asked, proof, rng)

    def _on_page(self, asked, design, rng):
        self.counts["requests on a page"] += 1
        answer = self.page.design(asked)
        if {design.status, answer["status"]} == {"feasible", "infeasible"}:
            self._differs(asked, f"{answer['status']} on a page")
        if "text" in answer:
            self._read(asked, answer["text"], rng, "the page's proof")


def designed(asked):
    """What `design_pid` answers."""
    return sos.design_pid(
        asked.plant, search=sos.Search(time_limit=LIMIT), **asked.keywords
    )


def other_proofs(plant, rng):
    """A proof of another kind of one plant, where there is one: (words, proof)."""
    n, m = plant.n, plant.m
    match rng.choice(["regulator", "observer", "delay", "mass", "none"]):
        case "regulator":
            C = rng.standard_normal((int(rng.integers(1, 2 * n + 1)), 2 * n))
            design = sos.design_lqr(
                plant, C.T @ C, np.eye(m), search=sos.Search(time_limit=LIMIT)
            )
        case "observer":
            one = np.eye(2 * n)
            K = sos.design_lqr(
                plant, one, np.eye(m), search=sos.Search(time_limit=LIMIT)
            ).K
            if K is None:
                return
            design = sos.design_observer(
                plant, K, np.vstack([one, one]), np.eye(n), time_limit=LIMIT
            )
        case "delay":
            tau = 0.02 / (1e-3 + np.abs(plant.poles()).max())
            design = sos.design_delay_pid(
                plant, tau=tau, mu=0.0, delta=0.01 / tau, time_limit=LIMIT
            )
        case "mass":
            design = sos.regularize(plant)
        case _:
            return
    if design.status == "feasible":
        proof = design.certify(time_limit=LIMIT)
        if proof.proven:
            yield type(design).__name__, proof


def read_by_both(text):
    """What the package and the checker read in a text: claims or None each."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "proof.json")
        file.write_text(text, "utf-8")
        return package(file), alone(text)
