"""Every documented value of every option gets an answer, or an error that names it.

They are read from docstrings (``{"pairs", "slack"}``; "As in `f`", "Keywords of `f`")
and ``Literal`` in signatures. A public function with an option needs a call here.
"""

import ast
import inspect
import re
import traceback
import typing
from functools import cache
from itertools import product

import numpy as np
import pytest
from numpydoc.docscrape import FunctionDoc

import sosbook as sos
from sosbook import pendulum
from sosbook.book import thesis
from sosbook.book.elements.movers import regulator
from sosbook.book.elements.movers.mover import slider
from sosbook.controllers import Code, CompiledCode, Profile
from sosbook.delay import DelayedLoop
from sosbook.pendulum.compiled import Compiled
from sosbook.pendulum.export import Program
from sosbook.pendulum.margins import SampledLoop, lowest_rate, sensing
from sosbook.pendulum.play import motion_with_play
from sosbook.pendulum.recorded import check_recording
from sosbook.pendulum.rig import DATA, shipped
from sosbook.pendulum.steering import Steering
from sosbook.studies import maps, polytopes
from tests.cases import campaign, examples
from tests.closed import analyse_loop
from tests.test_docstrings import function_of, public

CART = sos.SecondOrderSystem(M=1, D=0.1, S=2, B=1, F=1)
PAIR = sos.Polytope([CART, sos.SecondOrderSystem(M=1.2, D=0.1, S=3, B=1, F=1)])
LIGHT = sos.SecondOrderSystem(np.diag([1e-4, 1]), np.eye(2), np.eye(2), np.eye(2))
FIRST_ORDER = sos.DescriptorSystem(
    [np.eye(2), np.diag([1, 1.2])],
    [[[0, 1], [-2, -0.1]], [[0, 1], [-3, -0.1]]],
    [[0], [1]],
    [[0], [1]],
    np.eye(1, 2),
)
PLANTS = examples((CART, FIRST_ORDER), (CART, PAIR, FIRST_ORDER))
K = np.array([[-1.0, -2.0]])
LOOP = np.eye(2), [[[0, 1], [-3, -2.1]], [[0, 1], [-4, -2.1]]], [[0], [1]], [[1, 0]]
WITH = {  # what the least bound of a name needs beside it
    "u_max": dict(saturation=sos.Saturation(None, [1, 0])),
    "cost": dict(requirements=[sos.QuadraticCost(np.eye(2), [[1]])]),
}
FIRMWARE = pendulum.Firmware(
    pendulum.SampledLaw.of_gain(thesis.mip().gains["PD"][1], 0.01)
)
STEERING = Steering(FIRMWARE, [[-0.93, -0.29, -0.52]], 0.25, 0.07, 0.034)
ROBOT = pendulum.Robot.shipped("thesis")
GEARMOTORS = pendulum.Robot.shipped("gearmotors")
OBSERVER = sos.design_observer(PAIR, K, np.eye(4), [[1]])


def of_each_plant(function, *given):
    """One call of a design function a plant, with what ``minimize`` needs."""

    def ask(plant):
        return lambda **o: function(plant, *given, **completed(o, plant))

    return [ask(plant) for plant in PLANTS]


def completed(options, plant=CART):
    """Options with the companion of a bound, where the plant has an input."""
    more = WITH.get(options.get("minimize"), {})
    if options.get("maximize"):
        first = [[1, 0]] if plant is FIRST_ORDER else [[1]]
        more = dict(
            law=sos.PIDLaw(position=first, filter=0.05), search=sos.Search(starts=1)
        )
    return options | more


def looped(**options):
    cost = sos.QuadraticCost(np.eye(2), [])
    more = {"cost": dict(requirements=[cost])}.get(options.get("minimize"), {})
    return analyse_loop(*LOOP, **options | more)


