"""Every column of the results, declared once: meaning, agreement of two runs, how it is checked and how shown.

The order here is the order in the files. The files' schemas, the check, the comparison of two results folders and
the tables for people are all made from this list, so that a new column is a line here and a line where its value
is made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from math import inf
from typing import Any

SCHEMA_VERSION = 3
"""Raised by hand when a column is added, removed or given another meaning."""

OLDEST_READ = 2
"""The oldest version of the schema whose files are read; columns that came later are absent in them."""


@dataclass(frozen=True)
class Agreement:
    """How closely two runs of the same job must agree on a column.

    Parameters
    ----------
    relative, absolute : float
        Values a and b agree if ``|a − b| ≤ absolute + relative · max(|a|, |b|)``.
    compared : bool
        False for what differs between equal runs by nature.
    """

    relative: float = 0.0
    absolute: float = 0.0
    compared: bool = True

    def holds(self, a: float, b: float) -> bool:
        """Whether two numbers agree."""
        return abs(a - b) <= self.absolute + self.relative * max(abs(a), abs(b))


# Runs on one machine agree to the last digit. These leave room for other compilers and processors.
EXACT = Agreement()
INPUT = Agreement(relative=1e-12)
# The optimum sits on a core edge: fixed sharply in some directions, flatly in others.
PLACE = Agreement(relative=1e-6, absolute=1e-6)
VALUE = Agreement(relative=1e-7, absolute=1e-9)
BOUND = Agreement(relative=1e-4, absolute=1e-4)
MULTIPLIER = Agreement(relative=1e-4, absolute=1e-4)
RISE = Agreement(relative=1e-3, absolute=1e-3)
RESIDUAL = Agreement(absolute=2e-9)
MEASURED = Agreement(compared=False)
# An id follows from the inputs, which are compared themselves, and the model's version, which may differ.
FOLLOWS = MEASURED

Cell = float | int | bool | str | None
"""What may stand in a column of a row."""

Row = dict[str, Cell]
"""A row that is to be stored: its values by column."""

Stored = Mapping[str, Any]
"""A row as it is read again: of what type each column's values are its schema says."""

FLOAT, INTEGER, TEXT, TRUTH = "float", "integer", "text", "truth"

# To what a value belongs: how a job ended; the problem, how it is to be solved, and what it took; what is true of the
# job and not of one of its optima; a bird's place in its flock; an optimum; the proof, the same in all rows of a job.
OUTCOME, PROBLEM, SEARCH, FLOCK, EFFORT = "outcome", "problem", "search", "flock", "effort"
JOB, BIRD, OPTIMUM, PROOF = "job", "bird", "optimum", "proof"
# Of the bird ahead: what it is, an input of a pair; and how it flaps, which a flock finds.
AHEAD, AHEAD_STROKE = "bird ahead", "stroke of the bird ahead"
PAIR_SUMMARY, FLOCK_SUMMARY = "summary of a pair", "summary of a flock"

# How `upwash check` verifies a value.
STATED, IDENTITY, DERIVED = "stated", "identity", "derived"
FOUND, RECOMPUTED = "found", "recomputed"
EVIDENCE, RANKING, CHAIN, PROVED = "evidence", "ranking", "chain", "proved"
SUMMARISED, RANGE = "summarised", "range"
VERIFIED = {
    STATED: "agrees with what the rest of the row says of how the job ended",
    IDENTITY: "the job's id follows from it: any other value gives another id",
    DERIVED: "follows from the job's inputs",
    FOUND: "what a search finds: forces, evidence and costs follow from it, and any other value gives others",
    RECOMPUTED: "computed anew from the inputs and what was found",
    EVIDENCE: "examined anew at what was found",
    RANKING: "follows from the costs and labels of all the job's optima",
    CHAIN: "follows from the flock's shape and the places of the birds ahead",
    PROVED: "one and the same in all rows of the job, below the costs that it bounds, and closed or named open; "
    "--prove repeats the proof",
    SUMMARISED: "computed anew from the job's rows",
    RANGE: "possible at all, and no more: only a new search or run could tell",
}
"""How `upwash check` verifies a value -> what that means."""

