// What is chosen (a bird, a model, a place and a stroke), what follows from it, and how it stands in the page's address.
// Lengths are in m.
"use strict";

const clamp = (value, [low, high]) => Math.min(high, Math.max(low, value));

// `leftmost` is how far to the left a follower may be taken, in semispans.
function makeChosen(data, physics, leftmost) {
  const weights = data.objective.weights;
  const KEYS = ["species", "model", "law", "x", "y", "z", "phase", "amplitude", "ratio", "speed", "core", "adapting"];
  const state = {};
  // The bird, its model and wake; the strokes that balance where it was last looked for; what is found.
  const now = { solutions: [], isComplete: false, time: 0.12 };

  const speciesNamed = (slug) => data.species.find((one) => one.slug === slug);
  const modelOf = () => ({ name: state.model, core_radius_ratio: state.core, span_law: state.law, stroke_states: 32 });

  function makeBirdAndWake() {
    now.species = speciesNamed(state.species);
    now.inputs = { ...now.species.bird, speed_m_s: state.speed };
    now.bird = physics.makeBird(now.inputs);
    now.model = modelOf();
    now.wake = physics.makeWake(now.bird, now.model);
  }

  const semispan = () => now.bird.semispan_m;

  const placeNow = () => ({ x: state.x, y: state.y, z: state.z, phase: state.phase });

  function useStroke(stroke) {
    state.amplitude = stroke.amplitude;
    state.ratio = stroke.ratio;
  }

  // Solve the stroke: of all that balance the cheapest, or the one that comes nearest.
  function adapt() {
    now.solutions = physics.balances(now.bird, now.model, now.wake, placeNow(), weights);
    now.isComplete = true;
    useStroke(now.solutions[0] ?? physics.nearest(now.bird, now.wake, placeNow()));
  }

  function limits() {
    const b = now.species.bird.semispan_m, wavelength = (state.speed ?? 0) * now.species.bird.period_s;
    const own = now.species.bird.speed_m_s, [[lowH, lowR], [highH, highR]] = data.constants.stroke_bounds;
    return {
      x: [0, 1.25 * wavelength, b / 60], y: [leftmost * b, 2.6 * b, b / 60], z: [-1.1 * b, 1.1 * b, b / 60],
      phase: [0, 1, 0.01], amplitude: [lowH * b, highH * b, b / 120], ratio: [lowR, highR, 0.005],
      speed: [0.6 * own, 1.6 * own, 0.1], core: [0.05, 0.3, 0.001],
    };
  }

  // Whether airspeed, core and wing are those for which best places are kept.
  const isOwn = () => state.speed === now.species.bird.speed_m_s && state.core === data.constants.core_radius_ratio && (state.model === "paper" || state.law === "stroke");

  // Lift and thrust as shares of weight and drag: its own, the wake's, and both; and what it costs.
  function force() {
    const wake = [0, 0];
    now.wake(state.x, state.y, state.z, state.phase, state.amplitude, state.ratio, wake);
    const { bird } = now, own = [bird.lift(state.ratio), bird.thrust(state.amplitude, state.ratio)];
    return {
      own: [own[0] / bird.weight, own[1] / bird.drag], wake: [wake[0] / bird.weight, wake[1] / bird.drag],
      total: [(own[0] + wake[0]) / bird.weight, (own[1] + wake[1]) / bird.drag],
      power: physics.power(bird, ...own), cost: physics.cost(bird, weights, ...own),
    };
  }

  // The best place near a kept one, for settings of which none is kept: downhill in place and phase, the stroke solved.
  function improved(start) {
    const b = semispan(), keys = ["x", "y", "z", "phase"], size = { x: b, y: b, z: b, phase: 0.3 };
    const cheapest = (place, near) => (near && physics.follow(now.bird, now.wake, place, weights, near)) || physics.balances(now.bird, now.model, now.wake, place, weights)[0];
    let at = { ...start }, stroke = cheapest(at), step = 0.12;
    const begun = performance.now();
    while (step > 1e-3 && performance.now() - begun < 4000) {
      let isBetter = false;
      for (const key of keys) for (const sign of [1, -1]) {
        if (state.model === "limit" && key === "x") continue;
        const tried = { ...at, [key]: at[key] + sign * step * size[key] };
        const found = tried.x >= 0 ? cheapest(tried, stroke) : null;
        if (found && (!stroke || found.cost < stroke.cost)) [at, stroke, isBetter] = [tried, found, true];
      }
      if (!isBetter) step *= 0.5;
    }
    const range = limits();
    for (const key of ["x", "y", "z"]) at[key] = clamp(at[key], range[key]);
    return { x: at.x, y: at.y, z: at.z, phase: at.phase - Math.floor(at.phase) };
  }

  // ---- the address ----

  function writeAddress() {
    const text = KEYS.map((key) => `${key}=${encodeURIComponent(typeof state[key] === "number" ? Number(state[key].toPrecision(12)) : state[key])}`).join("&");
    history.replaceState(null, "", `#${text}`);
  }
  let addressTimer = 0;
  const writeAddressSoon = () => { clearTimeout(addressTimer); addressTimer = setTimeout(writeAddress, 200); };

  function readAddress() {
    const given = new URLSearchParams(location.hash.slice(1)), named = (key, choices, otherwise) => choices.includes(given.get(key)) ? given.get(key) : otherwise;
    state.species = named("species", data.species.map((one) => one.slug), data.start.species);
    state.model = named("model", ["paper", "limit"], data.start.model);
    state.law = named("law", ["stroke", "tip"], data.start.law);
    state.adapting = given.get("adapting") !== "false";
    const bird = speciesNamed(state.species).bird, numeric = (key, otherwise) => {
      const value = given.has(key) ? Number(given.get(key)) : NaN;
      return Number.isFinite(value) ? value : otherwise;
    };
    now.species = speciesNamed(state.species);
    state.speed = clamp(numeric("speed", bird.speed_m_s), limits().speed);
    state.core = clamp(numeric("core", data.start.core), limits().core);
    makeBirdAndWake();
    const start = firstPlace(), range = limits();
    for (const [key, value] of Object.entries(start)) state[key] = numeric(key, value);
    for (const key of ["x", "y", "z", "amplitude", "ratio"]) state[key] = clamp(state[key], range[key]);
    state.phase -= Math.floor(state.phase);
  }

  const fromKept = (one) => ({ x: one.x_m, y: one.y_m, z: one.z_m, phase: one.phase, amplitude: one.amplitude_m, ratio: one.upstroke_span_ratio });
  const keptPlace = (kind) => now.species.optima[state.model].find((one) => one.kind === kind);

  function firstPlace() {
    const one = keptPlace("v") ?? keptPlace("global");
    const { amplitude_m: amplitude, upstroke_span_ratio: ratio, semispan_m: b } = now.species.bird;
    return one ? fromKept(one) : { x: 0.5 * now.bird.wavelength, y: 1.8 * b, z: 0, phase: 0.5, amplitude, ratio };
  }

  return {
    state, now, semispan, limits, isOwn, force, useStroke, adapt, placeNow, improved, makeBirdAndWake, speciesNamed,
    fromKept, keptPlace, firstPlace, readAddress, writeAddressSoon,
  };
}
