"""The ledger of the paper's claims: each verdict as it is kept, and none that our numbers could not change."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from renew_claims import PAGE, SWEEPS, kept, page
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import spanwise_spacing_rule
from upwash.batch.store import encode, provenance
from upwash.cli import main
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.jobs.pair import Pair
from upwash.paper import (
    CLAIM_COLUMNS,
    CLAIMS,
    FAILS,
    HOLDS,
    HOLDS_WITH_CONDITION,
    NOT_RUN,
    Claim,
    Evidence,
    gather_evidence,
    judge,
    judge_claims,
    of_limit,
    of_optimum,
    of_print,
    of_search,
)
from upwash.paper.claim import (
    LIMIT_VERDICTS,
    MEANINGLESS,
    NOT_JUDGED,
    PAPER_ALONE,
    VERDICTS,
    at_least,
    at_most,
    between,
    near,
)
from upwash.paper.evidence import FLOCKS, LIMIT, OBJECTIVES, PAPER_BIRD, READINGS, SPEEDS
from upwash.paper.ledger import in_limit
from upwash.paper.of_limit import MEASURES as OWN_IN_LIMIT
from upwash.report.claims import ledger_markdown, ledger_text
from upwash.study.sources import read_study

BY_NAME = {claim.name: claim for claim in CLAIMS}
TEXTS = [column.name for column in CLAIM_COLUMNS if column.type == "text"]

# How a run of SciPy's solver ends depends on its version; the verdict must not.
OF_THE_SOLVER = {"robust-to-starts", "printed-start"}


@pytest.fixture(scope="module")
def frames(paper_redone):
    """Rows of the sweeps that claims are judged by, solved anew."""
    folder, finished = paper_redone
    assert finished.returncode == 0, finished.stderr
    return {sweep: read_study(folder / "results" / sweep).rows for sweep in SWEEPS}


@pytest.fixture(scope="module")
def evidence(frames):
    return gather_evidence(frames.values())


@pytest.fixture(scope="module")
def ledger(evidence):
    return judge_claims(evidence).set_index("claim_id", drop=False)


def numbers_in(text):
    return [float(one) for one in re.findall(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", text)]


def words_of(text):
    return re.sub(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", "#", text)


class TestKeptLedger:
    """results/reference/claims.csv and docs/claims.md; `make reference` renews both."""

    def test_every_claim_is_judged_as_kept(self, ledger):
        before = kept().set_index("claim_id")
        assert list(ledger.index) == list(before.index)
        changed = {
            name: f"{before.loc[name, column]} -> {ledger.loc[name, column]}"
            for name in ledger.index
            for column in ("verdict", "exceptions", "limit_verdict", "limit_exceptions")
            if ledger.loc[name, column] != before.loc[name, column]
        }
        assert changed == {}, "announce it: make reference, and say in CHANGELOG.md what moved"

    def test_our_values_are_the_kept_ones(self, ledger):
        before = kept().set_index("claim_id")
        for name in set(ledger.index) - OF_THE_SOLVER:
            assert ledger.loc[name, "ours"] == pytest.approx(before.loc[name, "ours"], rel=1e-3, abs=1e-6), (
                name
            )

    @pytest.mark.parametrize("column", TEXTS)
    def test_its_words_are_the_kept_ones(self, ledger, column):
        before = kept().set_index("claim_id", drop=False)
        for name in set(ledger.index) - OF_THE_SOLVER:
            now, then = ledger.loc[name, column], before.loc[name, column]
            assert words_of(now) == words_of(then)
            # The last digit written may be rounded the other way on another machine.
            assert numbers_in(now) == pytest.approx(numbers_in(then), rel=5e-2, abs=2e-3), name

    def test_the_page_shows_what_is_kept(self):
        assert PAGE.read_text(encoding="utf-8") == page()

    def test_it_is_whole(self, ledger):
        assert len(ledger) >= 30
        assert ledger.index.is_unique
        assert set(ledger["verdict"]) <= set(VERDICTS) - {NOT_RUN}
        for column in ("place", "claim", "printed", "cases", "why"):
            assert ledger[column].str.len().min() > 0, column
        assert not ledger["why"].str.contains("[{}\n]").any()


class TestVerdict:
    """A claim holds in every case, in some, or in none."""

    @pytest.fixture
    def verdict_on(self):
        def verdict(cases, accepted=None):
            claim = Claim(
                "name", "topic", "place", "says", "1", "", accepted or near(1.0, 0.1), lambda _: cases, "why"
            )
            return judge(claim, Evidence(pd.DataFrame([{"x": 1}])))

        return verdict

    @pytest.mark.parametrize(
        ("cases", "verdict", "exceptions"),
        [
            ({"a": 1.05, "b": 0.95}, HOLDS, ()),
            ({"a": 1.05, "b": 1.2}, HOLDS_WITH_CONDITION, ("b",)),
            ({"a": 1.2, "b": 0.8}, FAILS, ("a", "b")),
            ({"a": math.nan}, FAILS, ("a",)),
        ],
    )
    def test_follows_from_the_cases(self, verdict_on, cases, verdict, exceptions):
        judged = verdict_on(cases)
        assert (judged.verdict, judged.exceptions) == (verdict, exceptions)

    @pytest.mark.parametrize(
        ("accepted", "inside", "outside"),
        [
            (near(10.0, 0.5), (9.5, 10.5), (9.49, 10.51)),
            (between(8.0, 9.0, 1.0), (7.0, 8.5, 10.0), (6.9, 10.1)),
            (at_most(0.0), (0.0, -1e300), (1e-12,)),
            (at_least(0.5), (0.5, 1e300), (0.499,)),
        ],
    )
    def test_limits_belong_to_what_is_accepted(self, accepted, inside, outside):
        assert all(map(accepted.holds, inside))
        assert not any(map(accepted.holds, outside))
        assert not accepted.holds(math.inf)

    def test_why_names_our_values_and_other_facts(self):
        claim = Claim(
            "name",
            "",
            "",
            "",
            "",
            "",
            near(1, 1),
            lambda _: {"a, b": 0.5},
            "{a, b:.1f} of {all:g}",
            facts=lambda _: {"all": 7},
        )
        assert judge(claim, Evidence(pd.DataFrame([{"x": 1}]))).why == "0.5 of 7"


def changed_pair(evidence, change, objectives=OBJECTIVES, label="is_v_optimum"):
    """Return the evidence with columns of some of the pair's optima changed, each by a function of its value."""
    pair = evidence.pair.copy()
    rows = pair["objective"].isin(objectives) & (pair[label].eq(True) if label else True)
    for name, of in change.items():
        pair.loc[rows, name] = [of(value) for value in pair.loc[rows, name]]
    return replace(evidence, pair=pair)


