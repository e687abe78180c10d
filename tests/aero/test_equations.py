"""Every equation of the paper is named where it is implemented, once, and holds there."""

import ast
import math
from pathlib import Path

import pytest
import upwash
from upwash.aero.power import COST_FUNCTIONS, induced_power_w, parasite_power_w, profile_power_w
from upwash.aero.wake import spanwise_spacing_rule

PACKAGE = Path(upwash.__file__).parent

# Label in the source of arXiv:2602.22043: what the equation says, and the one definition that names it.
LABELLED = {
    "leader_vert_force": ("lift is vertical impulse over the period", "aero/bird.py", "lift_n"),
    "leader_vert_imp": ("vertical impulse of down- and upstroke", "aero/bird.py", "vertical_impulse_n_s"),
    "leader_hor_force": ("horizontal impulse of both strokes", "aero/bird.py", "horizontal_impulse_n_s"),
    "total_follower_force": ("own and wake-induced force together", "aero/interaction.py", "net_force"),
    "eqn:beta_uniform": ("share of the time in like states", "aero/interaction.py", "phase_weights"),
    "eqn:beta_mixed": ("share of the time in unlike states", "aero/interaction.py", "phase_weights"),
    "eqn:total_induced_force": ("mean wake-induced force", "aero/interaction.py", "wake_force"),
    "eq:gamma_sol": ("circulation from weight support", "aero/bird.py", "circulation_m2_s"),
    "objective_fn": ("cost of force", "aero/power.py", "COST_FUNCTIONS"),
    "induced_power": ("power to make lift", "aero/power.py", "induced_power_w"),
    "profile_power": ("power to make thrust", "aero/power.py", "profile_power_w"),
    "parasite_power": ("power against the body's drag", "aero/power.py", "parasite_power_w"),
    "optimal_spanwise_dist": ("rule of spanwise spacing", "aero/wake.py", "spanwise_spacing_rule"),
    "eqn:full_integral": ("force on a lifting line", "aero/interaction.py", "state_forces"),
    "eqn:integral_approx": ("trapezoidal rule from tip to tip", "aero/span_integral.py", "span_nodes"),
    "v_ind": ("velocity induced by a filament", "aero/compiled/rings.py", "filament_velocity"),
}


def definitions_naming(label):
    """Return module, innermost definition and its docstring for each mention of a label in the package."""
    found = []
    for path in PACKAGE.rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        for number, line in enumerate(source.splitlines(), start=1):
            words = line.replace("(", " ").replace(")", " ").replace(",", " ").split()
            found += [(path, source, number)] * words.count(label)
    return [
        (path.relative_to(PACKAGE).as_posix(), *innermost(source, number)) for path, source, number in found
    ]


def innermost(source, number):
    """Return name and docstring of the innermost definition that holds a line of a module."""
    name, docstring = "", ""
    for node in ast.walk(ast.parse(source)):
        if not (hasattr(node, "lineno") and node.lineno <= number <= node.end_lineno):
            continue
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            name, docstring = node.name, ast.get_docstring(node) or ""
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            name, docstring = node.target.id, ""
    return name, docstring


@pytest.mark.parametrize("label", LABELLED)
def test_a_labelled_equation_is_named_once_by_what_implements_it(label):
    _, module, name = LABELLED[label]
    mentions = definitions_naming(label)
    assert [(where, definition) for where, definition, _ in mentions] == [(module, name)]
    # A table of cost functions has no docstring to stand in: the label is beside its line there.
    assert label in mentions[0][2] or name == "COST_FUNCTIONS"


# What follows states the equations of bird, cost and spacing as printed, and compares.  Those of the wake, of
# its velocity and its force are stated in paper.py and compared in the files named for them.
R_F, H_F = 0.347, 0.751


@pytest.fixture(scope="module")
def symbols(ibis):
    """Return the paper's symbols for the lone ibis."""
    return {
        "rho": 1.29,
        "b": 0.6,
        "U": 15.0,
        "T": 0.25,
        "M": 1.3,
        "W": 1.3 * 9.8,
        "Gamma": ibis.circulation_m2_s,
        "lambda": 15.0 * 0.25,
        "h": 1.2 * math.sin(math.pi / 3),
        "R": 0.4,
    }


def test_circulation_supports_the_weight(ibis, symbols):
    s = symbols
    left = (math.pi / 4 + s["R"]) * ibis.circulation_m2_s
    assert left == pytest.approx(s["W"] * s["T"] / (s["rho"] * s["b"] * s["lambda"]), rel=1e-14)
    assert left == pytest.approx(s["W"] / (s["rho"] * s["b"] * s["U"]), rel=1e-14)


def test_impulses_and_the_forces_they_make(ibis, symbols):
    s = symbols
    i_zd = s["rho"] * math.pi * s["b"] * s["lambda"] * s["Gamma"] / 4
    i_zu = s["rho"] * s["b"] * R_F * s["lambda"] * s["Gamma"]
    i_xd = s["rho"] * math.pi * s["b"] * H_F * s["Gamma"] / 2
    i_xu = 2 * s["rho"] * s["b"] * R_F * H_F * s["Gamma"]
    assert ibis.vertical_impulse_n_s(R_F) == pytest.approx(i_zd + i_zu, rel=1e-14)
    assert ibis.horizontal_impulse_n_s(H_F, R_F) == pytest.approx(i_xd - i_xu, rel=1e-14)
    assert ibis.lift_n(R_F) == pytest.approx((i_zd + i_zu) / s["T"], rel=1e-14)
    assert ibis.thrust_n(H_F, R_F) == pytest.approx((i_xd - i_xu) / s["T"], rel=1e-14)


def test_powers(ibis, symbols):
    s, i_z, i_x = symbols, 3.0, 0.5
    p_ind = 2 * 1.2 * i_z**2 / ((2 * s["b"]) ** 2 * math.pi * s["rho"] * s["U"] * s["T"] ** 2)
    p_pro = i_x * s["U"] / s["T"]
    p_par = s["rho"] * s["U"] ** 3 * (0.00813 * s["M"] ** 0.666) * 1.0 / 2
    assert induced_power_w(ibis, i_z / s["T"]) == pytest.approx(p_ind, rel=1e-14)
    assert profile_power_w(ibis, i_x / s["T"]) == pytest.approx(p_pro, rel=1e-14)
    assert parasite_power_w(ibis) == pytest.approx(p_par, rel=1e-14)
    # The two objectives; that of force is printed as an impulse.
    power, force = (
        COST_FUNCTIONS[name].value(ibis, i_z / s["T"], i_x / s["T"]) for name in ("power", "force")
    )
    assert power == pytest.approx(p_ind + p_pro + p_par, rel=1e-14)
    assert force * s["T"] == pytest.approx(math.sqrt(i_x**2 + i_z**2), rel=1e-14)


def test_spanwise_spacing():
    b = 0.6
    printed = 0.5 * (math.pi * b / 4 + b + math.pi * b / 4 + R_F * b)
    assert spanwise_spacing_rule(b, R_F) == pytest.approx(printed, rel=1e-14)
