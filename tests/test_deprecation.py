"""Former names warn and work; what never was a name doesn't."""

import importlib
import warnings

import pytest

from sosbook.deprecation import renamed, renamed_arguments, renamed_attribute

#: Module, former name, and where it is now.
MODULES = [
    ("sosbook.book.plots", "band", "envelope"),
    ("sosbook.book.plots", "branches", "track_poles"),
    ("sosbook.pendulum.rig", "COUNTS", "COUNTS_PER_TURN"),
    ("sosbook.pendulum.tuning", "DELAYS", "DELAY_SHARES"),
    ("sosbook.pendulum.tuning", "reach", "recoverable_tilt"),
    ("sosbook.plants.checks", "number", "finite"),
    ("sosbook.sampled", "hold", "c2d"),
    ("sosbook.sampled.discretize", "Clock", "SampleTiming"),
    ("sosbook.sampled.discretize", "hold", "c2d"),
    ("sosbook.studies.gamma_bounds", "Walls", "GammaLowerBounds"),
    ("sosbook.studies.gamma_bounds", "gamma_walls", "gamma_lower_bounds"),
    ("sosbook.studies.polytopes", "READINGS", "COUPLINGS"),
    ("sosbook.studies.polytopes", "inside", "sample_plants"),
    ("sosbook.studies.polytopes", "promises", "verify_on_samples"),
    ("sosbook.studies.polytopes", "survey", "verify_many"),
    ("sosbook.studies.polytopes", "widen", "scale_polytope"),
    ("sosbook.studies.region_of_attraction", "Basin", "RegionOfAttraction"),
    ("sosbook.studies.region_of_attraction", "basin", "region_of_attraction"),
]


def looked_up(module, path):
    for part in path.split("."):
        module = getattr(module, part)
    return module


@pytest.mark.parametrize("name, former, present", MODULES, ids=lambda x: str(x))
def test_a_former_name_of_a_module_warns_and_works(name, former, present):
    module = importlib.import_module(name)
    assert former not in vars(module)
    with pytest.warns(DeprecationWarning, match=f"{former} is now called {present}"):
        old = getattr(module, former)
    assert old is looked_up(module, present)


@pytest.mark.parametrize("name", sorted({name for name, *_ in MODULES}))
def test_a_name_that_never_was_is_an_error(name):
    with pytest.raises(AttributeError, match=f"module '{name}' has no attribute"):
        importlib.import_module(name).no_such_name


class Box:
    width = 3
    breadth = renamed_attribute("breadth", "width")


@renamed_arguments(breadth="width")
def area(width, height=1):
    return width * height


def test_a_former_attribute_warns_and_works():
    with pytest.warns(DeprecationWarning, match="Box.breadth is now called width"):
        assert Box().breadth == 3


def test_a_former_argument_warns_and_works():
    with pytest.warns(DeprecationWarning, match="area: the argument breadth is now"):
        assert area(breadth=2, height=5) == 10
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert area(2, height=5) == area(width=2, height=5) == 10
    with pytest.raises(TypeError, match="breadth is the former name of width"):
        area(width=1, breadth=2)


def test_the_warning_points_at_the_caller():
    former = renamed("math", root="sqrt")
    with pytest.warns(DeprecationWarning) as caught:
        assert former("root")(9) == 3
    assert caught[0].filename == __file__