def observed(**options):
    """The loop of observer and plant, whose states are twice as many."""
    more = {
        "u_max": dict(saturation=sos.Saturation(None, [0, 0, 1, 0])),
        "cost": dict(requirements=[sos.QuadraticCost(np.eye(4), [[1]])]),
    }
    return OBSERVER.analyse(**options | more.get(options.get("minimize"), {}))


def noisy(noise):
    cost = sos.QuadraticCost(np.eye(2), [[1]], noise, bound=50.0)
    return [sos.design_pid(plant, requirements=[cost]) for plant in PLANTS]


def edged(name="sigma", **options):
    cost = sos.QuadraticCost(np.eye(2), [[1]], bound=50.0)
    held = {
        "u_max": dict(saturation=sos.Saturation(9.0, [1, 0])),
        "cost": dict(requirements=[cost]),
    }
    asked = dict(region=sos.PoleRegion(sigma=0.2, rho=9)) | held.get(name, {})
    return maps.edge(name, CART, digits=1, **asked | options)


def across(x, y):
    """A frontier on which nothing else is asked."""
    cost = sos.QuadraticCost(np.eye(2), [[1]], bound=50.0)
    others = {
        "gamma": dict(gamma=2.0),
        "u_max": dict(saturation=sos.Saturation(9.0, [1, 0])),
        "cost": dict(requirements=[cost]),
    }
    asked = dict(region=sos.PoleRegion(sigma=0.2, rho=9))
    asked |= others.get(x, {}) | others.get(y, {})
    values = dict(sigma=0.3, theta=1.0, rho=8.0, gamma=1.5, u_max=8.0, cost=40.0)
    value = values.get(x, 1.0)
    return maps.frontier(
        x, y, CART, values=[value, 1.1 * value], digits=1, progress=False, **asked
    )


def late(function, plants, *given):
    def ask(plant):
        return lambda **o: function(plant, *given, tau=0.1, delta=0.01, **o)

    return [ask(plant) for plant in plants]


def TICKED(plant=CART):
    """A controller of the cart that reads it at 100 Hz."""
    return sos.analyse_pid(plant, [[-4, -4, -1]], [[1]]).controller(T=0.01)


@cache
def rounded(precision):
    free = TICKED(sos.SecondOrderSystem(1, 1, 0, 1, 1))  # rests anywhere
    return free.set_point(ramp=6).bounds.rounding(precision, range=9, speed=9)


BETWEEN = sos.Uncertain(  # soon singular at both ends
    lambda m: sos.SecondOrderSystem((m - 1) * (3 - m), 0.1, 2, 1, 1), m=(1.5, 2.5)
)

