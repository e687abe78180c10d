// A bird, the power that it needs, and what its objective weighs. The same as `upwash.aero.bird` and `.power`, in SI units;
// constants come from there.
"use strict";

function makeBirds(constants) {
  // Take a bird's inputs, named as in Python, and add what follows from them.
  function makeBird(inputs) {
    const b = inputs.semispan_m, ratio = inputs.circulation_ratio;
    const bird = { ...inputs };
    bird.wavelength = inputs.speed_m_s * inputs.period_s;
    bird.weight = inputs.mass_kg * inputs.gravity_m_s2;
    const liftSpan = (span) => Math.PI / 4 + ratio * span, thrustSpan = (span) => Math.PI / 2 - 2 * ratio * span;
    bird.circulation = bird.weight / (inputs.density_kg_m3 * b * inputs.speed_m_s * liftSpan(inputs.upstroke_span_ratio));
    const impulse = inputs.density_kg_m3 * b * bird.circulation;
    bird.lift = (span) => impulse * inputs.speed_m_s * liftSpan(span);
    bird.thrust = (amplitude, span) => impulse * amplitude * thrustSpan(span) / inputs.period_s;
    bird.drag = bird.thrust(inputs.amplitude_m, inputs.upstroke_span_ratio);
    return bird;
  }

  // Mechanical power in W of making lift and thrust in N: induced, profile, parasite and their sum.
  function power(bird, lift, thrust) {
    const span = 2 * bird.semispan_m;
    const induced = 2 * constants.induced_power_factor * lift * lift / (span * span * Math.PI * bird.density_kg_m3 * bird.speed_m_s);
    const profile = thrust * bird.speed_m_s;
    const area = constants.body_area_m2 * bird.mass_kg ** constants.body_area_exponent;
    const parasite = 0.5 * bird.density_kg_m3 * bird.speed_m_s ** 3 * area * constants.body_drag_coefficient;
    return { induced, profile, parasite, total: induced + profile + parasite };
  }

  // What the bird wants to be small: the sum of its own force and powers with the weights of a cost function.
  function cost(bird, weights, lift, thrust) {
    const one = power(bird, lift, thrust);
    return weights.force * Math.hypot(lift, thrust) + weights.induced * one.induced + weights.profile * one.profile + weights.parasite * one.parasite;
  }

  function strokeOf(bird, weights, amplitude, ratio) {
    return { amplitude, ratio, cost: cost(bird, weights, bird.lift(ratio), bird.thrust(amplitude, ratio)) };
  }

  // Share of the lone bird's cost that a stroke saves.
  function saving(bird, weights, stroke) {
    return 1 - stroke.cost / cost(bird, weights, bird.weight, bird.drag);
  }

  return { makeBird, power, cost, strokeOf, saving };
}
