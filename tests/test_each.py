"""One item for many values: each that fails is named, and fixtures are given."""

import pytest

from tests.each import each


def test_each_value_that_fails_is_named_and_the_others_are_tried(tmp_path):
    tried = []

    @each("value, square", [(1, 1), (2, 5), (3, 9), (4, 0)])
    def test(tmp_path, value, square):
        """Squares."""
        tried.append(tmp_path)
        assert value**2 == square

    with pytest.raises(ExceptionGroup, match="2 of 4 values fail") as told:
        test(tmp_path=tmp_path)
    notes = [x.__notes__ for x in told.value.exceptions]
    assert notes == [["value = 2"], ["value = 4"]] and tried == [tmp_path] * 4
    assert (test.__name__, test.__doc__) == ("test", "Squares.")


@each("letter", "abc")
def test_fixtures_are_given(letter, tmp_path):
    (tmp_path / letter).write_text(letter, "utf-8")


def test_no_value_is_a_fault():
    with pytest.raises(ValueError, match="no value"):
        each("path", [])
