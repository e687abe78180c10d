"""The three claims of a job: each follows from bounds, gaps, walls and the tolerance, and is said in a sentence."""

import math

import pytest
from upwash.optimum.problem import PairProblem
from upwash.optimum.proof import COST_ROUNDING, Claims, Proof, claims_in_words, claims_of, wall_in_words

PROVED_ROW = {
    "objective": "force",
    "tolerance": 1e-4,
    "certificate_boxes": 65724,
    "feasible": True,
    "v_wall": "",
    "v_lower_bound": 11.97,
    "v_region_certified_gap": 1e-4,
    "v_certified_gap": 1e-4,
    "global_lower_bound": 11.93,
    "global_certified_gap": 1e-4,
}
ON_WALL = {"v_wall": "y_lower", "v_certified_gap": 2e-3}
NO_V = {"v_lower_bound": None, "v_region_certified_gap": None, "v_certified_gap": None}
NONE_AT_ALL = {**NO_V, "global_lower_bound": None, "global_certified_gap": None, "feasible": False}
NOT_ASKED = {"global_lower_bound": None, "global_certified_gap": None}


@pytest.mark.parametrize(
    ("changes", "claims"),
    [
        ({}, Claims("proved", "proved", "proved")),
        ({"global_certified_gap": 1e-4 * (1 + 1e-7)}, Claims("proved", "proved", "proved")),
        ({"global_certified_gap": 1e-4 * (1 + 1e-5)}, Claims("proved", "proved", "open")),
        ({"v_certified_gap": 3e-4, "v_region_certified_gap": 3e-4}, Claims("open", "open", "proved")),
        (ON_WALL, Claims("proved", "open", "proved")),
        (ON_WALL | {"v_certified_gap": None}, Claims("proved", "not claimed", "proved")),
        (ON_WALL | {"v_certified_gap": 9e-5}, Claims("proved", "proved", "proved")),
        (NO_V, Claims("proved", "not claimed", "proved")),
        (NO_V | {"v_lower_bound": math.nan}, Claims("proved", "not claimed", "proved")),
        (NO_V | {"v_lower_bound": 11.0}, Claims("open", "not claimed", "proved")),
        (NONE_AT_ALL, Claims("proved", "not claimed", "proved")),
        (NONE_AT_ALL | {"global_lower_bound": 0.0}, Claims("proved", "not claimed", "open")),
        (NOT_ASKED, Claims("proved", "proved", "not claimed")),
        ({"certificate_boxes": None}, Claims("not claimed", "not claimed", "not claimed")),
    ],
)
def test_each_claim_has_its_own_word(changes, claims):
    assert claims_of(PROVED_ROW | changes) == claims


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_a_gap_is_known_to_the_rounding_of_a_cost(tolerance):
    row = PROVED_ROW | {"tolerance": tolerance, "v_certified_gap": tolerance + 0.9 * COST_ROUNDING}
    assert claims_of(row).v_optimum == "proved"
    assert claims_of(row | {"v_certified_gap": tolerance * 1.01 + 2.0 * COST_ROUNDING}).v_optimum == "open"


@pytest.mark.parametrize(
    ("changes", "number", "words"),
    [
        ({}, 0, "Proved: no V formation costs less than 11.97 N, and one is known that costs 0.01 % more."),
        ({}, 1, "Proved: the V optimum is the best of all local optima in the V, to 0.01 %."),
        (
            {},
            2,
            "Proved: no follower at all costs less than 11.93 N, and one is known that costs 0.01 % more.",
        ),
        (
            ON_WALL,
            1,
            "to its leader's side as still counts as outboard, one semispan, and better still beyond",
        ),
        (ON_WALL | {"v_certified_gap": None}, 1, "There is no V optimum to claim anything of"),
        (NO_V, 0, "Proved: no V formation can fly here, lift and thrust balance nowhere."),
        (NONE_AT_ALL, 2, "Proved: no follower at all can fly here, lift and thrust balance nowhere."),
        (NOT_ASKED, 2, "Nothing is claimed of what any follower costs at least."),
        (
            {"global_certified_gap": 0.02},
            2,
            "Open: no follower at all costs less than 11.93 N, but the best known",
        ),
    ],
)
def test_each_claim_is_said_in_a_sentence(changes, number, words):
    assert words in claims_in_words(PROVED_ROW | changes)[number]


def test_every_wall_of_the_v_region_has_words(ibis):
    problem = PairProblem(ibis)
    names = ("x", "y", "z", "h", "R", "mu")
    walls = [
        f"{name}_{side}"
        for name, own, whole in zip(names, problem.v_bounds(), problem.bounds, strict=True)
        for side, k in (("lower", 0), ("upper", 1))
        if own[k] != whole[k]
    ]
    assert set(walls) == {"x_lower", "y_lower", "z_lower", "z_upper"}
    assert wall_in_words(",".join(walls)).count(", and ") == 3


@pytest.mark.parametrize(("gap", "is_closed"), [(1e-4, True), (None, True), (2e-3, False)])
def test_a_proof_is_closed_if_nothing_claimed_is_open(gap, is_closed):
    proof = Proof(11.97, 1e-4, gap, 11.93, 1e-4, 100, "y_lower", True, 1e-4)
    assert proof.is_closed is is_closed
    assert "tolerance" not in proof.columns()
