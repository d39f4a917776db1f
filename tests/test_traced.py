"""Theorems print themselves, and three readers find in the text what they say."""

import inspect
import json
import re

import numpy as np
import pytest

import sosbook as sos
from sosbook import theorems
from sosbook.exact.checker import kernel as checker
from sosbook.exact.checker.arithmetic import gather
from sosbook.exact.definite import exact
from sosbook.language import Traced, block, eye, he, named, tr
from sosbook.theorems.text import called_with, text_of

SIZES = ({"N": 2, "m": 1, "n": 1, "p": 1}, {"N": 4, "m": 3, "n": 2, "p": 3})
CASES = {
    "legendre": [{"order": k, "mu": mu} for k in (0, 1, 3) for mu in (0.07, 0)],
    "interval": [{"order": k, "late": late} for k in (0, 1) for late in (0, 1)],
    "delay": [{"mu": 0.3}, {"mu": 0}],
    "pole_region": [{}, {"beta": [[0, 1], [0, 0]]}, {"alpha": [[1.4]], "beta": [[1]]}],
}
THEOREMS = [
    f for name in theorems.__all__ if inspect.isfunction(f := getattr(theorems, name))
]


def cases():
    """Each theorem at two sizes, in all its cases."""
    for function in THEOREMS:
        name = function.__name__
        of_kind = (some for part, some in CASES.items() if part in name)
        for given in next(of_kind, [{}]):
            known = {"mu", *inspect.signature(function).parameters}
            given = {k: v for k, v in given.items() if k in known}
            for k, v in given.items():
                given[k] = np.array(v) if isinstance(v, list) else v
            for sizes in SIZES:
                yield function, sizes, given


def readings(rng):
    """Each case: its text, its data in decimals, and what the function makes of it."""
    for function, sizes, given in cases():
        data = {}

        def make(name, shape, symmetric):
            x = rng.integers(-999, 999, shape) / 1000
            if symmetric and shape:
                x = np.tril(x) + np.tril(x, -1).T
            x = x if shape else abs(float(x)) + 0.001
            x = data[name] = given.get(name, x)
            return exact(x)

        now = {
            k: exact(v) if isinstance(v, np.ndarray) else v for k, v in given.items()
        }
        now |= {"mu": exact(now["mu"])} if "mu" in now else {}
        wanted = called_with(make, function, sizes, **now)
        text = [
            line.removesuffix(" > 0")
            for line in text_of(function, sizes, **given).split("\n")
        ]
        lines = [x for x in text if "=" in x] + [
            f"block.{k}: {x} > 0" for k, x in enumerate(x for x in text if "=" not in x)
        ]
        yield (
            function.__name__,
            "\n".join(lines),
            written(data),
            [[[str(e) for e in row] for row in g] for g in wanted],
        )


def written(data):
    """As in a proof file."""
    return {
        k: [[repr(e) for e in r] for r in np.asarray(v).tolist()]
        if np.ndim(v)
        else repr(v)
        for k, v in data.items()
    }


def test_each_theorem_as_its_text_is_read_in_python():
    count = 0
    for name, text, data, wanted in readings(np.random.default_rng(1)):
        reader = checker.Reader({k: checker.Reader.read(v) for k, v in data.items()})
        said = [left.v for _, _, left, _ in reader.statements(checker.parse(text))]
        assert len(said) == len(wanted)
        for g, w in zip(said, wanted):
            if checker.scalar(g):
                g = gather([[g]], 1)
            assert g == checker.Reader.read(w), (name, text)
        count += 1
    assert count > 3 * len(THEOREMS) >= 90


READ = """cases => {
  const {Reader, FRACTIONS} = globalThis.kernel ??= sosKernel();
  const same = (X, W) => X.rows === W.rows && X.cols === W.cols
    && X.at.every(([n, d], k) => n * W.at[k][1] === W.at[k][0] * d);
  return cases.map(([text, data, wanted]) => {
    const reader = new Reader(FRACTIONS);
    for (const [name, x] of Object.entries(data)) reader.env[name] = reader.known(x);
    const said = [...reader.statements(text)].map(({value}) => value.X);
    return said.length === wanted.length
      && said.every((X, k) => same(X, reader.known(wanted[k]).X));
  }); }"""


def test_each_theorem_as_its_text_is_read_on_the_page(kernel):
    names, *some = zip(*readings(np.random.default_rng(2)))
    same = kernel.evaluate(READ, list(zip(*some)))
    assert len(same) == len(names) and not [
        n for n, good in zip(names, same) if not good
    ]


def test_a_reading_that_differs_is_noticed(kernel):
    """The comparisons above find one digit that is wrong."""
    wrong = ["a: [P, 2; ., 1] > 0", {"P": [["0.5"]]}, [[["1/2", "2"], ["2", "1.01"]]]]
    right = [*wrong[:2], [[["1/2", "2"], ["2", "1"]]]]
    assert kernel.evaluate(READ, [wrong, right]) == [False, True]


def test_texts_are_laid_out_like_print():
    texts = {
        f.__name__: text_of(f)
        for f in (
            theorems.bounded_real,
            theorems.stability,
            theorems.pole_region,
            theorems.control_bound,
            theorems.trace_bound,
            theorems.regular_mass,
        )
    }
    assert texts == {
        "bounded_real": "-[he(Theta), EP C', W; ., -gamma^2/mu, 0; ., 0, -mu] > 0",
        "stability": "-he(Theta) > 0",
        "pole_region": "-(kron(alpha, EPE) + he(kron(beta, Theta))) > 0",
        "control_bound": "[P, Y'; ., u_max^2] > 0",
        "trace_bound": "bound - tr(J) > 0",
        "regular_mass": "[he((M - B K_A)/2), beta; ., 1] > 0",
    }