def plus(amount):
    return lambda value: value + amount


def times(factor):
    return lambda value: value * factor


def always(constant):
    return lambda _: constant


def changed_flocks(evidence, change):
    """Return the evidence with each flock changed by a function of its frame."""
    return replace(evidence, flocks={key: change(flock.copy()) for key, flock in evidence.flocks.items()})


def set_birds(**columns):
    """Return a function that sets columns of a flock to six values, one a bird."""

    def change(flock):
        for name, values in columns.items():
            flock[name] = values
        return flock

    return change


def slower_alone(speeds):
    """Return speeds at which the lone bird's power falls towards the slowest, the follower's towards the fastest."""
    fastest = speeds["speed_m_s"].max()
    return speeds.assign(
        leader_power_total_w=speeds["speed_m_s"] ** 2,
        power_total_w=speeds["speed_m_s"] * (2 * fastest - speeds["speed_m_s"]) ** 2,
    )


# What is done to our numbers -> the claims that must be judged otherwise for it.
MUTATIONS = {
    "half a metre further": (
        lambda e: changed_pair(e, {"x_m": plus(0.5)}),
        {"table-1-x", "x-half-wavelength", "path-coherence", "observed-x", "unlike-states-thrust"}
        | {"optimum-upstream-of-the-change"},
    ),
    "a core radius further aside": (
        lambda e: changed_pair(e, {"y_m": plus(0.12)}),
        {"table-1-y", "spacing-rule", "spacing-rule-exceeded", "observed-y"},
    ),
    "the lowered wingtip on the downstroke's vortex": (
        lambda e: changed_pair(e, {"y_m": plus(0.22)}),
        {"wingtips-outside-filament"},
    ),
    "half an amplitude lower": (
        lambda e: changed_pair(e, {"z_m": plus(-0.5)}),
        {"table-1-z", "table-1-z-ratio", "observed-z", "thrust-changes-sign"},
    ),
    "another stroke": (
        lambda e: changed_pair(e, {"amplitude_m": times(1.2), "upstroke_span_ratio": times(1.14)}),
        {
            "table-1-h",
            "table-1-h-ratio",
            "table-1-R",
            "table-1-R-ratio",
            "amplitude-reduction",
            "span-ratio-reduction",
        },
    ),
    "more flexion than amplitude": (
        lambda e: changed_pair(e, {"amplitude_m": always(1.0), "upstroke_span_ratio": always(0.3)}),
        {"amplitude-before-flexion"},
    ),
    "less flexion": (
        lambda e: changed_pair(e, {"upstroke_span_ratio": always(0.45)}),
        {"flexion-reduced"},
    ),
    "out of antiphase": (
        lambda e: changed_pair(e, {"phase": always(0.4)}),
        {"table-1-phase", "antiphase", "like-states-weightless"},
    ),
    "less own force": (
        lambda e: changed_pair(e, {"lift_self_n": times(0.9), "thrust_self_n": times(0.9)}),
        {"table-1-lift", "table-1-lift-ratio", "table-1-thrust"},
    ),
    "a little more own thrust": (
        lambda e: changed_pair(e, {"thrust_self_n": times(1.02)}),
        {"table-1-thrust-ratio"},
    ),
    "other powers": (
        lambda e: changed_pair(e, {"leader_power_total_w": plus(2.0), "power_total_w": plus(1.0)}),
        {"leader-power", "follower-power"},
    ),
    "other savings": (
        lambda e: changed_pair(
            e,
            {"saving_total": plus(-0.2), "saving_induced": plus(-0.2), "saving_profile": plus(-0.3)},
        ),
        {"saving-total", "saving-induced", "saving-profile", "saving-as-observed", "both-powers-fall"},
    ),
    "no profile power saved": (
        lambda e: changed_pair(e, {"power_profile_w": plus(10.0)}),
        {"profile-dominates"},
    ),
    "the two costs alike": (
        lambda e: changed_pair(
            e,
            {
                name: always(e.v("force")[name])
                for name in ("x_m", "y_m", "z_m", "amplitude_m", "upstroke_span_ratio")
            }
            | {
                name: always(e.v("force")[name])
                for name in ("saving_total", "saving_induced", "saving_profile")
            },
            ["power"],
        ),
        {
            "objectives-alike-position",
            "objectives-alike-stroke",
            "objectives-alike-saving",
            "like-states-drag",
        },
    ),
    "a wake that presses and drags": (
        lambda e: changed_pair(e, {"lift_wake_n": always(-0.1), "thrust_wake_n": always(-0.1)}),
        {"lift-and-thrust-assisted", "downstroke-wake-dominates"},
    ),
    "the best of all": (
        lambda e: changed_pair(e, {"cost": times(0.9)}),
        {"minimum-is-global"},
    ),
    "on a bound": (
        lambda e: changed_pair(e, {"active_bounds": always("y_upper,mu_lower")}),
        {"robust-to-bounds"},
    ),
    "out of balance": (
        lambda e: changed_pair(e, {"residual_lift": always(1e-4)}),
        {"balance-at-the-optimum"},
    ),
    "a lower proof": (
        lambda e: changed_pair(e, {"v_lower_bound": times(0.99)}),
        {"print-attainable"},
    ),
    "an uneven flock": (
        lambda e: changed_flocks(
            e,
            set_birds(
                x_m=[np.nan, 1, 2, 1, 2, 1], phase=[np.nan, 0.5, 0.4, 0.5, 0.5, 0.5], z_m=[np.nan, *[0.1] * 5]
            ),
        ),
        {"flock-regular", "flock-antiphase", "flock-height"},
    ),
    "a flock whose benefit decays": (
        lambda e: changed_flocks(
            e,
            set_birds(
                saving_total=[0.0, 0.15, 0.12, 0.09, 0.06, 0.03],
                power_total_w=[60.0, 51.0, 52.8, 54.6, 56.4, 58.2],
                cost=[60.0, 51.0, 52.8, 54.6, 56.4, 58.2],
                amplitude_m=[1.0, 0.9, 0.8, 0.7, 0.6, 0.5],
            ),
        ),
        {
            "flock-second-is-best-by-cost",
            "flock-second-is-best-by-power",
            "flock-substantial",
            "flock-no-decay",
        }
        | {"flock-saturates", "amplitude-bound"},
    ),
    "a faster group": (
        lambda e: replace(e, speeds=slower_alone(e.speeds)),
        {"group-speed-of-least-power", "group-speed-of-least-energy"},
    ),
}

