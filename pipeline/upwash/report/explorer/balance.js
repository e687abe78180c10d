// The strokes with which a follower balances at a given place: all of them, the one that follows another as it moves, and
// the one that comes nearest where none does.
"use strict";

function makeBalances(constants, { strokeOf }) {
  const EXACT = 1e-12, STEP = 1e-6, ROUNDS = 60, DEPTH = 5;

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
    const downs = columns.map((amplitude) => of(amplitude, 1, "downstroke"));
    return (ratio) => columns.map((amplitude, i) => {
      const up = of(amplitude, ratio, "upstroke");
      return [
        (bird.lift(ratio) + downs[i][0] + up[0]) / bird.weight - 1,
        (bird.thrust(amplitude, ratio) + downs[i][1] + up[1]) / bird.drag - 1,
      ];
    });
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

  return { makeResidual, balances, follow, nearest };
}