def test_sizes_that_nothing_tells_are_written():
    A, mu = Traced.matrix("A", 2, 3), Traced.number("mu")
    assert block([[A, 0], [0, 3 * eye(1)]]).text == "[A, 0; 0, 3]"
    assert block([[0 * A, A @ A.T], [A.T @ A, 0]]).text == "[0, A A'; A' A, 0]"
    assert (
        block([[mu * eye(2), 0], [0, 1 / mu * eye(1)]]).text == "[mu I(2), 0; 0, 1/mu]"
    )
    assert block([[eye(2), 0], [0, -tr(A.T @ A)]]).text == "[I(2), 0; 0, -tr(A' A)]"


def test_a_name_is_defined_before_it_is_used():
    A, P = Traced.matrix("A", 2), Traced.matrix("P", 2, symmetric=True)
    half = named("half", A @ P / 2)
    both = named("both", he(half))
    assert (both + half @ P).definitions == ["half = A P/2", "both = he(half)"]
    assert (both + half.T).text == "both + half'" and both.T.text == "both"


@pytest.mark.parametrize(
    "write",
    [
        lambda P: np.sqrt(P),
        lambda P: P * P,
        lambda P: np.trace(P),
        lambda P: np.vstack([P, P]),
        lambda P: P[0],
        lambda P: eye(2) if P[0, 0] > 0 else P,
        lambda P: P + "P",
    ],
)
def test_what_cannot_be_traced_says_so(write):
    with pytest.raises((TypeError, ValueError), match="traced|Traced|block, eye, he"):
        write(Traced.matrix("P", 2, symmetric=True))


# -------------------------------------------- the texts of proof files, written by hand
def proofs():
    """Certificates of designs, each with the theorems that its labels are of."""
    D, S = np.array([[0.4, -0.1], [-0.1, 0.2]]), np.array([[6.0, -2], [-2, 4]])
    plants = [
        sos.SecondOrderSystem(m * np.eye(2), D, S, np.eye(2), np.eye(2))
        for m in (1, 1.5)
    ]
    plant, one = sos.Polytope(plants), np.eye(4)
    asked = [
        {"region": sos.PoleRegion(sigma=0.3, theta=1.2, rho=9)},
        {"gamma": sos.HInfinity(0.9, mu=0.8)},
        {"saturation": sos.Saturation(40, [0.1, 0.1, 0, 0])},
        {"requirements": [sos.QuadraticCost(one, np.eye(2), bound=400.0)]},
        {"requirements": [sos.QuadraticCost(one, np.eye(2), "F", bound=400.0)]},
    ]
    for coupling in ("pairs", "slack"):
        for wanted in asked:
            yield coupling, sos.design_pid(plant, coupling=coupling, **wanted).certify()


def by_hand_and_traced(coupling, proof):
    """(label, value of the file's text, value of the traced theorem), in fractions."""
    file = json.loads(proof.text)
    data, point = (
        {k: checker.Reader.read(v) for k, v in file[part].items()}
        for part in ("data", "point")
    )
    reader = checker.Reader(data, point, file["sets"], True)
    slack = coupling == "slack"
    noise = "W" if '"noise":"F"' in proof.text else "I(4)"
    theorem_of = {
        "stability": "slack_stability" if slack else "stability",
        "region": "slack_pole_region" if slack else "pole_region",
        "hinf": "slack_bounded_real" if slack else "bounded_real",
        "x0": "slack_initial_state" if slack else "initial_state",
        "u_max": "control_bound", "trace": "trace_bound", "cost": "lqr_cost",
        "lqr": "slack_lqr_decay" if slack else "lqr_decay",
    }  # fmt: skip
    for _, label, left, _ in reader.statements(checker.parse("\n".join(file["text"]))):
        head, *rest = label.split(".")
        if head not in theorem_of or label == "sign.u_max":
            continue
        given = {}
        if head == "region" and slack:  # a disk has a form of its own
            beta = proof_beta(file, rest[0])
            given = {"beta": np.array(beta)} if beta == [[0, 1], [0, 0]] else {}
        text = text_of(getattr(theorems, theorem_of[head]), **given)
        names = {"noise": noise, "EV": "EP"}
        if head == "region":
            names |= {"alpha": f"alpha.{rest[0]}", "beta": f"beta.{rest[0]}"}
        if slack:
            names |= {"P": "P.i"}
        if head == "cost" and noise != "W":
            names |= {"EPE": "(he(V) - P.i)" if slack else "P"}
        elif head == "cost" and slack:
            names |= {"EPE": "(he(EVE) - EPE)"}
        text = re.sub(r"[A-Za-z]\w*", lambda m: names.get(m[0], m[0]), text)
        traced = reader.value(checker.Parser(text.removesuffix(" > 0")).expression())
        yield head, left.v, traced.v


def proof_beta(file, k):
    return [[float(e) for e in row] for row in file["data"][f"beta.{k}"]]


def test_what_files_say_by_hand_is_what_the_theorems_say_of_themselves():
    seen = set()
    for coupling, proof in proofs():
        assert proof.proven, coupling
        for head, by_hand, traced in by_hand_and_traced(coupling, proof):
            assert by_hand == traced, (coupling, head)
            seen.add((coupling, head))
    heads = {"stability", "region", "hinf", "x0", "u_max", "trace", "cost", "lqr"}
    assert seen >= {(c, head) for c in ("pairs", "slack") for head in heads}
