"""The V optimum is a true local minimum: a method without derivatives, none of our solver in it, agrees.

Of the six variables, amplitude and upstroke span ratio follow from the two balances, solved here on the plain
statement of the wake force. What is left, position and phase, is searched by an evolution strategy, which
compares costs and nothing else, so that it does not mind the kink on which the optimum lies.
"""

import math

import numpy as np
import pytest
from upwash.aero.interaction import net_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS


class Follower:
    """The cost of a position and phase, the stroke being what balances there; infinite where none does."""

    def __init__(self, bird, objective, near):
        self.bird = bird
        self.cost = COST_FUNCTIONS[objective].value
        self.near = np.array([near.amplitude_m, near.upstroke_span_ratio])

    def own(self, stroke):
        """Return the self-generated lift and thrust of an amplitude and ratio, over weight and drag."""
        amplitude, ratio = stroke
        lift, thrust = self.bird.lift_n(ratio), self.bird.thrust_n(amplitude, ratio)
        return np.array([lift / self.bird.weight_n, thrust / self.bird.drag_n])

    def missing(self, place, stroke):
        """Return lift in excess of weight and thrust in excess of drag, over weight and drag."""
        bird, (*position, lag) = self.bird, place
        lift, thrust = net_force(bird, bird.stroke, Pose(*position, Stroke(*stroke), 0.5 + lag))
        return np.array([lift / bird.weight_n - 1, thrust / bird.drag_n - 1])

    def balanced(self, place):
        """Return amplitude and upstroke span ratio that balance, by Broyden's method, or None."""
        # The follower's own force changes with its stroke more than the wake's does, and starts the slope.
        step = 1e-3
        slope = np.array([self.own(self.near + step * e) - self.own(self.near) for e in np.eye(2)]).T / step
        stroke, excess = self.near, self.missing(place, self.near)
        for _ in range(20):
            if np.max(np.abs(excess)) < 1e-12:
                return stroke
            change = np.linalg.solve(slope, -excess)
            stroke = stroke + change
            if np.max(np.abs(stroke - self.near)) > 0.2:
                return None
            excess = self.missing(place, stroke)
            slope += np.outer(excess, change) / (change @ change)
        return None

    def __call__(self, place):
        stroke = self.balanced(place)
        if stroke is None:
            return math.inf
        amplitude, ratio = stroke
        is_within = 0.25 <= amplitude / self.bird.amplitude_m <= 1.0 and 0.3 <= ratio <= 0.5
        lift, thrust = self.bird.lift_n(ratio), self.bird.thrust_n(amplitude, ratio)
        return self.cost(self.bird, lift, thrust) if is_within else math.inf


def evolve(cost, start, spread, seed, evaluations, offspring=8):
    """Minimise by covariance matrix adaptation (Hansen, arXiv:1604.00772); return the least cost met."""
    random, size = np.random.default_rng(seed), len(start)
    parents = offspring // 2
    weights = math.log(parents + 0.5) - np.log(np.arange(1, parents + 1))
    weights /= weights.sum()
    mass = 1 / np.sum(weights**2)
    c_sigma = (mass + 2) / (size + mass + 5)
    damping = 1 + c_sigma + 2 * max(0.0, math.sqrt((mass - 1) / (size + 1)) - 1)
    c_path = (4 + mass / size) / (size + 4 + 2 * mass / size)
    c_one = 2 / ((size + 1.3) ** 2 + mass)
    c_rank = min(1 - c_one, 2 * (mass - 2 + 1 / mass) / ((size + 2) ** 2 + mass))
    expected = math.sqrt(size) * (1 - 1 / (4 * size) + 1 / (21 * size**2))
    mean, covariance = np.array(start), np.eye(size)
    path, path_sigma = np.zeros(size), np.zeros(size)
    least = math.inf
    for _ in range(evaluations // offspring):
        lengths, axes = np.linalg.eigh(covariance)
        normal = random.standard_normal((offspring, size))
        steps = normal * np.sqrt(np.maximum(lengths, 1e-30)) @ axes.T
        costs = np.array([cost(mean + spread * step) for step in steps])
        order = np.argsort(costs)[:parents]
        least = min(least, costs[order[0]])
        if np.ptp(costs) < 1e-10 * least:
            break
        step = weights @ steps[order]
        mean = mean + spread * step
        path_sigma = (1 - c_sigma) * path_sigma
        path_sigma += math.sqrt(c_sigma * (2 - c_sigma) * mass) * axes @ (weights @ normal[order])
        length = np.linalg.norm(path_sigma)
        is_short = length < (1.4 + 2 / (size + 1)) * expected
        path = (1 - c_path) * path + is_short * math.sqrt(c_path * (2 - c_path) * mass) * step
        spread_out = (steps[order].T * weights) @ steps[order]
        covariance = (1 - c_one - c_rank) * covariance + c_one * np.outer(path, path) + c_rank * spread_out
        spread *= math.exp(c_sigma / damping * (length / expected - 1))
    return least


@pytest.mark.thorough
@pytest.mark.parametrize("objective", ["force", "power"])
def test_a_method_without_derivatives_ends_in_the_same_minimum_from_a_centimetre_away(
    ibis, objective, request
):
    best = request.getfixturevalue(f"ibis_{objective}").v_optimum
    follower = Follower(ibis, objective, best)
    place = np.array([best.x_m, best.y_m, best.z_m, best.phase - 0.5])
    assert follower(place) == pytest.approx(best.cost, rel=1e-10)
    start = place + [0.01, -0.01, 0.01, 0.01]
    assert best.cost * (1 + 1e-3) < follower(start) < math.inf
    least = evolve(follower, start, 0.005, seed=0, evaluations=2000)
    assert least == pytest.approx(best.cost, rel=1e-7)
