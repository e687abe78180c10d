// The map of savings over the plane of x and y, at one height and phase, the stroke solved at each place: in three
// grids, each twice as fine as the one before. It runs in a worker.
"use strict";

function makeMap(physics) {
  // What a place of the map holds instead of a saving: it was not looked at yet, or no stroke balances there.
  const UNKNOWN = 9, NO_BALANCE = 8;

  // Call `show` with (values, stride, share done) as it goes, values row by row from y = 0 outwards, x along a row.
  function mapSavings({ inputs, model, weights, z, phase, xs, ys }, show) {
    const bird = physics.makeBird(inputs), wake = physics.makeWake(bird, model);
    const columns = xs.length, values = new Float64Array(columns * ys.length).fill(UNKNOWN), strokes = new Array(values.length);

    function solve(i, j, stride) {
      const place = { x: xs[i], y: ys[j], z, phase };
      // Behind an endless wake neighbours balance alike: what two of them lead to, where it is the same, is the cheapest.
      if (model.name === "limit" && stride < 4) {
        const near = [[i - stride, j], [i + stride, j], [i, j - stride], [i, j + stride]]
          .filter(([a, c]) => a >= 0 && c >= 0 && a < columns && c < ys.length && strokes[a + c * columns] !== undefined)
          .map(([a, c]) => strokes[a + c * columns]);
        if (near.length > 1 && near.every((one) => one)) {
          const led = near.slice(0, 2).map((one) => physics.follow(bird, wake, place, weights, one));
          if (led.every((one) => one && Math.abs(one.amplitude - led[0].amplitude) < 1e-8 * bird.semispan_m)) return led[0];
        }
      }
      return physics.balances(bird, model, wake, place, weights)[0] ?? null;
    }

    for (const stride of [4, 2, 1]) {
      for (let j = 0; j < ys.length; j += stride) {
        for (let i = 0; i < columns; i += stride) {
          const at = i + j * columns;
          if (strokes[at] !== undefined) continue;
          strokes[at] = solve(i, j, stride);
          values[at] = strokes[at] ? physics.saving(bird, weights, strokes[at]) : NO_BALANCE;
        }
        show(values, stride, (j + 1) / ys.length);
      }
    }
    return values;
  }

  return { mapSavings, UNKNOWN, NO_BALANCE };
}

// What the worker is made of, beside the functions above.
function mapWorker(constants) {
  const { mapSavings } = makeMap(makePhysics(constants));
  let told = 0;
  onmessage = ({ data }) => {
    mapSavings(data, (values, stride, done) => {
      if (done < 1 && performance.now() - told < 150) return;
      told = performance.now();
      postMessage({ values, stride, done });
    });
    postMessage({ values: null, stride: 0, done: 1 });
  };
}