# Another bird with the same optima: what is computed from the bird itself moves.
ANOTHER_BIRD = {"mass_kg": 1.5, "leader_amplitude_m": 0.9}
OF_THE_BIRD = {
    "table-1-weight",
    "table-1-drag",
    "table-1-leader-h",
    "table-1-leader-z",
    "print-forces",
    "print-savings",
}

# What a mutation of its own, below, is for.
BY_THEMSELVES = {
    "circulation-scaling",
    "product-of-R-and-circulation",
    "cost-against-amplitude",
    "passive-upstroke",
    "spacing-rule-elsewhere",
}
BY_THEMSELVES |= {"print-y", "print-balance", *OF_THE_SOLVER}
OF_THE_MAPS = {"thrust-map-minimum", "lift-map-minimum", "thrust-varies-more", "benefits-do-not-coincide"}
OF_THE_MAPS |= {"optimum-in-the-overlap", "favourable-band"}
OF_THE_MAPS |= {"strong-benefit-is-rare", "behind-the-leader", "lift-above-and-below", "lift-changes-sign"}


def outcome(name, evidence):
    judged = judge(BY_NAME[name], evidence)
    return judged.verdict, judged.exceptions


class TestMutations:
    """A verdict follows from our numbers: other numbers, another verdict."""

    @pytest.mark.parametrize("mutation", MUTATIONS)
    def test_changes_what_is_said_of_it(self, evidence, mutation):
        change, names = MUTATIONS[mutation]
        changed = change(evidence)
        unmoved = {name for name in names if outcome(name, changed) == outcome(name, evidence)}
        assert unmoved == set()

    @pytest.mark.parametrize("name", sorted(OF_THE_BIRD))
    def test_another_bird(self, evidence, name):
        changed = changed_pair(
            evidence, {key: always(value) for key, value in ANOTHER_BIRD.items()}, label=None
        )
        assert outcome(name, changed) != outcome(name, evidence)

    def test_no_claim_is_deaf(self):
        heard = set().union(
            *(names for _, names in MUTATIONS.values()), OF_THE_BIRD, BY_THEMSELVES, OF_THE_MAPS
        )
        assert set(BY_NAME) == heard

    @pytest.mark.parametrize("name", sorted(OF_THE_MAPS - {"lift-changes-sign"}))
    def test_a_wake_that_lifts_and_pulls_everywhere(self, evidence, monkeypatch, name):
        original = Evidence.wake_over

        def generous(self, *arguments, **place):
            lift, thrust = original(self, *arguments, **place)
            return 10.0 + lift, 10.0 + 0.1 * thrust

        before = outcome(name, evidence)
        monkeypatch.setattr(Evidence, "wake_over", generous)
        # A copy has no maps yet.
        assert outcome(name, replace(evidence)) != before

    def test_a_wake_that_lifts_above_the_leader_alone(self, evidence, monkeypatch):
        def split(self, objective, plane, x_m, across, **place):
            return np.asarray(across)[:, None], np.zeros((len(across), 1))

        monkeypatch.setattr(Evidence, "wake_over", split)
        assert outcome("lift-changes-sign", evidence) == (HOLDS, ())

    @pytest.mark.parametrize(
        "name", ["circulation-scaling", "passive-upstroke", "product-of-R-and-circulation"]
    )
    def test_another_law_of_circulation(self, evidence, monkeypatch, name):
        law = property(lambda bird: bird.mass_kg**2 / bird.upstroke_span_ratio**3)
        monkeypatch.setattr(Bird, "circulation_m2_s", law)
        monkeypatch.setattr(Bird, "lift_span", lambda bird, ratio: 1.0 + (ratio > 0.0))
        assert outcome(name, evidence) != (HOLDS, ())
        if name == "product-of-R-and-circulation":
            assert "lone bird" in outcome(name, evidence)[1]

    def test_a_cost_that_falls_with_amplitude(self, evidence, monkeypatch):
        monkeypatch.setattr(Bird, "thrust_n", lambda bird, amplitude, ratio: 3.0 - amplitude)
        assert outcome("cost-against-amplitude", evidence) == (HOLDS, ())

    def test_birds_that_keep_the_rule_behind_other_leaders(self, evidence, monkeypatch):
        def at_the_rule(bird, objective, model):
            row = evidence.v(objective)
            stroke = Stroke(row["amplitude_m"], row["upstroke_span_ratio"])
            y = spanwise_spacing_rule(bird.semispan_m, stroke.span_ratio)
            return Pose(row["x_m"], y, row["z_m"], stroke, row["phase"])

        monkeypatch.setattr(of_optimum, "_v_of", at_the_rule)
        assert outcome("spacing-rule-elsewhere", evidence) == (HOLDS, ())

    def test_a_paper_that_prints_one_number(self, evidence, monkeypatch):
        monkeypatch.setitem(of_print._VARIOUS, "y", (0.882, 0.882, 0.882))
        assert outcome("print-y", evidence) == (HOLDS, ())

    def test_a_paper_that_prints_our_optimum(self, evidence, monkeypatch):
        ours = evidence.v("force")
        printed = {"x": ours["x_m"], "y": ours["y_m"], "z": of_print.HEIGHT_OF_LEADER_M + ours["z_m"]}
        printed |= {"h": ours["amplitude_m"], "R": ours["upstroke_span_ratio"], "phase": 0.5}
        for name, value in printed.items():
            monkeypatch.setitem(of_print._TABLE, name, value)
        assert outcome("print-balance", evidence) == outcome("print-attainable", evidence) == (HOLDS, ())

    def test_a_solver_that_always_gets_there(self, evidence, monkeypatch):
        def at_the_optimum(_, objective):
            row = evidence.v(objective)
            place = {name: [row[name]] * of_search.STARTS for name in ("x_m", "y_m", "z_m", "cost")}
            return pd.DataFrame(place), row["cost"]

        monkeypatch.setattr(of_search, "_ends", at_the_optimum)
        for name in OF_THE_SOLVER:
            assert outcome(name, evidence) == (HOLDS, ())


