"""Every column of the results: its name, type, unit, meaning, and how closely two runs must agree on it.

The order here is the order in the files. A table's schema, the checks and the comparison of two results
folders are all made from these lists.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

SCHEMA_VERSION = 1
"""Raised by hand when a column is added, removed or given another meaning."""


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
RESIDUAL = Agreement(absolute=2e-9)
MEASURED = Agreement(compared=False)

FLOAT, INTEGER, TEXT, TRUTH = "float", "integer", "text", "truth"


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
    """

    name: str
    unit: str
    description: str
    type: str = FLOAT
    agreement: Agreement = VALUE


SOLVED, INFEASIBLE, FAILED = "solved", "infeasible", "failed"
STATUSES = (SOLVED, INFEASIBLE, FAILED)
"""From best to worst."""


def cause_of(error: str | None) -> str:
    """Return what kind of thing went wrong: what stands before the first colon of an error."""
    return (error or "").partition(":")[0][:60]


OUTCOME = (
    Column("job_id", "", "hash of the inputs and the model version", TEXT, EXACT),
    Column("species", "", "species file, without .toml", TEXT, EXACT),
    Column("objective", "", "name of the cost function", TEXT, EXACT),
    Column("status", "", "solved, infeasible (there is no answer) or failed", TEXT, EXACT),
    Column("error", "", "why there is no answer", TEXT, EXACT),
)

INPUTS = (
    Column("mass_kg", "kg", "body mass", agreement=INPUT),
    Column("semispan_m", "m", "half the wingspan", agreement=INPUT),
    Column("speed_m_s", "m/s", "airspeed", agreement=INPUT),
    Column("period_s", "s", "wingbeat period", agreement=INPUT),
    Column("density_kg_m3", "kg/m3", "air density", agreement=INPUT),
    Column("gravity_m_s2", "m/s2", "gravitational acceleration", agreement=INPUT),
    Column("leader_amplitude_m", "m", "leader's tip-to-tip flapping amplitude", agreement=INPUT),
    Column("leader_upstroke_span_ratio", "1", "leader's upstroke span over downstroke span", agreement=INPUT),
    Column("circulation_ratio", "1", "upstroke circulation over downstroke circulation", agreement=INPUT),
    Column("amplitude_convention", "", "how the leader's amplitude was chosen", TEXT, EXACT),
    Column("core_radius_ratio", "1", "vortex core radius over semispan", agreement=INPUT),
    Column("stroke_states", "1", "states in which each bird is held in a wingbeat", INTEGER, EXACT),
    Column("span_nodes", "1", "points across the span where the wake is felt", INTEGER, EXACT),
    Column("seed", "1", "seed of the search", INTEGER, EXACT),
    Column("tolerance", "1", "relative gap to which the optimum is to be proved", agreement=INPUT),
    Column("solver", "", "upwash, or package.module:function", TEXT, EXACT),
    Column("kind", "", "pair or flock", TEXT, EXACT),
)

SOLUTION = (
    Column("x_m", "m", "follower downstream of its leader", agreement=PLACE),
    Column("y_m", "m", "follower right of its leader", agreement=PLACE),
    Column("z_m", "m", "follower above its leader", agreement=PLACE),
    Column("amplitude_m", "m", "follower's tip-to-tip flapping amplitude", agreement=PLACE),
    Column("upstroke_span_ratio", "1", "follower's upstroke span over downstroke span", agreement=PLACE),
    Column("phase", "1", "follower's lag behind its leader, in wingbeats", agreement=PLACE),
    Column("weight_n", "N", "weight of either bird"),
    Column("drag_n", "N", "drag of either bird"),
    Column("lift_self_n", "N", "lift that the follower makes itself"),
    Column("thrust_self_n", "N", "thrust that the follower makes itself, positive upstream"),
    Column("lift_wake_n", "N", "lift from the leader's wake"),
    Column("thrust_wake_n", "N", "thrust from the leader's wake, positive upstream"),
    Column("power_induced_w", "W", "follower's induced power"),
    Column("power_profile_w", "W", "follower's profile power"),
    Column("power_parasite_w", "W", "follower's parasite power"),
    Column("power_total_w", "W", "follower's total power"),
    Column("leader_power_induced_w", "W", "leader's induced power"),
    Column("leader_power_profile_w", "W", "leader's profile power"),
    Column("leader_power_parasite_w", "W", "leader's parasite power"),
    Column("leader_power_total_w", "W", "leader's total power"),
    Column("saving_induced", "1", "share of the leader's induced power saved"),
    Column("saving_profile", "1", "share of the leader's profile power saved"),
    Column("saving_total", "1", "share of the leader's total power saved"),
    Column("cost", "N, W or J/m", "follower's cost: force N, power W, cost_of_transport J/m"),
    Column("cost_leader", "N, W or J/m", "leader's cost, in the same unit"),
    Column("residual_lift", "1", "lift in excess of weight, over weight", agreement=RESIDUAL),
    Column("residual_thrust", "1", "thrust in excess of drag, over drag", agreement=RESIDUAL),
    # How many dearer optima are met depends on the starts.
    Column("rank", "1", "place among the job's optima by cost, 0 the best", INTEGER, MEASURED),
    Column("hits", "1", "starts of the search that ended here", INTEGER, MEASURED),
    Column("starts", "1", "starts of the search", INTEGER, MEASURED),
    Column("placement", "", "outboard if at least b aside, else inboard", TEXT, EXACT),
    Column("tier", "", "level if within half an amplitude in height, else stacked", TEXT, EXACT),
    Column("station", "", "astern if at least b behind, else abreast", TEXT, EXACT),
    Column("is_v_optimum", "", "the best that is outboard, level and astern", TRUTH, EXACT),
    Column("is_global_optimum", "", "the best of all", TRUTH, EXACT),
    Column("active_bounds", "", "bounds that the optimum lies on, comma separated", TEXT, EXACT),
    Column("core_edges", "", "vortex core edges that the optimum lies on, comma separated", TEXT, EXACT),
    Column("stationarity", "1", "size of the gradient that is left, scaled", agreement=MEASURED),
    Column("curvature", "1", "least curvature of the cost along the balances, scaled", agreement=MEASURED),
    Column("multiplier_lift", "1", "multiplier of the lift balance, scaled", agreement=MULTIPLIER),
    Column("multiplier_thrust", "1", "multiplier of the thrust balance, scaled", agreement=MULTIPLIER),
    Column("solve_time_s", "s", "wall time of the job's solution", agreement=MEASURED),
)

