// The physics of the explorer: a bird, the wake of its leader in both models, the force on a follower, and the strokes
// with which it balances. The same as `upwash.aero`, in SI units; constants come from there. It knows no page, so that
// a worker can run it too.
"use strict";

function makePhysics(constants) {
  const FOUR_PI = 4 * Math.PI;
  const BOTH = 0, DOWNSTROKE = 1, UPSTROKE = 2; // parts of a follower's wingbeat
  const TINY = 1e-24; // of a squared core radius: keeps 0/0 from being formed at a filament's end

  // ---- the bird ----

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

  // ---- the paper's wake: two states of two rings each, felt at the two wingtips ----

  // Height of a wingtip over its tip-to-tip amplitude, ½ at the end of the upstroke (phase 0), −½ at phase ½.
  function strokeHeight(phase) {
    return 2 * Math.abs(phase - Math.floor(phase) - 0.5) - 0.5;
  }

  function makePaperWake(bird, model) {
    const b = bird.semispan_m, half = 0.5 * bird.wavelength, top = 0.5 * bird.amplitude_m;
    const core2 = (model.core_radius_ratio * b) ** 2, run = Math.hypot(half, bird.amplitude_m);
    const wide = constants.roll_up * b, narrow = wide * bird.upstroke_span_ratio;
    const down = bird.circulation / FOUR_PI, up = down * bird.circulation_ratio;
    // By state: where a ring begins, its height there, half its width, its circulation over 4π.
    const rings = [
      [[0, top, narrow, up], [half, -top, wide, down]],
      [[0, -top, wide, down], [half, top, narrow, up]],
    ];
    const wind = new Float64Array(2);

    // Add a weighted ring's velocity at a point to `wind`: v_x and v_z.
    function addRing(x, y, z, weight, ring) {
      const first = ring[0], height = ring[1], width = ring[2], strength = ring[3];
      const x0 = x - first, x1 = x - first - half, z0 = z - height, z1 = z + height;
      const yl = y + width, yr = y - width, yl2 = yl * yl, yr2 = yr * yr, floor = TINY * core2;
      const q0 = x0 * x0 + z0 * z0, q1 = x1 * x1 + z1 * z1;
      const n0l = Math.sqrt(q0 + yl2 + floor), n0r = Math.sqrt(q0 + yr2 + floor);
      const n1l = Math.sqrt(q1 + yl2 + floor), n1r = Math.sqrt(q1 + yr2 + floor);
      const ax = half / run, az = -2 * height / run, d = az * x0 - ax * z0;
      const p0 = ax * x0 + az * z0, p1 = ax * x1 + az * z1;
      const f0 = (yl / n0l - yr / n0r) / Math.max(q0, core2), f1 = (yl / n1l - yr / n1r) / Math.max(q1, core2);
      const fl = (p0 / n0l - p1 / n1l) / Math.max(yl2 + d * d, core2);
      const fr = (p0 / n0r - p1 / n1r) / Math.max(yr2 + d * d, core2);
      const tip = yr * fr - yl * fl;
      wind[0] += weight * strength * (z0 * f0 - z1 * f1 - az * tip);
      wind[1] += weight * strength * (x1 * f1 - x0 * f0 + ax * tip);
    }

    return function forceAt(x, y, z, phase, amplitude, ratio, force, part = BOTH) {
      const lag = phase - Math.floor(phase), together = 0.5 - Math.min(lag, 1 - lag), apart = 0.5 - together;
      force[0] = force[1] = 0;
      for (let state = 0; state < 2; state++) {
        const isUp = state === 0;
        if (part !== BOTH && isUp !== (part === UPSTROKE)) continue;
        const span = isUp ? b * ratio : b, height = z + (isUp ? 0.5 : -0.5) * amplitude;
        wind[0] = wind[1] = 0;
        for (let ahead = 0; ahead < 2; ahead++) {
          const weight = ahead === state ? together : apart;
          if (weight === 0) continue;
          for (const ring of rings[ahead]) {
            addRing(x, y + span, height, weight, ring);
            addRing(x, y - span, height, weight, ring);
          }
        }
        const perWind = bird.density_kg_m3 * bird.circulation * (isUp ? bird.circulation_ratio : 1) * span;
        force[0] += perWind * wind[0];
        force[1] += perWind * wind[1];
      }
      return force;
    };
  }

  // ---- the limit: an endless wake, felt along the whole span in steps of the wingbeat ----

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
    const core2 = (model.core_radius_ratio * b) ** 2, perCore2 = 1 / core2, floor = TINY * core2;
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

    return function forceAt(x, y, z, phase, amplitude, ratio, force, part = BOTH) {
      // Where and when enter through the spatial phase alone, taken in the range for which the windows are made.
      let spatial = x / wavelength - phase;
      spatial -= Math.floor(spatial - constants.least_phase);
      force[0] = force[1] = 0;
      for (const step of steps) {
        if (part !== BOTH && step.isDown !== (part === DOWNSTROKE)) continue;
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

  // Return the function that writes lift and thrust of a leader's wake on a follower, in N, to `force`: in its whole
  // wingbeat or in a part of it.
  function makeWake(bird, model) {
    return model.name === "limit" ? makeEndlessWake(bird, model) : makePaperWake(bird, model);
  }

  // ---- balance ----

  // The shares of weight and drag that a follower lacks (below 0) or has too much, for any stroke at a given place.
  function makeResidual(bird, wake, place) {
    const force = [0, 0];
    return function residual(amplitude, ratio, lacks) {
      wake(place.x, place.y, place.z, place.phase, amplitude, ratio, force);
      lacks[0] = (bird.lift(ratio) + force[0]) / bird.weight - 1;
      lacks[1] = (bird.thrust(amplitude, ratio) + force[1]) / bird.drag - 1;
      return lacks;
    };
  }

  const EXACT = 1e-12, STEP = 1e-6, ROUNDS = 60, DEPTH = 5;

  // Newton's method from a stroke, in (amplitude over semispan, span ratio); null where it finds no balance.
  function polish(residual, semispan, start, bounds) {
    const at = [...start], lacks = [0, 0], aside = [0, 0], tried = [0, 0];
    residual(at[0] * semispan, at[1], lacks);
    let size = Math.hypot(lacks[0], lacks[1]);
    for (let round = 0; round < ROUNDS && size > 1e-15; round++) {
      residual((at[0] + STEP) * semispan, at[1], aside);
      const a = (aside[0] - lacks[0]) / STEP, c = (aside[1] - lacks[1]) / STEP;
      residual(at[0] * semispan, at[1] + STEP, aside);
      const b = (aside[0] - lacks[0]) / STEP, d = (aside[1] - lacks[1]) / STEP, determinant = a * d - b * c;
      if (!(Math.abs(determinant) > 1e-12)) return null;
      const byAmplitude = (b * lacks[1] - d * lacks[0]) / determinant, byRatio = (c * lacks[0] - a * lacks[1]) / determinant;
      let share = Math.min(1, 0.5 / Math.max(Math.abs(byAmplitude), 2 * Math.abs(byRatio), 1e-300)), isBetter = false;
      for (let cut = 0; cut < 12 && !isBetter; cut++, share *= 0.5) {
        const h = at[0] + share * byAmplitude, ratio = at[1] + share * byRatio;
        residual(h * semispan, ratio, tried);
        const now = Math.hypot(tried[0], tried[1]);
        if (now < size) {
          [at[0], at[1], size, isBetter] = [h, ratio, now, true];
          [lacks[0], lacks[1]] = tried;
        }
      }
      if (!isBetter) break;
    }
    const [low, high] = bounds, slack = 1e-10;
    const isInside = at.every((value, i) => value >= low[i] - slack && value <= high[i] + slack);
    return size < EXACT && isInside ? at : null;
  }

  // Whether both balances change sign between the corners of a cell.
  function holds(corners) {
    return [0, 1].every((i) => corners.some((one) => one[i] <= 0) && corners.some((one) => one[i] >= 0));
  }

  // Where in a cell, from −1 to 1 each way, the planes through its corners balance; null if that is too far outside, and
  // the middle where they lie too much alike to tell.
  function predict([a, b, c, d]) {
    const middle = [0, 1].map((i) => (a[i] + b[i] + c[i] + d[i]) / 4);
    const across = [0, 1].map((i) => (b[i] + d[i] - a[i] - c[i]) / 4), up = [0, 1].map((i) => (c[i] + d[i] - a[i] - b[i]) / 4);
    const isFar = [0, 1].some((i) => Math.abs(middle[i]) > 2 * (Math.abs(across[i]) + Math.abs(up[i])));
    if (isFar) return null;
    const determinant = across[0] * up[1] - across[1] * up[0];
    if (Math.abs(determinant) < 0.1 * Math.hypot(...across) * Math.hypot(...up)) return [0, 0];
    const at = [(up[0] * middle[1] - up[1] * middle[0]) / determinant, (across[1] * middle[0] - across[0] * middle[1]) / determinant];
    return Math.max(Math.abs(at[0]), Math.abs(at[1])) < 1.6 ? at : null;
  }

  // All strokes within bounds with which a follower at a place balances, the cheapest first: amplitude in m, span ratio
  // and cost. The plane of strokes is laid out in cells; Newton's method starts where the planes through a cell's
  // corners balance, and a cell that holds a change of sign of both and gave nothing is cut in four.
  function balances(bird, model, wake, place, weights) {
    const residual = makeResidual(bird, wake, place), b = bird.semispan_m, bounds = constants.stroke_bounds;
    const [[lowH, lowR], [highH, highR]] = bounds, [fewest, up] = constants.stroke_grid[model.name];
    // Where a wingtip may cross a core, which is felt in points, no step in amplitude is longer than half its radius.
    const across = model.name === "limit" ? fewest : Math.max(fewest, Math.ceil((highH - lowH) / (0.5 * model.core_radius_ratio)));
    const found = [], h = (i) => lowH + (highH - lowH) * i / across, r = (j) => lowR + (highR - lowR) * j / up;
    const value = (amplitude, ratio) => [...residual(amplitude * b, ratio, [0, 0])];

    function keep(start) {
      const at = polish(residual, b, start, bounds);
      if (at && !found.some((one) => Math.abs(one[0] - at[0]) < 1e-7 && Math.abs(one[1] - at[1]) < 1e-7)) found.push(at);
      return at;
    }

    function look(h0, h1, r0, r1, corners, depth) {
      const isHeld = holds(corners), near = predict(corners) ?? (isHeld ? [0, 0] : null);
      if (near === null) return;
      const middle = [0.5 * (h0 + h1), 0.5 * (r0 + r1)];
      const at = keep([middle[0] + 0.5 * near[0] * (h1 - h0), middle[1] + 0.5 * near[1] * (r1 - r0)]);
      // One that was led away may have passed by another.
      const isInside = at && at[0] >= h0 && at[0] <= h1 && at[1] >= r0 && at[1] <= r1;
      if (isInside || !isHeld || depth === 0) return;
      const bottom = value(middle[0], r0), top = value(middle[0], r1), left = value(h0, middle[1]), right = value(h1, middle[1]);
      const centre = value(...middle), [a, b2, c, d] = corners;
      for (const [x0, x1, y0, y1, four] of [
        [h0, middle[0], r0, middle[1], [a, bottom, left, centre]],
        [middle[0], h1, r0, middle[1], [bottom, b2, centre, right]],
        [h0, middle[0], middle[1], r1, [left, centre, c, top]],
        [middle[0], h1, middle[1], r1, [centre, right, top, d]],
      ]) if (holds(four)) look(x0, x1, y0, y1, four, depth - 1);
    }

    const row = strokeRows(bird, model, wake, place, across, h);
    for (let j = 0, before = null; j <= up; j++) {
      const now = row(r(j));
      for (let i = 0; before && i < across; i++) {
        look(h(i), h(i + 1), r(j - 1), r(j), [before[i], before[i + 1], now[i], now[i + 1]], DEPTH);
      }
      before = now;
    }
    return found
      .map(([amplitude, ratio]) => strokeOf(bird, weights, amplitude * b, ratio))
      .sort((one, other) => one.cost - other.cost);
  }

  // Return the function that gives what is lacked with all amplitudes and one span ratio. On the downstroke the wing is
  // outstretched whatever the ratio, so that its part is found once, unless the span goes by the tip's height.
  function strokeRows(bird, model, wake, place, across, h) {
    const residual = makeResidual(bird, wake, place), b = bird.semispan_m;
    const columns = Array.from({ length: across + 1 }, (_, i) => h(i) * b), force = [0, 0];
    if (model.name === "limit" && model.span_law === "tip") {
      return (ratio) => columns.map((amplitude) => [...residual(amplitude, ratio, [0, 0])]);
    }
    const of = (amplitude, ratio, part) => [...wake(place.x, place.y, place.z, place.phase, amplitude, ratio, force, part)];
    const downs = columns.map((amplitude) => of(amplitude, 1, DOWNSTROKE));
    return (ratio) => columns.map((amplitude, i) => {
      const up = of(amplitude, ratio, UPSTROKE);
      return [
        (bird.lift(ratio) + downs[i][0] + up[0]) / bird.weight - 1,
        (bird.thrust(amplitude, ratio) + downs[i][1] + up[1]) / bird.drag - 1,
      ];
    });
  }

  function strokeOf(bird, weights, amplitude, ratio) {
    return { amplitude, ratio, cost: cost(bird, weights, bird.lift(ratio), bird.thrust(amplitude, ratio)) };
  }

  // The balance that lies nearest to a stroke, or null: what a follower that is moved a little goes on with.
  function follow(bird, wake, place, weights, stroke) {
    const at = polish(makeResidual(bird, wake, place), bird.semispan_m, [stroke.amplitude / bird.semispan_m, stroke.ratio], constants.stroke_bounds);
    return at && strokeOf(bird, weights, at[0] * bird.semispan_m, at[1]);
  }

  // The stroke within bounds that comes nearest to balance, where none does.
  function nearest(bird, wake, place) {
    const residual = makeResidual(bird, wake, place), b = bird.semispan_m, lacks = [0, 0];
    const [low, high] = constants.stroke_bounds;
    const miss = (h, r) => (residual(h * b, r, lacks), Math.hypot(lacks[0], lacks[1]));
    let best = [low[0], low[1]], least = Infinity, reach = [(high[0] - low[0]) / 2, (high[1] - low[1]) / 2];
    let centre = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    for (let round = 0; round < 12; round++) {
      for (let i = -3; i <= 3; i++) {
        for (let j = -3; j <= 3; j++) {
          const at = [centre[0] + reach[0] * i / 3, centre[1] + reach[1] * j / 3].map((one, k) => Math.min(high[k], Math.max(low[k], one)));
          const now = miss(...at);
          if (now < least) [best, least] = [at, now];
        }
      }
      centre = best;
      reach = reach.map((one) => 0.5 * one);
    }
    return { amplitude: best[0] * b, ratio: best[1] };
  }

  // Share of the lone bird's cost that a stroke saves.
  function saving(bird, weights, stroke) {
    return 1 - stroke.cost / cost(bird, weights, bird.weight, bird.drag);
  }

  return { makeBird, makeWake, power, cost, strokeHeight, stepsNeeded, makeResidual, balances, follow, nearest, saving };
}
