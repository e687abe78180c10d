// The paper's wake: two states of two rings each, felt at the two wingtips. The same as `upwash.aero`'s named "paper".
"use strict";

function makePaperWakes(constants) {
  const FOUR_PI = 4 * Math.PI, END_FLOOR = constants.end_floor; // keeps 0/0 from being formed at a filament's end

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
      const yl = y + width, yr = y - width, yl2 = yl * yl, yr2 = yr * yr, floor = END_FLOOR * core2;
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

    return function forceAt(x, y, z, phase, amplitude, ratio, force, part = null) {
      const lag = phase - Math.floor(phase), together = 0.5 - Math.min(lag, 1 - lag), apart = 0.5 - together;
      force[0] = force[1] = 0;
      for (let state = 0; state < 2; state++) {
        const isUp = state === 0;
        if (part && isUp !== (part === "upstroke")) continue;
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

  return makePaperWake;
}