class TestLimit:
    """In the limit a claim is judged by the optima of the limit, and has a meaning only if what it is about exists."""

    def limit_outcome(self, name, evidence):
        judged = in_limit(BY_NAME[name], evidence)
        return judged.verdict, judged.exceptions

    @pytest.mark.parametrize(
        "name", [claim.name for claim in CLAIMS if claim.name not in OWN_IN_LIMIT and claim.needs == "pair"]
    )
    def test_the_papers_own_optima_in_its_place_give_the_papers_verdict(self, evidence, name):
        # Distance and states exist there, so that no claim is without a meaning.
        same = replace(evidence, limit=dict.fromkeys(evidence.limit, evidence.pair))
        expected = PAPER_ALONE if BY_NAME[name].about == "paper" else outcome(name, evidence)[0]
        assert self.limit_outcome(name, same)[0] == expected

    def test_what_has_no_meaning_is_what_is_about_distance_or_states(self, ledger):
        lacking = set(ledger.index[ledger["limit_verdict"] == MEANINGLESS])
        assert lacking == {claim.name for claim in CLAIMS if claim.about in ("distance", "states")}

    def test_every_verdict_is_one_of_those_named(self, ledger):
        assert set(ledger["limit_verdict"]) <= set(LIMIT_VERDICTS) - {NOT_RUN}
        assert not ledger["limit_why"].str.contains("[{}\n]").any()

    def test_flocks_and_airspeeds_are_not_judged(self, ledger):
        unjudged = set(ledger.index[ledger["limit_verdict"] == NOT_JUDGED])
        assert unjudged == {claim.name for claim in CLAIMS if claim.needs != "pair"}

    def test_least_force_without_a_v_optimum_is_a_missing_value_and_said(self, ledger):
        row = ledger.loc["saving-total"]
        assert row["limit_cases"].startswith("force -; power, stroke law ")
        assert "Least force has no V optimum" in row["limit_why"]

    def test_savings_are_told_for_both_span_laws(self, ledger):
        for name in ("saving-total", "saving-induced", "saving-profile"):
            for law in ("stroke", "tip"):
                assert f"power, {law} law" in ledger.loc[name, "limit_cases"]

    @pytest.mark.parametrize("spoil", ["one span law is missing", "one objective is missing", "other cores"])
    def test_without_all_of_it_nothing_is_judged(self, frames, spoil):
        limit = frames[LIMIT]
        if spoil == "one span law is missing":
            limit = limit[limit["span_law"] == "tip"]
        elif spoil == "one objective is missing":
            limit = limit[(limit["span_law"] == "tip") | (limit["objective"] == "power")]
        else:
            limit = limit.assign(core_radius_ratio=0.2)
        judged = in_limit(BY_NAME["saving-total"], gather_evidence([frames["reproduce"], limit]))
        assert (judged.verdict, judged.cases) == (NOT_RUN, {})
        assert LIMIT in judged.why

    @pytest.mark.parametrize(
        ("name", "change"),
        [
            ("downstroke-wake-dominates", {"phase": plus(0.5)}),
            ("passive-upstroke", {"leader_upstroke_span_ratio": always(1e-8)}),
            ("product-of-R-and-circulation", {"leader_upstroke_span_ratio": always(0.5)}),
            ("robust-to-starts", {"y_m": times(1.2)}),
            ("print-balance", {"leader_upstroke_span_ratio": always(0.3)}),
        ],
    )
    def test_other_optima_change_the_verdict(self, evidence, name, change):
        is_input = any(column.startswith(("leader_", "circulation")) for column in change)
        label = None if is_input else "is_v_optimum"
        changed = {
            law: changed_pair(Evidence(rows), change, label=label).pair
            for law, rows in evidence.limit.items()
        }
        before = self.limit_outcome(name, evidence)
        assert self.limit_outcome(name, replace(evidence, limit=changed)) != before

    def test_a_start_that_leads_to_the_v_optimum(self, evidence, monkeypatch):
        costs = {"power": evidence.in_limit["tip"].v("power")["cost"], "force": 1.0}
        before = self.limit_outcome("printed-start", evidence)
        monkeypatch.setattr(of_limit, "_ends", lambda bird, objective, model: ([], costs[objective]))
        assert self.limit_outcome("printed-start", evidence) != before