# When a row that is solved may lack a value.
NEVER = "never"
LEADING = "if its bird is the first of a flock and follows none"
UNREPORTED = "if it leads, or if the solver is the user's own and does not say"
UNASKED = "if it is an input that was left as usual, or no number"
SOMETIMES = "if there is no such thing; its check knows when"

# Lists that people are shown: of jobs, and of the optima (or birds) of one job.
JOBS, OPTIMA = "jobs", "optima"


@dataclass(frozen=True)
class Column:
    """One column.

    Parameters
    ----------
    name : str
        Its name, which ends in the unit if it has one.
    unit : str
        SI unit; ``1`` for a pure number, empty for text and truth values.
    description : str
        What it says.
    type : str
        ``float``, ``integer``, ``text`` or ``truth``.
    agreement : Agreement
        How closely two runs must agree.
    belongs : str
        To what it belongs: `PROBLEM`, `OPTIMUM` and so on; empty if it is in no results file.
    verified : str
        How it is checked, one of `VERIFIED`.
    absent : str
        When a solved row may lack it: `NEVER`, `LEADING`, `UNREPORTED`, `UNASKED` or `SOMETIMES`.
    least : float or None
        Least possible value, where one is known.
    head, label : str
        How it is headed in a table, without its unit, and named in a list; the name if empty.
    format : str
        How its numbers are written; five significant digits if empty.
    percent : bool
        Whether people are shown it in percent.
    verified_in_flock : str
        How it is checked in a flock's rows, if otherwise: of a bird's optima the V optimum alone is kept there.
    listed : tuple of str
        The lists that it is shown in, of `JOBS` and `OPTIMA`.
    since : int
        The version of the schema with which it came.
    before : bool or None
        What rows that were written before it stand for.
    words : dict
        What is kept for a value that is a word -> the word, by which sweeps, commands and JSON know it.
    """

    name: str
    unit: str
    description: str
    type: str = FLOAT
    agreement: Agreement = VALUE
    belongs: str = ""
    verified: str = ""
    absent: str = NEVER
    least: float | None = None
    head: str = ""
    label: str = ""
    format: str = ""
    percent: bool = False
    verified_in_flock: str = ""
    listed: tuple[str, ...] = ()
    since: int = OLDEST_READ
    before: bool | None = None
    words: Mapping[float | None, str] = field(default_factory=dict, hash=False)

    def told(self, kept: Any) -> Any:
        """Return a value as sweeps, commands and JSON know it, given what is kept of it in Parquet.

        Examples
        --------
        >>> column("wavelengths").told(float("inf")), column("wavelengths").told(2.0), column("span_nodes").told(None)
        ('endless', 2, 'exact')
        """
        if not self.words:
            return kept
        # A frame has NaN for what is absent; what is counted is kept as a float if it may be infinite.
        kept = None if kept != kept else kept
        return int(kept) if isinstance(kept, float) and kept.is_integer() else self.words.get(kept, kept)

    def kept(self, told: Any) -> Any:
        """Return what is kept in Parquet of a value, given as sweeps, commands and JSON know it."""
        return next((kept for kept, word in self.words.items() if word == told), told)

    @property
    def shown_unit(self) -> str:
        """The unit that people are shown, or ""."""
        return "%" if self.percent else "" if self.unit == "1" else self.unit

    @property
    def heading(self) -> str:
        """The head of the column in a table for people, with its unit."""
        return f"{self.head or self.name} {self.shown_unit}".rstrip()

    @property
    def factor(self) -> float:
        """What a value is multiplied by before it is shown."""
        return 100.0 if self.percent else 1.0


SOLVED, INFEASIBLE, FAILED = "solved", "infeasible", "failed"
STATUSES = (SOLVED, INFEASIBLE, FAILED)
"""From best to worst."""


def cause_of(error: str | None) -> str:
    """Return what kind of thing went wrong.

    A row has one column for that, `error`, which is ``cause: reason``; here alone it is taken apart.

    Examples
    --------
    >>> cause_of("no balance: nowhere to fly"), reason_of("no balance: nowhere to fly")
    ('no balance', 'nowhere to fly')
    """
    return (error or "").partition(":")[0][:60]


def reason_of(error: str) -> str:
    """Return why it went wrong: an error without its cause, see `cause_of`."""
    return error.partition(": ")[2] or error


