"""Rules of inputs: what holds, what they say, and that they say it whatever is put in."""

import doctest
import math

import numpy as np
import pytest
from upwash.aero import checked
from upwash.aero.bird import Bird
from upwash.aero.checked import (
    WrongInput,
    at_most,
    finite,
    fraction,
    one_of,
    positive,
    ratio,
    rules_of,
    whole_from,
    within,
)
from upwash.aero.wake import WakeModel

NO_NUMBERS = [math.nan, math.inf, -math.inf, True, False, None, "1", "", [1.0], {}, 1j]
EXACT_OR_COUNT = one_of(["exact"]) | whole_from(2)

# Rule -> what fits, and what does not beside what is no number at all.
RULES = {
    finite: ([0, -1.5, 1e300, np.float64(2.0), np.int64(2)], [10**400]),
    positive: ([5e-324, 1, np.float32(0.5)], [0, -0.0, -1, 10**400]),
    ratio: ([5e-324, 0.5], [0, 1, 1.5, -0.5]),
    fraction: ([0.5], [0.0, 1.0]),
    whole_from(2): ([2, 10**400, np.int64(3)], [1, -2, 2.0, 2.5]),
    whole_from(2, 9, "so"): ([2, 9], [1, 10, 10**400]),
    positive & at_most(2.0, "so"): ([2.0, 1e-300], [2.0000001, 0.0]),
    positive & within(1.0, 2.0, "so"): ([1.0, 2.0], [0.9999999, 2.0000001]),
    one_of(["a", "b"]): (["a", "b"], ["c", "A", " a"]),
    EXACT_OR_COUNT: (["exact", 2], ["exactly", 1, 2.5]),
}


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.words)
def test_a_rule_lets_in_what_fits_and_says_what_it_expected_of_all_else(rule):
    fitting, others = RULES[rule]
    for value in fitting:
        assert rule.broken_by(value) == ""
        assert rule("it", value) == value
    for value in [*others, *NO_NUMBERS]:
        with pytest.raises(WrongInput) as refused:
            rule("it", value)
        assert str(refused.value).startswith("it: expected ")
        assert refused.value.name == "it"
        assert refused.value.expected == rule.broken_by(value) != ""


def test_numbers_become_plain_ones():
    assert type(finite("it", np.float32(0.5))) is type(finite("it", 1)) is float
    assert type(whole_from(0)("it", np.int64(1))) is int


def test_the_first_rule_broken_is_the_one_that_is_named():
    rule = positive & at_most(2.0, "no egg is heavier")
    assert rule.broken_by(-1) == rule.broken_by("3") == "a positive, finite number"
    assert rule.broken_by(3) == "at most 2 (no egg is heavier)"


@pytest.mark.parametrize("kind", [Bird, WakeModel])
def test_every_input_of_the_physics_has_a_rule(kind):
    assert set(rules_of(kind)) == set(kind.__dataclass_fields__)


def test_what_the_module_shows_of_itself_is_so():
    assert doctest.testmod(checked).failed == 0