class TestEvidence:
    """Found by what was flown, not by where it is stored."""

    def test_the_papers_bird_is_the_librarys(self, frames):
        from upwash import load_species

        assert load_species("northern-bald-ibis").bird() == PAPER_BIRD

    def test_other_birds_are_passed_over(self, frames, evidence):
        rows = frames["reproduce"]
        others = rows.assign(mass_kg=2.0, cost=1.0, job_id="other")
        found = gather_evidence([pd.concat([others, rows])])
        assert len(found.pair) == len(evidence.pair)

    def test_a_job_in_two_folders_counts_once(self, frames, evidence):
        twice = gather_evidence([*frames.values(), *frames.values()])
        assert len(twice.pair) == len(evidence.pair)
        assert len(twice.speeds) == len(evidence.speeds)

    @pytest.mark.parametrize("objective", OBJECTIVES)
    def test_without_one_of_the_two_costs_there_is_no_judging(self, frames, objective):
        rows = frames["reproduce"]
        with pytest.raises(UpwashError, match=f"least {objective}, found none"):
            gather_evidence([rows[rows["objective"] != objective]])

    def test_nothing_at_all_is_said_so(self):
        with pytest.raises(UpwashError, match="expected the V optimum of the paper's pair"):
            gather_evidence([])

    @pytest.mark.parametrize("spoil", ["a reading is missing", "a bird has no place", "another shape"])
    def test_flocks_are_all_there_or_not_used(self, frames, spoil):
        flocks = frames[FLOCKS].copy()
        if spoil == "a reading is missing":
            flocks = flocks[flocks["reading"] != READINGS[1]]
        elif spoil == "a bird has no place":
            flocks.loc[flocks["bird"] == 6, "status"] = "infeasible"
        else:
            flocks["shape"] = "vee"
        found = gather_evidence([frames["reproduce"], flocks])
        judged = judge(BY_NAME["flock-regular"], found)
        assert (judged.verdict, judged.cases) == (NOT_RUN, {})
        assert FLOCKS in judged.why

    def test_few_airspeeds_tell_nothing(self, frames):
        speeds = frames[SPEEDS]
        few = sorted(speeds["speed_m_s"].unique())[:3]
        found = gather_evidence([frames["reproduce"], speeds[speeds["speed_m_s"].isin(few)]])
        assert judge(BY_NAME["group-speed-of-least-power"], found).verdict == NOT_RUN