_COST = "N, W or J/m"
_outcome = partial(Column, unit="", type=TEXT, agreement=EXACT, belongs=OUTCOME, verified=STATED)
_id = partial(_outcome, agreement=FOLLOWS, verified=IDENTITY)
_input = partial(Column, agreement=INPUT, belongs=PROBLEM, verified=IDENTITY)
_limit = partial(_input, absent=UNASKED, since=3)
_choice = partial(Column, unit="", type=TEXT, agreement=EXACT, belongs=PROBLEM, verified=IDENTITY)
_rule = partial(_choice, belongs=FLOCK, listed=(JOBS,))
_count = partial(Column, unit="1", type=INTEGER, agreement=EXACT, belongs=PROBLEM, verified=IDENTITY)
_place = partial(Column, agreement=PLACE, belongs=BIRD, verified=CHAIN, format=".3f")
_unlike = partial(_input, belongs=AHEAD, absent=UNASKED, since=3)
_ahead = partial(_unlike, agreement=PLACE, belongs=AHEAD_STROKE, verified_in_flock=CHAIN, absent=SOMETIMES)
_bird = partial(_count, belongs=BIRD, verified=CHAIN, listed=(OPTIMA,))
_found = partial(Column, agreement=PLACE, belongs=OPTIMUM, verified=FOUND, format=".4f", listed=(OPTIMA,))
_relative = partial(_found, absent=LEADING, listed=(JOBS, OPTIMA))
_force = partial(Column, unit="N", belongs=OPTIMUM, verified=RECOMPUTED)
_power = partial(Column, unit="W", belongs=OPTIMUM, verified=RECOMPUTED)
_saving = partial(
    Column, unit="1", belongs=OPTIMUM, verified=RECOMPUTED, head="saving", format=".2f", percent=True
)
_cost = partial(Column, unit=_COST, belongs=OPTIMUM, verified=RECOMPUTED)
_residual = partial(Column, unit="1", agreement=RESIDUAL, belongs=OPTIMUM, verified=RECOMPUTED)
# How many dearer optima are met depends on the starts, and so does what is counted.
_counted = partial(_count, agreement=MEASURED, belongs=OPTIMUM, verified=RANGE, absent=LEADING)
_label = partial(_choice, belongs=OPTIMUM, verified=RECOMPUTED, absent=LEADING, listed=(OPTIMA,))
_truth = partial(_label, type=TRUTH, verified=RANKING)
_evidence = partial(
    Column, unit="1", agreement=MEASURED, belongs=OPTIMUM, verified=EVIDENCE, absent=UNREPORTED
)
_rise = partial(_evidence, agreement=RISE, absent=SOMETIMES, since=3)
_slope = partial(_rise, unit="1/m", least=-1e-6)
_curvature = partial(_rise, unit="1/m2", least=-1e-6)
_restores = partial(_evidence, unit="", type=TRUTH, agreement=EXACT, since=3)
_price = partial(_evidence, agreement=RISE, absent=SOMETIMES, since=3)
_robust = partial(
    Column,
    unit="1",
    agreement=RISE,
    belongs=JOB,
    verified=RECOMPUTED,
    absent=SOMETIMES,
    since=3,
)
_lies_on = partial(_evidence, unit="", type=TEXT, agreement=EXACT)
_bound = partial(Column, unit=_COST, agreement=BOUND, belongs=PROOF, verified=PROVED, absent=SOMETIMES)
_gap = partial(_bound, unit="1")
_proof = partial(Column, unit="", agreement=EXACT, belongs=PROOF, verified=PROVED, absent=UNREPORTED)