#: For each public function or class with options small calls that take them.
CALLS = {
    "design_pid": of_each_plant(sos.design_pid),
    "analyse_pid": [*of_each_plant(sos.analyse_pid, K), looped],
    "ObserverDesign.analyse": [observed],
    "design_lqr": of_each_plant(sos.design_lqr, np.eye(2), [[1]]),
    "compare": [lambda **o: polytopes.compare(PAIR, **completed(o))],
    "Search": [lambda prefer: sos.Search(prefer=prefer)],
    "verify_many": [lambda **o: polytopes.verify_many([PAIR], **completed(o))],
    "QuadraticCost": [noisy],
    "regularize": [lambda choose: sos.regularize(LIGHT, 0.1, choose=choose)],
    "edge": [edged],
    "frontier": [
        lambda x: across(x, "theta" if x == "sigma" else "sigma"),
        lambda y: across("theta" if y == "sigma" else "sigma", y),
    ],
    "design_delay_pid": late(sos.design_delay_pid, (CART, PAIR)),
    "analyse_delay": [
        *late(sos.analyse_delay, (CART, PAIR), K),
        *late(sos.analyse_delay, [DelayedLoop([[0.1]], [[-1]])]),
    ],
    "largest": [
        lambda name="delta", **o: sos.delay.largest(
            name,
            sos.Loop(CART, K),
            tau=0.1,
            delta=0.05 * (name != "delta"),
            digits=1,
            **o,
        )
    ],
    "slider": [lambda scale: slider("a", "A", "", (0.1, 1), 0.1, 1, scale)],
    "regulator": [lambda laws: regulator((1, 10), (10,), laws=laws)],
    "Program": [
        lambda precision: Program(FIRMWARE, "b", precision, steering=STEERING).law
    ],
    "Compiled": [lambda precision: Compiled(FIRMWARE, precision)],
    "motion_with_play": [
        lambda **o: motion_with_play(200, 30, 0, [1.0] * 9, 0.01, 0.1, 0.02, 0.5, **o)
    ],
    "sensing": [lambda kind: sensing(kind, 0.01)],
    "SampledLoop": [
        lambda sensing: SampledLoop(
            pendulum.Mip.printed(), FIRMWARE.law, sensing=sensing
        )
    ],
    "lowest_rate": [
        lambda sensing: lowest_rate(
            [pendulum.Mip.printed()],
            lambda T: pendulum.SampledLaw.of_gain(thesis.mip().gains["PD"][1], T),
            sensing=sensing,
            rates=(200, 100),
        )
    ],
    "check_recording": [
        lambda experiment: check_recording(
            DATA / ("wheels.csv" if experiment == "wheels" else "body.csv"),
            ROBOT,
            experiment,
        )
    ],
    "shipped": [shipped],
    "Robot": [lambda **o: ROBOT.but(**o), lambda **o: GEARMOTORS.but(**o)],
    "Gains.controller": [
        lambda memory: sos.analyse_pid(CART, K).controller(
            ["z1"],
            T=0.01,
            memory=memory,
            filter_time=0.05 * (memory == "filter") or None,
        )
    ],
    "OutputBounds.rounding": [rounded],
    "Controller.to_c": [lambda precision: TICKED().to_c("axis", precision)],
    "Profile.to_c": [
        lambda precision: Profile(2.0, 8.0, 64.0, 0.01, "rad").to_c("arm", precision)
    ],
    "Questions.furthest": [lambda find: TICKED().furthest(find, tolerance=0.5)],
    "Code": [lambda precision: Code(TICKED(), "axis", precision)],
    "CompiledCode": [lambda precision: CompiledCode(TICKED(), precision=precision)],
    "furthest_sampled": [
        lambda find: sos.furthest_sampled(
            CART,
            K,
            T=(0.01, 0.1) if find == "T" else 0.1,
            delay=(0.0, 0.05) if find == "delay" else 0.0,
            find=find,
            tolerance=0.5,
            norm=sos.HInfinity(90.0) if find == "norm" else None,
        )
    ],
    "farthest": [
        lambda **o: maps.farthest(
            BETWEEN, "m", digits=1, region=sos.PoleRegion(0.1, rho=20), **completed(o)
        ),
        lambda coupling: maps.farthest(
            BETWEEN, "m", [[-3, -2]], digits=1, coupling=coupling
        ),
    ],
    "designs": [lambda **o: maps.designs(CART, [completed(o)], progress=False)],
}

#: What several requests in one don't take, with the words of their refusal.
REFUSED = dict.fromkeys(
    ((name, "maximize", "sigma") for name in ("compare", "farthest")),
    ("a law's loop", "position has 1"),
)

#: What documents a set and isn't called with one, or not by a reader.
NO_CALLS = {
    "status": "a result's own verdict",
    "verdict": "a result's own verdict",
    "Finding": "made by the checks of a log",
    "Recording": "made by check_recording",
    "OptimalLaw": "made by optimal_law",
    "Parameter": "a word of the vocabulary",
    "Largest": "made by largest",
    "Request": "made by the design functions",
    "designed": "called by design_pid",
    "design_asked": "called by design_pid and its like",
    "or_with_slack": "called by design_pid",
    "Ask": "made by the functions of maps",
    "theorems": "blocks: whoever writes them gives every value in its own tests",
}


