// Birds and wakes as lines: seen from above, from the side and from behind, in semispans.
"use strict";

const Drawing = (() => {
  const RAMP = 0.09; // part of a wingbeat in which a drawn wing is flexed or stretched

  // Height of the tip over the amplitude, and how far the wing is flexed, at a phase of the bird's wingbeat.
  function pose(phase, spanLaw) {
    const turn = phase - Math.floor(phase), height = 2 * Math.abs(turn - 0.5) - 0.5;
    if (spanLaw === "tip") return { height, flexed: height + 0.5 };
    const ease = (share) => { const s = Math.min(1, Math.max(0, share)); return s * s * (3 - 2 * s); };
    return { height, flexed: ease((turn - 0.5) / RAMP + 0.5) - ease((turn - 1) / RAMP + 0.5) + ease(0.5 - turn / RAMP) };
  }

  const round = (value) => Math.round(value * 1e4) / 1e4;

  // A closed curve through points (Catmull and Rom's), in a view's coordinates; all turn alike, so that what overlaps is
  // filled.
  function curve(points, project) {
    const flat = points.map(project), n = flat.length;
    const area = flat.reduce((sum, [x, y], i) => sum + x * flat[(i + 1) % n][1] - y * flat[(i + 1) % n][0], 0);
    if (area < 0) flat.reverse();
    let path = `M${round(flat[0][0])} ${round(flat[0][1])}`;
    for (let i = 0; i < n; i++) {
      const [a, b, c, d] = [flat[(i + n - 1) % n], flat[i], flat[(i + 1) % n], flat[(i + 2) % n]];
      path += `C${round(b[0] + (c[0] - a[0]) / 7)} ${round(b[1] + (c[1] - a[1]) / 7)} ${round(c[0] - (d[0] - b[0]) / 7)} ${round(c[1] - (d[1] - b[1]) / 7)} ${round(c[0])} ${round(c[1])}`;
    }
    return path + "Z";
  }

  const BODY_ABOVE = [[-0.5, 0], [-0.41, 0.022], [-0.36, 0.042], [-0.29, 0.034], [-0.2, 0.062], [0, 0.085], [0.2, 0.055], [0.3, 0.045], [0.47, 0.1], [0.5, 0.05]];

  // Outline of body and of both wings, from above: x downstream, y to the right. The wing bends at its wrist.
  function above([x, y], half, flexed, project) {
    const both = [...BODY_ABOVE, ...BODY_ABOVE.slice(1).reverse().map(([a, b]) => [a, -b])];
    const wing = [
      [-0.19, 0.03], [-0.25 - 0.05 * flexed, 0.28 * half], [-0.28 - 0.09 * flexed, 0.5 * half], [-0.19, 0.74 * half],
      [0.0 + 0.2 * flexed, half], [0.06 + 0.2 * flexed, 0.93 * half], [0.07 + 0.1 * flexed, 0.68 * half], [0.1, 0.42 * half], [0.13, 0.2 * half], [0.15, 0.03],
    ];
    return [both, wing, wing.map(([a, b]) => [a, -b])]
      .map((part) => curve(part.map(([a, b]) => [x + a, y + b]), project)).join("");
  }

  const BODY_SIDE = [
    [-0.52, 0.025], [-0.43, 0.052], [-0.385, 0.085], [-0.335, 0.08], [-0.28, 0.05], [-0.15, 0.075], [0.03, 0.08], [0.25, 0.045], [0.5, 0.05],
    [0.5, 0.02], [0.25, -0.02], [0.05, -0.085], [-0.15, -0.075], [-0.27, -0.01], [-0.34, 0.022], [-0.42, 0.032],
  ];

  // From the side: x downstream, z up.
  function side([x, z], tip, flexed, project) {
    const sweep = 0.18 * flexed;
    const wing = [[-0.2, 0.04], [-0.22, 0.55 * tip + 0.04], [-0.06 + sweep, tip], [0.06 + sweep, 0.8 * tip], [0.1, 0.4 * tip + 0.02], [0.16, 0.03]];
    const move = (part) => curve(part.map(([a, b]) => [x + a, z + b]), project);
    return move(BODY_SIDE) + move(wing);
  }

  // From behind: y to the right, z up.
  function behind([y, z], half, tip, project) {
    const body = [[0, 0.085], [0.05, 0.06], [0.085, 0], [0.06, -0.065], [0, -0.09], [-0.06, -0.065], [-0.085, 0], [-0.05, 0.06]];
    const wing = [
      [0.03, 0.05], [0.28 * half, 0.42 * tip + 0.05], [0.55 * half, 0.72 * tip + 0.04], [half, tip],
      [0.55 * half, 0.68 * tip - 0.01], [0.28 * half, 0.36 * tip - 0.02], [0.04, -0.01],
    ];
    const tail = [[-0.1, 0.012], [0.1, 0.012], [0.12, -0.014], [-0.12, -0.014]];
    return [body, wing, wing.map(([a, b]) => [-a, b]), tail]
      .map((part) => curve(part.map(([a, b]) => [y + a, z + b]), project)).join("");
  }

  // The rings of a leader's wake at a time, between two stations: closed rectangles, cut at those.
  function rings({ time, wavelength, amplitude, ratio, rollUp, from, to }) {
    const found = [], height = (x) => { const turn = x / wavelength - time; return amplitude * (2 * Math.abs(turn - Math.floor(turn) - 0.5) - 0.5); };
    const first = Math.floor(2 * (from / wavelength - time)), last = Math.ceil(2 * (to / wavelength - time));
    for (let k = first; k < last; k++) {
      const x0 = Math.max(from, (time + k / 2) * wavelength), x1 = Math.min(to, (time + (k + 1) / 2) * wavelength);
      if (x1 - x0 < 1e-9 * wavelength) continue;
      const isUp = k % 2 === 0;
      // Just within, where the height does not turn.
      const inset = 1e-9 * (x1 - x0);
      found.push({ isUp, x0, x1, z0: height(x0 + inset), z1: height(x1 - inset), width: rollUp * (isUp ? ratio : 1) });
    }
    return found;
  }

  function line(points, project, isClosed) {
    return "M" + points.map((one) => project(one).map(round).join(" ")).join("L") + (isClosed ? "Z" : "");
  }

  return { pose, above, side, behind, rings, line };
})();