COLUMNS = (
    _id("job_id", description="hash of the inputs and the model version"),
    _choice("species", description="species file, without .toml", listed=(JOBS,)),
    _choice("objective", description="name of the cost function", listed=(JOBS,)),
    _outcome("status", description="solved, infeasible (there is no answer) or failed", listed=(JOBS,)),
    _outcome("error", description="why there is no answer", absent=SOMETIMES),
    _input("mass_kg", "kg", "body mass", head="M", label="mass"),
    _input("semispan_m", "m", "half the wingspan", head="b", label="semispan"),
    _input("speed_m_s", "m/s", "airspeed", head="U", label="speed"),
    _input("period_s", "s", "wingbeat period", head="T", label="wingbeat period"),
    _input("density_kg_m3", "kg/m3", "air density", head="ρ", label="air density"),
    _input("gravity_m_s2", "m/s2", "gravitational acceleration", head="g", label="gravity"),
    _input(
        "leader_amplitude_m",
        "m",
        "lone bird's tip-to-tip flapping amplitude, and that of a leader like it",
        head="h_L",
        label="leader's amplitude",
    ),
    _input(
        "leader_upstroke_span_ratio",
        "1",
        "lone bird's upstroke span over downstroke span, and that of a leader like it",
        head="R_L",
        label="leader's upstroke span ratio",
    ),
    _input(
        "circulation_ratio",
        "1",
        "upstroke circulation over downstroke circulation",
        head="Γ_up/Γ_down",
        label="circulation, upstroke to downstroke",
    ),
    _choice("amplitude_convention", description="how the leader's amplitude was chosen", listed=(JOBS,)),
    _input("core_radius_ratio", "1", "vortex core radius over semispan", head="r_c/b", label="vortex core"),
    _choice(
        "model",
        description="named model of the wake that these are inputs of: paper or limit; given if neither",
        verified=DERIVED,
        listed=(JOBS,),
    ),
    _count("stroke_states", description="states or steps in which a wingbeat is told"),
    _choice("stroke_rule", description="held in each state, or gauss for points of a quadrature"),
    _count(
        "span_nodes",
        description="points across the span where the wake is felt; absent for the exact integral",
        absent=UNASKED,
        words={None: "exact"},
    ),
    _input(
        "wavelengths",
        "1",
        "length of each wake, in wavelengths; infinite for an endless one",
        agreement=EXACT,
        words={inf: "endless"},
    ),
    _choice("core", description="vortex core: rankine or rosenhead-moore"),
    _choice(
        "span_law",
        description="follower's span and circulation through its wingbeat: tip, with its height, or stroke, by halves",
    ),
    _input(
        "distance_m",
        "m",
        "how far behind the leader of an endless wake a follower is said to fly; absent: half a wavelength",
        absent=UNASKED,
        label="distance asked for",
    ),
    _choice(
        "phase_lock",
        description="whether birds beat in step, in the first one's period, or each in its own, averaged over phases",
        type=TRUTH,
        since=3,
        before=True,
    ),
    _unlike(
        "ahead_species",
        "",
        "species file of the bird ahead; absent if it is like its follower",
        type=TEXT,
        agreement=EXACT,
        listed=(JOBS,),
    ),
    _unlike("ahead_mass_kg", "kg", "body mass of the bird ahead"),
    _unlike("ahead_semispan_m", "m", "half the wingspan of the bird ahead"),
    _unlike("ahead_period_s", "s", "wingbeat period of the bird ahead"),
    _unlike(
        "ahead_circulation_ratio", "1", "upstroke circulation over downstroke circulation of the bird ahead"
    ),
    _limit("x_min_m", "m", "least distance behind that a follower keeps, if any"),
    _limit("wingtip_gap_min_m", "m", "least gap abs(y) - 2 b between wingtips that a follower keeps, if any"),
    _limit("distance_min_m", "m", "least distance from the bird ahead that a follower keeps, if any"),
    _limit(
        "bearing_max_deg", "deg", "greatest angle, seen from above, from its flight to the bird ahead, if any"
    ),
    _limit(
        "position_sigma_ratio",
        "1",
        "standard deviation in x, y and z, over semispan, by which a place is to jitter, if any",
    ),
    _count("seed", description="seed of the search", belongs=SEARCH),
    _input("tolerance", "1", "relative gap to which the optimum is to be proved", belongs=SEARCH),
    _choice("solver", description="upwash, or package.module:function", belongs=SEARCH),
    _choice("kind", description="pair or flock"),
    _count("birds", description="birds in the flock", belongs=FLOCK, listed=(JOBS,)),
    _rule("shape", description="echelon, vee or alternating"),
    _rule("wake", description="whose wakes a bird feels: neighbour or all-upstream"),
    _rule("reading", description="reading of the amplitude bound: immediate or lone"),
    _choice(
        "members",
        description="the birds behind the first and their inputs, as JSON; absent if all are like it",
        belongs=FLOCK,
        absent=UNASKED,
        since=3,
    ),
    _id("flock_id", description="the flock: its job's id", belongs=BIRD),
    _bird("bird", description="number of the bird, 1 the leader", head="bird"),
    _bird("leader", description="number of the bird that it follows", absent=LEADING, head="follows"),
    _ahead("ahead_amplitude_m", "m", "tip-to-tip flapping amplitude of the bird that it follows"),
    _ahead(
        "ahead_upstroke_span_ratio", "1", "upstroke span over downstroke span of the bird that it follows"
    ),
    _place("x_flock_m", "m", "downstream of the first bird", head="x"),
    _place("y_flock_m", "m", "right of the first bird", head="y"),
    _place("z_flock_m", "m", "above the first bird", head="z", format="+.3f"),
    _place(
        "phase_flock",
        "1",
        "lag behind the first bird, in wingbeats, modulo 1; absent where each keeps its own beat",
        absent=UNASKED,
        head="phase",
    ),
    _relative("x_m", "m", "follower downstream of its leader", head="x"),
    _relative("y_m", "m", "follower right of its leader", head="y"),
    _relative("z_m", "m", "follower above its leader", head="z"),
    _found("amplitude_m", "m", "follower's tip-to-tip flapping amplitude", head="h"),
    _found("upstroke_span_ratio", "1", "follower's upstroke span over downstroke span", head="R"),
    _relative(
        "phase",
        "1",
        "follower's lag behind its leader, in wingbeats; absent where each keeps its own beat",
        absent=SOMETIMES,
        head="κ",
    ),
    _relative(
        "spatial_phase",
        "1",
        "x/lambda - phase, in (-1/2, 1/2]: where in the leader's wake the follower begins its wingbeat",
        absent=SOMETIMES,
        verified=RECOMPUTED,
        head="Φ",
    ),
    _force("weight_n", description="weight of the bird", belongs=JOB, label="weight"),
    _force(
        "drag_n",
        description="drag of the bird, the thrust of its lone stroke",
        belongs=JOB,
        label="drag",
    ),
    _force("lift_self_n", description="lift that the follower makes itself", label="self-generated lift"),
    _force(
        "thrust_self_n",
        description="thrust that the follower makes itself, positive upstream",
        label="self-generated thrust",
    ),
    _force("lift_wake_n", description="lift from the leader's wake"),
    _force("thrust_wake_n", description="thrust from the leader's wake, positive upstream"),
    _power("power_induced_w", description="follower's induced power"),
    _power("power_profile_w", description="follower's profile power"),
    _power("power_parasite_w", description="follower's parasite power"),
    _power("power_total_w", description="follower's total power", label="total power"),
    _power(
        "power_wake_w", description="energy that the follower's own rings carry, per time; in no other power"
    ),
    _power(
        "leader_power_induced_w",
        description="lone bird's induced power",
        belongs=JOB,
    ),
    _power(
        "leader_power_profile_w",
        description="lone bird's profile power",
        belongs=JOB,
    ),
    _power(
        "leader_power_parasite_w",
        description="lone bird's parasite power",
        belongs=JOB,
    ),
    _power(
        "leader_power_total_w",
        description="lone bird's total power",
        belongs=JOB,
        label="total power",
    ),
    _power(
        "leader_power_wake_w", description="energy that the lone bird's rings carry, per time", belongs=JOB
    ),
    _saving("saving_induced", description="share of the lone bird's induced power saved", head="induced"),
    _saving("saving_profile", description="share of the lone bird's profile power saved", head="profile"),
    _saving("saving_total", description="share of the lone bird's total power saved", listed=(JOBS, OPTIMA)),
    _cost(
        "cost",
        description="follower's cost: force N, power and aerodynamic_power W, cost_of_transport J/m",
        format="#.6g",
        listed=(OPTIMA,),
    ),
    _cost("cost_leader", description="lone bird's cost, in the same unit", belongs=JOB),
    _residual("residual_lift", description="lift in excess of weight, over weight", listed=(OPTIMA,)),
    _residual("residual_thrust", description="thrust in excess of drag, over drag", listed=(OPTIMA,)),
    _counted(
        "rank",
        description="place among the job's optima by cost, 0 the best",
        verified=RANKING,
        verified_in_flock=RANGE,
        least=0,
        listed=(OPTIMA,),
    ),
    _counted("hits", description="starts of the search that ended here", least=1),
    _counted("starts", description="starts of the search", least=1),
    _label("placement", description="outboard if at least b aside, else inboard"),
    _label("tier", description="level if within half an amplitude in height, else stacked"),
    _label("station", description="astern if at least b behind, else abreast"),
    _truth("is_v_optimum", description="the best that is outboard, level and astern"),
    _truth("is_global_optimum", description="the best of all", listed=()),
    _lies_on(
        "active_bounds",
        description="bounds that the optimum lies on, comma separated",
        absent=LEADING,
        head="bounds",
    ),
    _lies_on(
        "core_edges",
        description="vortex core edges that the optimum lies on: point/state/filament/ring/shed, comma separated",
        head="edges",
    ),
    _evidence(
        "stationarity", description="size of the gradient that is left, scaled", least=0.0, format=".0e"
    ),
    _evidence(
        "curvature", description="least curvature of the cost along the balances, scaled", absent=SOMETIMES
    ),
    _evidence("multiplier_lift", description="multiplier of the lift balance, scaled", agreement=MULTIPLIER),
    _evidence(
        "multiplier_thrust", description="multiplier of the thrust balance, scaled", agreement=MULTIPLIER
    ),
    _slope("slope_ahead_per_m", description="slope of the least cost, over that alone, held ahead"),
    _slope("slope_behind_per_m", description="slope of the least cost, over that alone, held behind"),
    _slope("slope_inward_per_m", description="slope of the least cost, over that alone, held further in"),
    _slope("slope_outward_per_m", description="slope of the least cost, over that alone, held further out"),
    _slope("slope_below_per_m", description="slope of the least cost, over that alone, held lower"),
    _slope("slope_above_per_m", description="slope of the least cost, over that alone, held higher"),
    _slope(
        "slope_earlier",
        unit="1",
        description="slope of the least cost, over that alone, held earlier in phase",
    ),
    _slope(
        "slope_later", unit="1", description="slope of the least cost, over that alone, held later in phase"
    ),
    _curvature(
        "curvature_ahead_per_m2", description="curvature of the least cost, over that alone, held ahead"
    ),
    _curvature(
        "curvature_behind_per_m2", description="curvature of the least cost, over that alone, held behind"
    ),
    _curvature(
        "curvature_inward_per_m2", description="curvature of the least cost, over that alone, held further in"
    ),
    _curvature(
        "curvature_outward_per_m2",
        description="curvature of the least cost, over that alone, held further out",
    ),
    _curvature(
        "curvature_below_per_m2", description="curvature of the least cost, over that alone, held lower"
    ),
    _curvature(
        "curvature_above_per_m2", description="curvature of the least cost, over that alone, held higher"
    ),
    _curvature(
        "curvature_earlier",
        unit="1",
        description="curvature of the least cost, over that alone, held earlier in phase",
    ),
    _curvature(
        "curvature_later",
        unit="1",
        description="curvature of the least cost, over that alone, held later in phase",
    ),
    _restores(
        "restores_x", description="whether its thrust, as it flaps, rises behind its place and falls ahead"
    ),
    _restores(
        "restores_z", description="whether its lift, as it flaps, rises below its place and falls above"
    ),
    _price(
        "x_min_costs_per_m",
        unit="1/m",
        description="what x_min_m costs: rise of the cost, over that alone, with it",
    ),
    _price("wingtip_gap_min_costs_per_m", unit="1/m", description="what wingtip_gap_min_m costs, likewise"),
    _price("distance_min_costs_per_m", unit="1/m", description="what distance_min_m costs, likewise"),
    _price(
        "bearing_max_costs_per_deg",
        unit="1/deg",
        description="what bearing_max_deg costs: rise of the cost as it falls",
    ),
    _robust(
        "robust_saving_still",
        description="saving of power that the V optimum, or the best, leaves in the jitter",
    ),
    _robust(
        "robust_x_m", unit="m", description="x of the place that leaves most in the jitter to one stroke"
    ),
    _robust("robust_y_m", unit="m", description="y of that place"),
    _robust("robust_z_m", unit="m", description="z of that place"),
    _robust("robust_phase", description="phase of that place"),
    _robust("robust_amplitude_m", unit="m", description="amplitude that balances there in the mean"),
    _robust("robust_upstroke_span_ratio", description="upstroke span ratio that balances there in the mean"),
    _robust("robust_saving", description="saving of power that it leaves"),
    Column(
        "solve_time_s",
        "s",
        "wall time of the job's solution",
        agreement=MEASURED,
        belongs=EFFORT,
        verified=RANGE,
        absent=LEADING,
        least=0.0,
        listed=(JOBS,),
    ),
    _bound("v_lower_bound", description="no V formation costs less; absent if none can fly"),
    _gap(
        "v_region_certified_gap",
        description="cost of the best place known in the V region over that bound, less 1",
    ),
    _gap("v_certified_gap", description="V optimum's cost over that bound, less 1"),
    _bound(
        "global_lower_bound",
        description="no position costs less; absent if none can be flown",
        verified_in_flock=RANGE,
        least=0.0,
    ),
    _gap(
        "global_certified_gap",
        description="global optimum's cost over that bound, less 1",
        verified_in_flock=RANGE,
        least=-1e-9,
    ),
    _counted(
        "certificate_boxes",
        description="boxes that the proof looked at",
        belongs=PROOF,
        absent=UNREPORTED,
        least=0,
    ),
    _proof(
        "v_wall",
        description="wall of the V region that its best point lies on, if it is no optimum",
        type=TEXT,
    ),
    _proof("feasible", description="whether any position balances lift and thrust", type=TRUTH),
    Column(
        "v_gap",
        "1",
        "cost of the V optimum over that of the global optimum, less 1",
        belongs=PAIR_SUMMARY,
        verified=SUMMARISED,
        absent=SOMETIMES,
        head="gap",
        format=".2f",
        percent=True,
        listed=(JOBS,),
    ),
    # Of the dearest, which few starts reach, a last digit decides whether one is met.
    _counted(
        "optima_found", description="distinct optima of the job", belongs=PAIR_SUMMARY, verified=SUMMARISED
    ),
    _count(
        "birds_placed",
        description="birds that found their place",
        belongs=FLOCK_SUMMARY,
        verified=SUMMARISED,
        listed=(JOBS,),
    ),
    _cost(
        "cost_mean",
        description="mean cost over the birds placed",
        belongs=FLOCK_SUMMARY,
        verified=SUMMARISED,
    ),
    _saving(
        "saving_total_mean",
        description="mean saving of total power over the birds placed",
        belongs=FLOCK_SUMMARY,
        verified=SUMMARISED,
        listed=(JOBS,),
    ),
)