# The proof: the same in every row of a job.
CERTIFICATE = (
    Column(
        "v_lower_bound", "N, W or J/m", "no V formation costs less; absent if none can fly", agreement=BOUND
    ),
    Column("v_certified_gap", "1", "V optimum's cost over that bound, less 1", agreement=BOUND),
    Column(
        "global_lower_bound",
        "N, W or J/m",
        "no position costs less; absent if none can be flown",
        agreement=BOUND,
    ),
    Column("global_certified_gap", "1", "global optimum's cost over that bound, less 1", agreement=BOUND),
    Column("certificate_boxes", "1", "boxes that the proof looked at", INTEGER, MEASURED),
    Column(
        "v_wall", "", "wall of the V region that its best point lies on, if it is no optimum", TEXT, EXACT
    ),
    Column("feasible", "", "whether any position balances lift and thrust", TRUTH, EXACT),
)

FLOCK_INPUTS = (
    Column("birds", "1", "birds in the flock", INTEGER, EXACT),
    Column("shape", "", "echelon, vee or alternating", TEXT, EXACT),
    Column("wake", "", "whose wakes a bird feels: neighbour or all-upstream", TEXT, EXACT),
    Column("reading", "", "reading of the amplitude bound: immediate or lone", TEXT, EXACT),
    Column("wavelengths", "1", "length of each wake, in wavelengths", INTEGER, EXACT),
)
FLOCK_PLACE = (
    Column("flock_id", "", "the flock: its job's id", TEXT, EXACT),
    Column("bird", "1", "number of the bird, 1 the leader", INTEGER, EXACT),
    Column("leader", "1", "number of the bird that it follows", INTEGER, EXACT),
    Column("x_flock_m", "m", "downstream of the first bird", agreement=PLACE),
    Column("y_flock_m", "m", "right of the first bird", agreement=PLACE),
    Column("z_flock_m", "m", "above the first bird", agreement=PLACE),
    Column("phase_flock", "1", "lag behind the first bird, in wingbeats, modulo 1", agreement=PLACE),
)

SUMMARY_ONLY = (
    Column("v_gap", "1", "cost of the V optimum over that of the global optimum, less 1"),
    # Of the dearest, which few starts reach, a last digit decides whether one is met.
    Column("optima_found", "1", "distinct optima of the job", INTEGER, MEASURED),
)
FLOCK_SUMMARY_ONLY = (
    Column("birds_placed", "1", "birds that found their place", INTEGER, EXACT),
    Column("cost_mean", "N, W or J/m", "mean cost over the birds placed"),
    Column("saving_total_mean", "1", "mean saving of total power over the birds placed"),
)

# In a flock's rows the leader is the bird that a row's bird follows, so but for the first its stroke is an outcome.
STROKE_AHEAD = {
    "leader_amplitude_m": "tip-to-tip flapping amplitude of the bird that it follows",
    "leader_upstroke_span_ratio": "upstroke span over downstroke span of the bird that it follows",
}
INPUTS_OF_A_BIRD = tuple(
    replace(column, description=STROKE_AHEAD[column.name], agreement=PLACE)
    if column.name in STROKE_AHEAD
    else column
    for column in INPUTS
)

SOLUTIONS_COLUMNS = (*OUTCOME, *INPUTS, *SOLUTION, *CERTIFICATE)
FLOCK_COLUMNS = (*OUTCOME, *INPUTS_OF_A_BIRD, *FLOCK_INPUTS, *FLOCK_PLACE, *SOLUTION, *CERTIFICATE)
SUMMARY_COLUMNS = (*SOLUTIONS_COLUMNS, *SUMMARY_ONLY)
FLOCK_SUMMARY_COLUMNS = (*OUTCOME, *INPUTS, *FLOCK_INPUTS, *FLOCK_SUMMARY_ONLY)