@pytest.fixture
def results(frames, tmp_path):
    """A gathered results folder of the pair, with nothing beside it."""
    return store(frames["reproduce"], Pair, tmp_path / "results" / "reproduce")


def store(rows, kind, folder):
    folder.mkdir(parents=True)
    records = rows.astype(object).where(rows.notna(), None).to_dict("records")
    (folder / kind.file).write_bytes(encode(records, kind.rows, provenance("text of the sweep")))
    return folder


def run(*arguments):
    return CliRunner().invoke(main, ["claims", *map(str, arguments)], prog_name="upwash")


class TestCommand:
    @pytest.fixture(scope="class")
    @classmethod
    def told(cls, frames, tmp_path_factory):
        """The folder of a pair with nothing beside it, and what was told of it, as text and as JSON."""
        folder = store(frames["reproduce"], Pair, tmp_path_factory.mktemp("claims") / "reproduce")
        text, as_json = run(folder), run(folder, "--json")
        assert (text.exit_code, as_json.exit_code) == (0, 0), text.output
        return folder, text.stdout, pd.DataFrame(json.loads(as_json.stdout, parse_constant=pytest.fail))

    def test_prints_the_ledger_and_keeps_it(self, told):
        folder, text, _ = told
        assert f"{len(CLAIMS)} claims: " in text
        assert all(name in text for name in BY_NAME)
        table = pq.read_table(folder / "claims.parquet")
        assert table.column("claim_id").to_pylist() == list(BY_NAME)
        assert "code_version" in {key.decode() for key in table.schema.metadata}

    def test_what_it_keeps_says_what_it_is(self, told):
        schema = pq.read_schema(told[0] / "claims.parquet")
        assert schema.names == [column.name for column in CLAIM_COLUMNS]
        for field in schema:
            assert field.metadata[b"description"]
            assert b"unit" in field.metadata
        assert schema.field("ours").type == pa.float64()

    def test_without_flocks_and_airspeeds_those_claims_are_not_run(self, told):
        found = told[2]
        assert set(found.loc[found["verdict"] == NOT_RUN, "claim_id"]) == {
            claim.name for claim in CLAIMS if claim.needs != "pair"
        }
        assert found.loc[found["verdict"] == NOT_RUN, "ours"].isna().all()

    def test_folders_beside_it_are_read(self, results, frames, ledger):
        store(frames[FLOCKS], Flock, results.parent / FLOCKS)
        store(frames[SPEEDS], Pair, results.parent / SPEEDS)
        found = pd.DataFrame(json.loads(run(results, "--json").stdout))
        assert found["verdict"].tolist() == ledger["verdict"].tolist()

    @pytest.mark.parametrize("what", ["no folder", "no results", "another bird"])
    def test_a_mistake_is_one_line_and_exit_2(self, frames, tmp_path, what):
        folder = tmp_path / "other"
        if what == "no results":
            folder.mkdir()
        elif what == "another bird":
            store(frames["reproduce"].assign(mass_kg=2.0), Pair, folder)
        result = run(folder)
        assert (result.exit_code, result.stdout) == (2, "")
        assert len(result.stderr.splitlines()) == 1
        assert str(folder) in result.stderr
        assert not (folder / "claims.parquet").exists()


class TestWriting:
    def test_text_explains_what_does_not_simply_hold(self, ledger):
        lines = ledger_text(ledger).splitlines()
        for row in ledger.itertuples():
            explained = [line for line in lines if line.startswith(f"{row.claim_id}: ")]
            assert len(explained) == (row.verdict != HOLDS)
            for line in explained:
                assert line.endswith(row.why)
                assert (f"(not so: {row.exceptions})" in line) == (row.verdict == HOLDS_WITH_CONDITION)

    def test_markdown_has_a_line_for_every_claim(self, ledger):
        lines = ledger_markdown(ledger).splitlines()
        for row in ledger.itertuples():
            cells = row.claim.replace("|", r"\|")
            assert sum(line.startswith(f"| {cells} ({row.place})") for line in lines) == 1, row.claim_id