def values_of(text):
    """The set in a type's text, such as ``sequence of {"pairs", "slack"}``, or ()."""
    found = re.search(r"\{([^}:]*)\}", text)
    return tuple(ast.literal_eval(f"({found[1]},)")) if found else ()


def literals(annotation):
    """The values of each ``Literal`` in an annotation."""
    if typing.get_origin(annotation) is typing.Literal:
        return typing.get_args(annotation)
    return sum((literals(part) for part in typing.get_args(annotation)), ())


def annotations(thing):
    call = thing.__init__ if inspect.isclass(thing) else function_of(thing)
    try:
        return typing.get_type_hints(call)
    except (NameError, AttributeError):  # of type checkers only, or a class of C
        known = getattr(call, "__annotations__", {})
        return {name: hint for name, hint in known.items() if not isinstance(hint, str)}


@cache
def options(full):
    """By an option's name its documented values, and whether it takes several."""
    thing, found = public()[full], {}
    hints = annotations(thing)
    for p in FunctionDoc(None, doc=inspect.getdoc(thing) or "")["Parameters"]:
        words = " ".join(p.desc)
        elsewhere = {}
        for other in map(home, re.findall(r"(?:As in|of|for) `(\w+)`", words)):
            if other and other != full:
                elsewhere |= options(other)
        for name in p.name.split(", "):
            values = values_of(p.type) or literals(hints.get(name))
            if values:
                several = re.match(r"(sequence|collection) of", p.type)
                found[name] = values, bool(several)
            elif name in elsewhere:
                found[name] = elsewhere[name]
        if p.name.startswith("**"):
            everything = words.startswith("Keywords of")
            for name in elsewhere:  # in the order of the docstring
                new = name not in found and f"{name}s" not in found
                if new and (everything or name in words):
                    found[name] = elsewhere[name]
        elif "Keywords of" in words:  # dicts of them
            found |= elsewhere
    return found


@cache
def home(name):
    """The full name of a public function, or None."""
    names = [full for full in public() if full.rpartition(".")[2] == name]
    return names[0] if len(names) == 1 else None


@cache
def documented():
    """Options by the short name of what takes them."""
    found = {}
    for full, thing in public().items():
        if isinstance(thing, property):
            continue
        known = {n: v for n, v in options(full).items() if n not in NO_CALLS}
        owner, _, name = full.rpartition(".")
        if not known or hasattr(sos.theorems, name) or name in NO_CALLS:
            continue
        if owner in public():
            name = f"{owner.rpartition('.')[2]}.{name}"
        found[name] = known
    return found


MARKS = {
    "Compiled, precision='double'": pytest.mark.compiler,
    "Compiled, precision='single'": pytest.mark.compiler,
} | dict.fromkeys(
    [  # as design_pid, edge, Code or other tests' requests take them in the gate, too
        "analyse_pid, minimize='gamma'",
        "analyse_pid, minimize='u_max'",
        "compare, maximize='sigma'",
        "compare, minimize='cost'",
        "compare, minimize='gamma'",
        "design_pid, minimize='gamma'",
        "designs, maximize='sigma'",
        "designs, minimize='gamma'",
        "frontier, x='sigma'",
        "frontier, x='theta'",
        "frontier, x='u_max'",
        "frontier, y='cost'",
        "frontier, y='gamma'",
        "frontier, y='rho'",
        "Controller.to_c, precision='double'",
        "Code, precision='single'",
        "ObserverDesign.analyse, minimize='u_max'",
        "ObserverDesign.analyse, minimize='gamma'",
        "check_recording, experiment='wheels'",
        "compare, minimize='u_max'",
        "CompiledCode, precision='double'",
        "design_lqr, coupling='slack'",
        "design_pid, minimize='cost'",
        "frontier, x='cost'",
        "frontier, y='sigma'",
        "largest, method='shift'",
        "largest, name='mu'",
        "regulator, laws='PD'",
    ],
    pytest.mark.campaign,
)