def belonging(*what: str, among: Iterable[Column] = COLUMNS) -> tuple[Column, ...]:
    """Return the columns that belong to any of some things, in the order of the files.

    Examples
    --------
    >>> [column.name for column in belonging(SEARCH)]
    ['seed', 'tolerance', 'solver']
    """
    return tuple(column for column in among if column.belongs in what)


def names(columns: Iterable[Column]) -> tuple[str, ...]:
    """Return the names of some columns."""
    return tuple(column.name for column in columns)


@cache
def column(name: str) -> Column:
    """Return a column of the results by its name."""
    return next(one for one in COLUMNS if one.name == name)


def told(row: Stored) -> dict[str, Any]:
    """Return a row as JSON has it, given as it is kept in Parquet: what is a word is one."""
    return {name: _BY_NAME[name].told(value) if name in _BY_NAME else value for name, value in row.items()}


def kept(row: Mapping[str, Cell]) -> Row:
    """Return a row as it is kept in Parquet, given as JSON has it."""
    return {name: _BY_NAME[name].kept(value) if name in _BY_NAME else value for name, value in row.items()}


_BY_NAME = {one.name: one for one in COLUMNS if one.words}
"""The columns that have words."""


OF_BOTH = (OUTCOME, PROBLEM, SEARCH, AHEAD_STROKE, JOB, OPTIMUM, EFFORT, PROOF)
SOLUTIONS_COLUMNS = belonging(*OF_BOTH, AHEAD)
SUMMARY_COLUMNS = belonging(*OF_BOTH, AHEAD, PAIR_SUMMARY)
FLOCK_COLUMNS = tuple(
    replace(one, verified=one.verified_in_flock or one.verified) for one in belonging(*OF_BOTH, FLOCK, BIRD)
)
FLOCK_SUMMARY_COLUMNS = belonging(OUTCOME, PROBLEM, SEARCH, FLOCK, FLOCK_SUMMARY)
