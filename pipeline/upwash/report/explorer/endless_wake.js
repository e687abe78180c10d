// The limit: an endless wake, felt along the whole span in steps of the wingbeat. The same as `upwash.aero.endless`.
"use strict";

function makeEndlessWakes(constants) {
  const FOUR_PI = 4 * Math.PI, END_FLOOR = constants.end_floor; // keeps 0/0 from being formed at a filament's end

  // Height of a wingtip over its tip-to-tip amplitude, ½ at the end of the upstroke (phase 0), −½ at phase ½.
  function strokeHeight(phase) {
    return 2 * Math.abs(phase - Math.floor(phase) - 0.5) - 0.5;
  }

  // Nodes and weights of Gauss and Legendre's rule in (−1, 1), by Newton's method on the polynomial.
  function gaussLegendre(count) {
    const nodes = new Float64Array(count), weights = new Float64Array(count);
    for (let i = 0; i < count; i++) {
      let x = -Math.cos(Math.PI * (i + 0.75) / (count + 0.5)), slope = 1;
      for (let round = 0; round < 100; round++) {
        let [before, value] = [0, 1];
        for (let k = 1; k <= count; k++) [before, value] = [value, ((2 * k - 1) * x * value - (k - 1) * before) / k];
        slope = count * (x * value - before) / (x * x - 1);
        const step = value / slope;
        x -= step;
        if (Math.abs(step) < 1e-16) break;
      }
      nodes[i] = x;
      weights[i] = 2 / ((1 - x * x) * slope * slope);
    }
    return [nodes, weights];
  }

  // How many steps a wavelength needs: none carries the wing further along the wake than some core radii.
  function stepsNeeded(bird, model) {
    const needed = Math.ceil(bird.wavelength / bird.semispan_m / (constants.step_in_cores * model.core_radius_ratio));
    return Math.max(model.stroke_states, needed + needed % 2);
  }

  // The steps of a wingbeat, downstroke first: phase, share of the wingbeat, height of the tip, how far it is flexed.
  function wingbeatSteps(bird, model) {
    const [nodes, weights] = gaussLegendre(stepsNeeded(bird, model) / 2), steps = [];
    for (const isDown of [true, false]) {
      nodes.forEach((node, i) => {
        const phase = 0.25 * (node + (isDown ? 1 : 3)), height = strokeHeight(phase);
        const flexed = model.span_law === "tip" ? height + 0.5 : isDown ? 0 : 1;
        steps.push({ isDown, phase, weight: 0.25 * weights[i], height, flexed });
      });
    }
    return steps;
  }

  // The endless wake as felt on one half stroke: runs around the window's middle, and the mean of what is beyond.
  function endlessWindow(bird, onDownstroke) {
    const { wavelength, amplitude_m: amplitude } = bird, half = 0.5 * wavelength, quarter = 0.25 * wavelength;
    const kinds = [], tails = [];
    for (const isDown of [true, false]) {
      const tilt = isDown ? 1 : -1, rise = 0.5 * tilt * amplitude;
      const width = constants.roll_up * bird.semispan_m * (isDown ? 1 : bird.upstroke_span_ratio);
      const strength = bird.circulation * (isDown ? 1 : bird.circulation_ratio) / FOUR_PI;
      const centre = isDown === onDownstroke ? -quarter : quarter;
      const begin = centre > 0 ? centre - quarter : centre - quarter + wavelength;
      const length = Math.hypot(half, amplitude);
      const firsts = Float64Array.from({ length: 2 * constants.reach }, (_, i) => begin + (i - constants.reach) * wavelength);
      kinds.push({ firsts, rise, width, strength, ax: half / length, az: 2 * rise / length });
      for (const side of [1, -1]) {
        const slope = side * tilt * amplitude;
        const lacks = centre > 0 === side > 0 ? quarter : 3 * quarter;
        const stretched = -slope * wavelength / 32;
        const spread = -slope * wavelength / 48 + slope * amplitude ** 2 / (24 * wavelength);
        tails.push({
          side, start: constants.reach * wavelength + lacks - half, width, strength, source: slope / wavelength,
          curved: wavelength ** 2 / 64 + amplitude ** 2 / 16, stretched: stretched - spread, spread,
        });
      }
    }
    return { middle: onDownstroke ? 0 : -0.5, kinds, tails };
  }

  function makeEndlessWake(bird, model) {
    const b = bird.semispan_m, { wavelength } = bird, half = 0.5 * wavelength;
    const core2 = (model.core_radius_ratio * b) ** 2, perCore2 = 1 / core2, floor = END_FLOOR * core2;
    const windows = [endlessWindow(bird, true), endlessWindow(bird, false)];
    const steps = wingbeatSteps(bird, model).map((step) => ({
      ...step,
      window: windows[step.isDown ? 0 : 1],
      perWind: step.weight * bird.density_kg_m3 * bird.circulation * (1 + (bird.circulation_ratio - 1) * step.flexed),
    }));
    const wind = new Float64Array(2);
    // What one end of the wing gives at the first and the last station of a run, and along its tip filaments: beside a
    // logarithm, and the argument of that as a fraction.
    const end = new Float64Array(5), [FIRST, LAST, BESIDE, TOP, LOW] = [0, 1, 2, 3, 4];

    function fillEnd(p0, p1, d2, q0, q1, yl, yr) {
      const yl2 = yl * yl, yr2 = yr * yr, rl = yl2 + d2, rr = yr2 + d2;
      const n0l = Math.sqrt(q0 + yl2), n0r = Math.sqrt(q0 + yr2), n1l = Math.sqrt(q1 + yl2), n1r = Math.sqrt(q1 + yr2);
      end[FIRST] = n0l - n0r;
      end[LAST] = n1l - n1r;
      let v0l = n0l, v0r = n0r, v1l = n1l, v1r = n1r, ml = rl, mr = rr, beside = 0;
      // Within the core of a tip filament.
      if (rl < core2) {
        ml = core2;
        v0l = Math.sqrt(p0 * p0 + core2);
        v1l = Math.sqrt(p1 * p1 + core2);
        beside += p1 * (n1l - v1l) - p0 * (n0l - v0l);
      }
      if (rr < core2) {
        mr = core2;
        v0r = Math.sqrt(p0 * p0 + core2);
        v1r = Math.sqrt(p1 * p1 + core2);
        beside += p0 * (n0r - v0r) - p1 * (n1r - v1r);
      }
      end[BESIDE] = beside;
      // (p₀ + v₀l)(p₁ + v₁r) / (p₁ + v₁l)(p₀ + v₀r), each factor written so that it does not cancel where p < 0.
      if (p1 > 0) {
        end[TOP] = (p0 + v0l) * (p1 + v1r);
        end[LOW] = (p1 + v1l) * (p0 + v0r);
      } else if (p0 > 0) {
        end[TOP] = (p0 + v0l) * (v1l - p1) * mr;
        end[LOW] = (v1r - p1) * (p0 + v0r) * ml;
      } else {
        end[TOP] = (v0r - p0) * (v1l - p1);
        end[LOW] = (v1r - p1) * (v0l - p0);
      }
    }

    // Add to `wind` the integral over y of the velocity of all runs of a kind, from the left end to the right.
    function addRuns(x, z, right, left, { firsts, rise, width, strength, ax, az }) {
      const z0 = z + rise, z1 = z - rise;
      let gx = 0, gz = 0, tops = 1, lows = 1, along = 0;
      for (let i = 0; i < firsts.length; i++) {
        const x0 = x - firsts[i], x1 = x0 - half, q0 = x0 * x0 + z0 * z0 + floor, q1 = x1 * x1 + z1 * z1 + floor;
        const d = az * x0 - ax * z0, p0 = ax * x0 + az * z0, p1 = ax * x1 + az * z1, d2 = d * d;
        fillEnd(p0, p1, d2, q0, q1, right + width, right - width);
        let s0 = end[FIRST], s1 = end[LAST];
        along += end[BESIDE];
        tops *= end[TOP];
        lows *= end[LOW];
        fillEnd(p0, p1, d2, q0, q1, left + width, left - width);
        s0 = (s0 - end[FIRST]) / Math.max(q0, core2);
        s1 = (s1 - end[LAST]) / Math.max(q1, core2);
        along -= end[BESIDE];
        tops *= end[LOW];
        lows *= end[TOP];
        gx += z0 * s0 - z1 * s1;
        gz += x1 * s1 - x0 * s0;
      }
      const tip = Math.log(tops / lows) + along * perCore2;
      wind[0] += strength * (gx - az * tip);
      wind[1] += strength * (gz + ax * tip);
    }

    // As `addRuns`, of what is beyond one end of the window.
    function addTail(x, z, right, left, tail) {
      const xi = tail.side * x - tail.start, q = xi * xi + z * z, u = 1 / q, w = tail.width;
      const nrl = Math.sqrt(q + (right + w) ** 2), nrr = Math.sqrt(q + (right - w) ** 2);
      const nll = Math.sqrt(q + (left + w) ** 2), nlr = Math.sqrt(q + (left - w) ** 2);
      const m0 = nrl - nrr - nll + nlr, irl = 1 / nrl, irr = 1 / nrr, ill = 1 / nll, ilr = 1 / nlr;
      const m1 = irl - irr - ill + ilr, m2 = irl ** 3 - irr ** 3 - ill ** 3 + ilr ** 3;
      const log = Math.log((nrl - xi) * (nlr - xi) / ((nrr - xi) * (nll - xi)));
      const g1 = -0.5 * m0 * u, g2 = (-0.25 * m1 + 0.5 * m0 * u) * u, g3 = (0.125 * m2 + (0.5 * m1 - m0 * u) * u) * u;
      const ix = 2 * xi * g1, iz = 2 * z * g1;
      const ixxz = (4 * g2 + 8 * xi * xi * g3) * z, ixzz = (4 * g2 + 8 * z * z * g3) * xi, ixxx = (12 * g2 + 8 * xi * xi * g3) * xi;
      const byX = -0.5 * iz + tail.source * ix + tail.curved * ixxz + tail.stretched * ixxx + tail.spread * xi * m2;
      const byZ = 0.5 * (ix - log) + tail.source * iz + tail.curved * ixzz + tail.stretched * ixxz + tail.spread * z * m2;
      wind[0] += tail.side * tail.strength * byX;
      wind[1] += tail.strength * byZ;
    }

    return function forceAt(x, y, z, phase, amplitude, ratio, force, part = null) {
      // Where and when enter through the spatial phase alone, taken in the range for which the windows are made.
      let spatial = x / wavelength - phase;
      spatial -= Math.floor(spatial - constants.least_phase);
      force[0] = force[1] = 0;
      for (const step of steps) {
        if (part && step.isDown !== (part === "downstroke")) continue;
        const span = b * (1 - step.flexed + step.flexed * ratio);
        const at = wavelength * (spatial - step.phase - step.window.middle), height = z + amplitude * step.height;
        wind[0] = wind[1] = 0;
        for (const kind of step.window.kinds) addRuns(at, height, y + span, y - span, kind);
        for (const tail of step.window.tails) addTail(at, height, y + span, y - span, tail);
        force[0] += step.perWind * wind[0];
        force[1] += step.perWind * wind[1];
      }
      return force;
    };
  }

  return makeEndlessWake;
}