def cases():
    return [
        pytest.param(
            name,
            option,
            (value,) if several else value,
            id=f"{name}, {option}={value!r}",
            marks=MARKS.get(f"{name}, {option}={value!r}", ()),
        )
        for name, known in documented().items()
        for option, (values, several) in known.items()
        for value in values
    ]


def answered(call, words, **given):
    """Whether there is an answer; else a ValueError of ours has one of the words."""
    try:
        call(**given)
    except ValueError as error:
        *_, last = traceback.extract_tb(error.__traceback__)
        assert "sosbook" in last.filename, f"{last.filename}: {error}"
        assert any(word in str(error) for word in words), error
        return False
    return True


def test_every_option_has_a_call():
    assert documented().keys() == CALLS.keys()
    for name in ("design_pid", "analyse_pid", "ObserverDesign.analyse"):
        known = documented()[name]
        given = ("auto",) if name == "design_pid" else ("auto", "multipliers")
        assert set(known["coupling"][0]) == {*given, "pairs", "vertices", "slack"}
        assert "minimize" in known


@pytest.mark.parametrize("name, option, value", cases())
def test_a_documented_value_is_taken(name, option, value, plt_closed):
    takers = [call for call in CALLS[name] if takes(call, option)]
    assert takers
    refused = REFUSED.get((name, option, value), ())
    words = (option, str(value), *refused)
    good = [answered(call, words, **{option: value}) for call in takers]
    assert any(good) != bool(refused), "documented, and refused everywhere"


def takes(call, option):
    known = inspect.signature(call).parameters
    return option in known or any(p.kind is p.VAR_KEYWORD for p in known.values())


@pytest.fixture
def plt_closed():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")


REQUESTS = ("analyse_pid", *campaign(["design_pid", "ObserverDesign.analyse"]))


@pytest.mark.parametrize("colour", [0, *campaign([1])])
@pytest.mark.parametrize("name", REQUESTS)
def test_options_of_a_request_go_together(name, colour):
    """Each with each, on the way that all of them take, whoever asks; the gate takes
    the pairs on fields of one colour of the chessboard of both.
    """
    known = {option: values for option, (values, _) in documented()[name].items()}
    couplings = *known["coupling"], ("slack", 0.5)
    goals = enumerate(known["minimize"])
    for (i, coupling), (j, least) in product(enumerate(couplings), goals):
        if (i + j) % 2 != colour:
            continue
        for mu in (None, 1.0) if least == "gamma" else (None,):
            asked = dict(coupling=coupling, minimize=least)
            if mu is not None:
                asked["gamma"] = sos.HInfinity(mu=mu)
            assert answered(CALLS[name][0], (), **asked), asked


def test_all_requests_have_the_same_words():
    """What is asked of a design can be asked of a gain and of a loop."""
    of = {name: set(inspect.signature(f).parameters) for name, f in DOORS.items()}
    design = of["design_pid"] - {"maximize"}  # of a law's gain
    assert of["analyse_pid"] == design | {"K"}
    least = {"minimize", "K_A"}  # the cost; what `regularize` returns brings K_A
    assert of["design_lqr"] == (design - least) | {"Q", "R", "noise"}
    assert of["observer"] == {"self", "asked"}  # those of analyse_pid


DOORS = {
    "design_pid": sos.design_pid,
    "analyse_pid": sos.analyse_pid,
    "design_lqr": sos.design_lqr,
    "observer": sos.ObserverDesign.analyse,
}


@pytest.mark.parametrize("name", documented())
def test_another_value_is_named(name):
    """A word that isn't in the set is refused by a ValueError that says so."""
    for option, (values, several) in documented()[name].items():
        if not all(isinstance(v, str) for v in values):
            continue
        wrong = ("no such word",) if several else "no such word"
        for call in CALLS[name]:
            if takes(call, option):
                words = (option, option.rstrip("s"), "no such word")
                assert not answered(call, words, **{option: wrong}), (name, option)
