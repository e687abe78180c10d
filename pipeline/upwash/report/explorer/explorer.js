// The page: what is chosen, what follows from it, and how it is shown. Lengths are in m, in pictures in semispans.
"use strict";

(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const physics = makePhysics(data.constants), { UNKNOWN, NO_BALANCE } = makeMap(physics);
  const weights = data.objective.weights;
  const byId = (name) => document.getElementById(name);
  const SVG = "http://www.w3.org/2000/svg";
  const lessMotion = matchMedia("(prefers-reduced-motion: reduce)");

  // ---- numbers in words ----

  const number = (value, digits) => {
    const text = value.toFixed(digits);
    return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
  };
  const metres = (value) => `${number(value, Math.abs(value) < 0.995 && semispan() < 0.4 ? 3 : 2)}\u00a0m`;
  const percent = (share, digits = 1) => `${number(100 * share, digits)}\u00a0%`;
  const semispan = () => now.bird.semispan_m;

  // ---- what is chosen, and what follows ----

  const KEYS = ["species", "model", "law", "x", "y", "z", "phase", "amplitude", "ratio", "speed", "core", "adapting"];
  const state = {};
  // The bird, its model and wake; the strokes that balance where it was last looked for; what is found.
  const now = { solutions: [], isComplete: false };
  let isPlaying = false, isDragging = false, time = 0.12, waiting = 0;

  const speciesNamed = (slug) => data.species.find((one) => one.slug === slug);
  const modelOf = () => ({ name: state.model, core_radius_ratio: state.core, span_law: state.law, stroke_states: 32 });

  function makeBirdAndWake() {
    now.species = speciesNamed(state.species);
    now.inputs = { ...now.species.bird, speed_m_s: state.speed };
    now.bird = physics.makeBird(now.inputs);
    now.model = modelOf();
    now.wake = physics.makeWake(now.bird, now.model);
    clearMap();
  }

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

  // Follow a balance while something moves, and look for all of them once it rests.
  function moved() {
    now.solutions = [];
    now.isComplete = false;
    clearTimeout(waiting);
    if (state.adapting) {
      const stroke = physics.follow(now.bird, now.wake, placeNow(), weights, state);
      if (stroke) useStroke(stroke);
      waiting = setTimeout(() => { adapt(); show(); }, stroke ? 250 : 90);
    }
    show();
  }

  const clamp = (value, [low, high]) => Math.min(high, Math.max(low, value));

  function limits() {
    const b = now.species.bird.semispan_m, wavelength = (state.speed ?? 0) * now.species.bird.period_s;
    const own = now.species.bird.speed_m_s, [[lowH, lowR], [highH, highR]] = data.constants.stroke_bounds;
    return {
      x: [0, 1.25 * wavelength, b / 60], y: [(LOWEST + 0.15) * b, 2.6 * b, b / 60], z: [-1.1 * b, 1.1 * b, b / 60],
      phase: [0, 1, 0.01], amplitude: [lowH * b, highH * b, b / 120], ratio: [lowR, highR, 0.005],
      speed: [0.6 * own, 1.6 * own, 0.1], core: [0.05, 0.3, 0.001],
    };
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

  // ---- the views ----

  const part = (parent, name, attributes = {}) => {
    const one = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    parent.append(one);
    return one;
  };
  const SCALE = 100; // units of a picture per semispan
  const LOWEST = -2; // how far to the left the views reach, in semispans

  class View {
    // `across` and `up` name the two coordinates that are seen.
    constructor(name, across, up) {
      this.svg = byId(name);
      [this.name, this.across, this.up] = [name, across, up];
      const hatch = part(part(this.svg, "defs"), "pattern", { id: `${name}-hatch`, width: 9, height: 9, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" });
      part(hatch, "line", { x1: 0, x2: 0, y1: 0, y2: 9, class: "hatch" });
      this.zone = part(this.svg, "rect", { class: "zone", fill: `url(#${name}-hatch)` });
      this.image = part(this.svg, "image", { preserveAspectRatio: "none", class: "mapped" });
      this.axes = part(this.svg, "g", { class: "axes" });
      this.wake = part(this.svg, "g", { class: "wake", "aria-hidden": "true" });
      this.marks = part(this.svg, "g", { class: "marks" });
      this.leader = part(this.svg, "path", { class: "leader" });
      this.handle = part(this.svg, "g", {
        class: "handle", tabindex: 0, role: "slider", "aria-roledescription": "follower to move", "aria-label": `Follower, ${HEARD[name]}`,
      });
      this.halo = part(this.handle, "circle", { class: "halo" });
      this.follower = part(this.handle, "path", { class: "follower" });
      this.words = part(this.svg, "g", { class: "words", "aria-hidden": "true" });
      this.labels = { leader: part(this.words, "text"), follower: part(this.words, "text") };
      this.listen();
    }

    size([left, right], [low, high]) {
      Object.assign(this, { left, right, low, high });
      this.svg.setAttribute("viewBox", `${left * SCALE} ${-high * SCALE} ${(right - left) * SCALE} ${(high - low) * SCALE}`);
      for (const [key, value] of Object.entries({ x: 0, y: -high * SCALE, width: right * SCALE, height: (high - low) * SCALE })) this.zone.setAttribute(key, value);
      this.measure();
    }

    // How many units of the picture a pixel of the screen is, for text and handles that keep their size.
    measure() {
      this.pixel = (this.right - this.left) * SCALE / Math.max(1, this.svg.clientWidth);
      this.svg.style.setProperty("--pixel", this.pixel);
      this.halo.setAttribute("r", Math.max(0.42 * SCALE, 24 * this.pixel));
      this.drawAxes();
    }

    project = ([x, y]) => [x * SCALE, -y * SCALE];

    drawAxes() {
      this.axes.replaceChildren();
      const line = (x1, y1, x2, y2, name) => part(this.axes, "line", { x1: x1 * SCALE, y1: -y1 * SCALE, x2: x2 * SCALE, y2: -y2 * SCALE, class: name });
      line(this.left, 0, this.right, 0, "axis");
      line(0, this.low, 0, this.high, "axis");
      // A length to go by: a metre, or what of it is about a semispan.
      const b = semispan(), length = [5, 2, 1, 0.5, 0.2, 0.1, 0.05].find((one) => one <= 1.6 * b), edge = 12 * this.pixel / SCALE;
      const y = this.low + edge, x = this.right - edge;
      line(x - length / b, y, x, y, "length");
      const text = part(this.axes, "text", { x: (x - length / b / 2) * SCALE, y: -(y + 0.5 * edge) * SCALE, "text-anchor": "middle" });
      text.textContent = `${length} m`;
    }

    listen() {
      const move = (event) => {
        const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
        moveTo({ [this.across]: (at.x / SCALE - this.grip[0]) * semispan(), [this.up]: (-at.y / SCALE - this.grip[1]) * semispan() });
      };
      this.handle.addEventListener("pointerdown", (event) => {
        this.handle.setPointerCapture(event.pointerId);
        this.handle.focus({ preventScroll: true });
        const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
        this.grip = [at.x / SCALE - state[this.across] / semispan(), -at.y / SCALE - state[this.up] / semispan()];
        isDragging = true;
        event.preventDefault();
      });
      this.handle.addEventListener("pointermove", (event) => { if (this.handle.hasPointerCapture(event.pointerId)) move(event); });
      for (const name of ["pointerup", "pointercancel"]) this.handle.addEventListener(name, () => { isDragging = false; announceSoon(); });
      // A touch or click elsewhere takes the follower there.
      this.svg.addEventListener("click", (event) => {
        if (this.handle.contains(event.target)) return;
        this.grip = [0, 0];
        move(event);
        announceSoon();
      });
      this.handle.addEventListener("keydown", (event) => {
        const step = limits()[this.across][2] * (event.shiftKey ? 10 : 1);
        const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
        if (!by) return;
        event.preventDefault();
        moveTo({ [this.across]: state[this.across] + by[0], [this.up]: state[this.up] + by[1] });
        announceSoon();
      });
    }

    drawWake(paths) {
      while (this.wake.childNodes.length < paths.length) part(this.wake, "path");
      while (this.wake.childNodes.length > paths.length) this.wake.lastChild.remove();
      paths.forEach(([look, path], i) => {
        const one = this.wake.childNodes[i];
        if (one.getAttribute("class") !== look) one.setAttribute("class", look);
        one.setAttribute("d", path);
      });
    }

    drawMarks(marks) {
      this.marks.replaceChildren();
      for (const { at, line, look, words, size } of marks) {
        const one = line
          ? part(this.marks, "path", { d: Drawing.line(line, this.project, false), class: look })
          : look.startsWith("best")
            ? part(this.marks, "path", { d: Drawing.line([[-1, 0], [1, 0], [0, 0], [0, 1], [0, -1]].map(([a, c]) => [at[0] + a * 7 * this.pixel / SCALE, at[1] + c * 7 * this.pixel / SCALE]), this.project), class: look })
            : part(this.marks, "circle", { cx: at[0] * SCALE, cy: -at[1] * SCALE, r: (size ?? 4.5) * this.pixel, class: look });
        part(one, "title").textContent = words;
      }
    }

    label(name, text, [x, y], anchor = "middle") {
      const one = this.labels[name], half = text.length * 3.2 * this.pixel;
      const within = Math.min(this.right * SCALE - half - 4 * this.pixel, Math.max(this.left * SCALE + half + 4 * this.pixel, x * SCALE));
      one.setAttribute("x", within);
      one.setAttribute("y", -y * SCALE);
      one.setAttribute("text-anchor", anchor);
      if (one.textContent !== text) one.textContent = text;
    }
  }

  const HEARD = {
    above: "seen from above; left and right arrows move it along the flight path, up and down to its sides",
    side: "seen from the side; left and right arrows move it along the flight path, up and down in height",
    behind: "seen from behind; left and right arrows move it sideways, up and down in height",
  };
  const views = { above: new View("above", "x", "y"), side: new View("side", "x", "z"), behind: new View("behind", "y", "z") };

  function sizeViews() {
    const right = Math.max(1.28 * now.bird.wavelength / semispan(), 5);
    views.above.size([-0.95, right], [LOWEST, 2.75]);
    views.side.size([-0.95, right], [-1.35, 1.35]);
    views.behind.size([LOWEST, 2.75], [-1.35, 1.35]);
  }

  // Put the birds and the rings where they are at a time; called for every picture while they flap.
  function drawMoving() {
    const b = semispan(), { bird } = now, isLimit = state.model === "limit", law = isLimit ? state.law : "stroke";
    const x = state.x / b, y = state.y / b, z = state.z / b, wavelength = bird.wavelength / b;
    const lead = Drawing.pose(time, law), own = Drawing.pose(time - state.phase, law);
    const half = ({ flexed }, ratio) => 1 - flexed + flexed * ratio;
    const leadHalf = half(lead, bird.upstroke_span_ratio), ownHalf = half(own, state.ratio);
    const leadTip = lead.height * bird.amplitude_m / b, ownTip = own.height * state.amplitude / b;
    const { above, side, behind } = views;
    above.leader.setAttribute("d", Drawing.above([0, 0], leadHalf, lead.flexed, above.project));
    above.follower.setAttribute("d", Drawing.above([x, y], ownHalf, own.flexed, above.project));
    side.leader.setAttribute("d", Drawing.side([0, 0], leadTip, lead.flexed, side.project));
    side.follower.setAttribute("d", Drawing.side([x, z], ownTip, own.flexed, side.project));
    behind.leader.setAttribute("d", Drawing.behind([0, 0], leadHalf, leadTip, behind.project));
    behind.follower.setAttribute("d", Drawing.behind([y, z], ownHalf, ownTip, behind.project));
    const shed = { time, wavelength, amplitude: bird.amplitude_m / b, ratio: bird.upstroke_span_ratio, rollUp: data.constants.roll_up };
    const rings = Drawing.rings({ ...shed, from: 0, to: isLimit ? above.right : wavelength }).map((ring) => ({ ...ring, look: ring.isUp ? "up" : "down" }));
    if (isLimit) rings.unshift(...Drawing.rings({ ...shed, from: above.left, to: 0 }).map((ring) => ({ ...ring, look: `${ring.isUp ? "up" : "down"} ahead` })));
    above.drawWake(rings.map(({ look, x0, x1, width }) => [look, Drawing.line([[x0, -width], [x0, width], [x1, width], [x1, -width]], above.project, true)]));
    side.drawWake(rings.map(({ look, x0, x1, z0, z1 }) => [look, Drawing.line([[x0, z0], [x1, z1]], side.project, false)]));
    behind.drawWake(crossSection(rings, x, behind.project));
    now.isBeyond = !rings.some(({ x0, x1 }) => x >= x0 && x <= x1);
    for (const [view, at] of [[above, [x, y]], [side, [x, z]], [behind, [y, z]]]) {
      view.halo.setAttribute("cx", at[0] * SCALE);
      view.halo.setAttribute("cy", -at[1] * SCALE);
    }
    above.label("leader", "leader", [0, 1.1]);
    above.label("follower", "follower", [x, Math.min(y + 1.1, above.high - 15 * above.pixel / SCALE)]);
    side.label("leader", "leader", [0, -0.92]);
    side.label("follower", "follower", [x, Math.max(z - 0.92, side.low + 0.08)]);
    behind.label("leader", "leader", [0, -0.92]);
    behind.label("follower", "follower", [y, Math.max(z - 0.92, behind.low + 0.08)]);
  }

  // Where the two tip vortices pass the follower, seen from behind: a core each, and how the air turns about it.
  function crossSection(rings, x, project) {
    const ring = rings.find(({ x0, x1 }) => x >= x0 && x <= x1);
    if (!ring) return [];
    const height = ring.z0 + (ring.z1 - ring.z0) * (x - ring.x0) / (ring.x1 - ring.x0), paths = [];
    for (const side of [1, -1]) {
      const circle = Array.from({ length: 24 }, (_, i) => {
        const angle = 2 * Math.PI * i / 24;
        return [side * ring.width + state.core * Math.cos(angle), height + state.core * Math.sin(angle)];
      });
      paths.push([`${ring.look} core`, Drawing.line(circle, project, true)]);
      // Outboard of a tip the air rises, inboard it sinks.
      paths.push([`${ring.look} turn`, turn(side, ring.width, height, state.core + 0.12, project)]);
    }
    paths.push([`${ring.look} trace`, Drawing.line([[-ring.width, height], [ring.width, height]], project, false)]);
    return paths;
  }

  // An arrow about a tip vortex.
  function turn(side, width, height, radius, project) {
    const point = (angle, r = radius) => [side * (width + r * Math.cos(angle)), height + r * Math.sin(angle)];
    const arc = Array.from({ length: 17 }, (_, i) => point(-0.9 + 1.8 * i / 16)), end = 0.9;
    return Drawing.line(arc, project, false) + Drawing.line([point(end - 0.32, radius + 0.09), point(end), point(end - 0.42, radius - 0.07)], project, false);
  }

  function drawMarks() {
    const b = semispan(), { above } = views, marks = data.observed.map(([x, y]) => ({ at: [x / b, y / b], look: "observed", words: `observed: ${metres(x)} behind, ${metres(y)} to the right`, size: data.observed.length > 300 ? 2 : 3.5 }));
    for (const one of now.species.seen) {
      const words = `seen by ${one.label}: ${one.x_m === null ? "" : `${metres(one.x_m)} behind, `}${metres(one.y_m)} aside`;
      marks.push(one.x_m === null ? { line: [[0, one.y_m / b], [above.right, one.y_m / b]], look: "seen", words } : { at: [one.x_m / b, one.y_m / b], look: "seen", words });
    }
    if (isOwn()) for (const one of now.species.optima[state.model]) marks.push({ at: [one.x_m / b, one.y_m / b], look: "best", words: one.kind === "v" ? "best place in the V" : "best place of all" });
    above.drawMarks(marks);
    byId("key-best").hidden = !isOwn();
    byId("key-seen").hidden = !data.observed.length && !now.species.seen.length;
    byId("key-seen-words").textContent = data.observed.length ? "your birds, and where others were seen" : "where birds were seen";
  }

  // Whether airspeed, core and wing are those for which best places are kept.
  const isOwn = () => state.speed === now.species.bird.speed_m_s && state.core === data.constants.core_radius_ratio && (state.model === "paper" || state.law === "stroke");

  // ---- the answer ----

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

  const BALANCED = 0.0005;

  // What is missing of lift and thrust, and what is too much of them, in words.
  function lack(total) {
    const off = total.map((one) => one - 1), names = ["lift", "thrust"];
    const list = (chosen) => names.filter((_, i) => chosen(off[i])).map((name) => { const share = Math.abs(off[names.indexOf(name)]); return `${percent(share, share < 0.0995 ? 1 : 0)} ${chosen(-1) ? "of" : "too much"} ${name}`; }).join(" and ");
    const short = list((one) => one < -BALANCED), much = list((one) => one > BALANCED);
    return [short && `short of ${short}`, much].filter(Boolean).join(", and ");
  }

  function showAnswer() {
    const found = force(), { bird } = now, lone = physics.power(bird, bird.weight, bird.drag);
    const isBalanced = found.total.every((one) => Math.abs(one - 1) < BALANCED);
    const saved = 1 - found.cost / physics.cost(bird, weights, bird.weight, bird.drag), what = data.objective.words;
    let verdict, detail;
    if (isBalanced) {
      const nothing = Math.abs(saved) < 0.0005;
      verdict = nothing ? `Here it saves nothing.` : saved > 0 ? `Here it saves ${percent(saved)} of its ${what}.` : `Here it pays ${percent(-saved)} more ${what} than alone.`;
      const parts = ["induced", "profile"].map((name) => { const share = 1 - found.power[name] / lone[name]; return `${number(Math.abs(100 * share), 1)}\u00a0% ${share < 0 ? "more" : "less"} ${name} power`; });
      detail = `${parts.join(", ")}${weights.force ? `, ${percent(1 - found.power.total / lone.total)} of all power saved` : ""}.`;
      detail = detail[0].toUpperCase() + detail.slice(1);
    } else if (state.adapting && now.isComplete && !now.solutions.length) {
      verdict = `This bird can\u2019t fly here: ${lack(found.total)}.`;
      detail = `However it flaps, no stroke balances; this one comes nearest. Move it, or change its phase.`;
    } else {
      verdict = `This bird can\u2019t fly here like this: ${lack(found.total)}.`;
      detail = state.adapting ? "Looking for a stroke that balances \u2026" : "Let it adapt: it may balance with another stroke.";
    }
    byId("verdict").textContent = verdict;
    byId("verdict").className = isBalanced ? (saved >= -0.0005 ? "saves" : "pays") : "cannot";
    byId("detail").textContent = detail;
    now.verdict = verdict;
    ["lift", "thrust"].forEach((name, i) => showBar(name, ["weight", "drag"][i], found.own[i], found.wake[i], found.total[i]));
    showNotes();
  }

  const FULL = 1.5; // how much of weight or drag a whole bar is

  function showBar(name, of, own, wake, total) {
    const bar = byId(`${name}-bar`), [mine, gift] = bar.children, at = (share) => `${100 * clamp(share, [0, FULL]) / FULL}%`;
    mine.style.width = at(own);
    gift.style.left = at(Math.min(own, total));
    gift.style.width = `${100 * (clamp(Math.max(own, total), [0, FULL]) - clamp(Math.min(own, total), [0, FULL])) / FULL}%`;
    gift.className = wake < 0 ? "wake against" : "wake";
    bar.classList.toggle("met", Math.abs(total - 1) < BALANCED);
    const words = `${percent(total)} of its ${of}: ${percent(own)} its own, ${wake < 0 ? `${percent(-wake)} lost to the wake` : `${percent(wake)} from the wake`}`;
    bar.setAttribute("aria-valuenow", number(clamp(total, [0, FULL]), 3).replace("\u2212", "-"));
    bar.setAttribute("aria-valuetext", words);
    byId(`${name}-words`).textContent = words;
  }

  function showNotes() {
    const b = semispan(), notes = [], aside = Math.abs(state.y);
    const spatial = state.x / now.bird.wavelength - state.phase, phase = spatial - Math.round(spatial);
    notes.push(Math.abs(phase) < 0.02 ? "Its wingtips retrace the path of the leader\u2019s." : Math.abs(Math.abs(phase) - 0.5) < 0.02 ? "Its wingtips move against the path of the leader\u2019s." : `Its wingtips ${phase > 0 ? "run ahead of" : "lag"} the path of the leader\u2019s by ${number(Math.abs(phase), 2)} wingbeats.`);
    if (aside < 0.3 * b) notes.push("Straight behind: what the leader\u2019s body leaves in the air is missing from the model.");
    if (state.x < b && aside < 2 * b) notes.push("So close, the leader would feel the follower too, which the model leaves out.");
    if (now.isBeyond) notes.push("Behind the end of the wake, which the paper\u2019s model cuts after one wavelength.");
    if (aside >= 0.3 * b && aside < 2 * b && state.x >= b) notes.push(`Outstretched, the wingtips overlap by ${metres(2 * b - aside)} across the flight path.`);
    const list = byId("notes"), texts = Array.from(list.children, (one) => one.textContent);
    if (texts.join() !== notes.join()) list.replaceChildren(...notes.map((text) => { const one = document.createElement("li"); one.textContent = text; return one; }));
    showWays();
  }

  // Where several strokes balance, all of them to choose from.
  function showWays() {
    const box = byId("ways"), many = now.isComplete ? now.solutions : [];
    box.hidden = many.length < 2;
    if (box.hidden) { box.replaceChildren(); return; }
    const buttons = many.map((one, i) => {
      const button = document.createElement("button"), saved = physics.saving(now.bird, weights, one);
      button.type = "button";
      button.textContent = `${saved < 0 ? `pays ${percent(-saved)}` : `saves ${percent(saved)}`} (${metres(one.amplitude)}, ${number(one.ratio, 2)})`;
      button.setAttribute("aria-pressed", String(Math.abs(one.amplitude - state.amplitude) < 1e-9 && Math.abs(one.ratio - state.ratio) < 1e-9));
      button.addEventListener("click", () => { useStroke(one); show(); announceSoon(); byId("ways").querySelectorAll("button")[i].focus(); });
      return button;
    });
    const words = document.createElement("span");
    words.textContent = `${many.length} strokes balance here (amplitude, span):`;
    box.replaceChildren(words, ...buttons);
  }

  let announceTimer = 0;
  function announceSoon() {
    clearTimeout(announceTimer);
    announceTimer = setTimeout(() => { byId("announcement").textContent = `${now.verdict} ${placeWords()}`; }, 600);
  }
  const placeWords = () => `${metres(state.x)} behind, ${sideWords(state.y)}, ${heightWords(state.z)}.`;
  const sideWords = (y) => Math.abs(y) < 0.005 * semispan() ? "in line" : `${metres(Math.abs(y))} to the ${y < 0 ? "left" : "right"}`;
  const heightWords = (z) => Math.abs(z) < 0.005 * semispan() ? "level" : `${metres(Math.abs(z))} ${z < 0 ? "below" : "above"}`;

  // ---- controls ----

  const alone = (value, of) => `${number(100 * value / of, 0)}\u00a0% of alone`;
  const SLIDERS = {
    x: (value) => metres(value), y: sideWords, z: heightWords,
    phase: (value) => `${number(value, 2)} wingbeats`,
    amplitude: (value) => `${metres(value)}, ${alone(value, now.bird.amplitude_m)}`,
    ratio: (value) => `${number(value, 3)} of the downstroke\u2019s, ${alone(value, now.bird.upstroke_span_ratio)}`,
    speed: (value) => `${number(value, 1)}\u00a0m/s`,
    core: (value) => `${number(value, 3)} of the semispan`,
  };

  function showControls() {
    const range = limits();
    for (const [name, words] of Object.entries(SLIDERS)) {
      const input = byId(name), [least, most, step] = range[name];
      if (input.dataset.range !== `${range[name]}`) {
        Object.assign(input, { min: least, max: most, step: "any" });
        input.dataset.range = `${range[name]}`;
        input.dataset.step = step;
      }
      if (Number(input.value) !== state[name]) input.value = state[name];
      const text = words(state[name]);
      byId(`${name}-value`).textContent = text;
      input.setAttribute("aria-valuetext", text);
    }
    byId("adapting").checked = state.adapting;
    byId(`model-${state.model}`).checked = true;
    byId("law").value = state.law;
    byId("law-field").hidden = state.model !== "limit";
    for (const kind of ["v", "global"]) {
      const button = byId(`best-${kind}`);
      button.disabled = !keptPlace(kind);
      button.title = button.disabled ? `There is none in this model for least ${data.objective.words}.` : "";
    }
    for (const view of Object.values(views)) {
      view.handle.setAttribute("aria-valuenow", number(state[view.across], 3).replace("\u2212", "-"));
      view.handle.setAttribute("aria-valuemin", number(range[view.across][0], 3).replace("\u2212", "-"));
      view.handle.setAttribute("aria-valuemax", number(range[view.across][1], 3).replace("\u2212", "-"));
      view.handle.setAttribute("aria-valuetext", placeWords());
    }
  }

  function show() {
    drawMoving();
    showAnswer();
    showControls();
    writeAddressSoon();
  }

  // Several moves of a pointer within one picture of the screen are one.
  let wanted = null;
  function moveTo(place) {
    const isAsked = wanted !== null;
    wanted = { ...wanted, ...place };
    if (!isAsked) requestAnimationFrame(() => {
      const range = limits();
      for (const key of Object.keys(wanted)) state[key] = clamp(wanted[key], range[key]);
      if ("z" in wanted) clearMap();
      wanted = null;
      moved();
    });
  }

  for (const name of Object.keys(SLIDERS)) {
    const input = byId(name);
    input.addEventListener("input", () => {
      state[name] = Number(input.value);
      if (name === "amplitude" || name === "ratio") {
        state.adapting = false;
        now.solutions = [];
        show();
        return;
      }
      if (name === "speed" || name === "core") remake();
      if (name === "z" || name === "phase") clearMap();
      moved();
    });
    input.addEventListener("change", announceSoon);
    // "any" lets a slider hold what was solved; its keys go by steps that can be seen.
    input.addEventListener("keydown", (event) => {
      const step = Number(input.dataset.step) * (event.shiftKey ? 10 : 1);
      const by = { ArrowLeft: -step, ArrowDown: -step, ArrowRight: step, ArrowUp: step, PageUp: 10 * step, PageDown: -10 * step }[event.key];
      if (!by) return;
      event.preventDefault();
      input.value = clamp(state[name] + by, limits()[name]);
      input.dispatchEvent(new Event("input"));
      announceSoon();
    });
  }

  // After a change of bird, air or model.
  function remake() {
    makeBirdAndWake();
    const range = limits();
    for (const key of ["x", "y", "z", "amplitude", "ratio"]) state[key] = clamp(state[key], range[key]);
    sizeViews();
    drawMarks();
  }

  function goTo(place, isSolved = false) {
    Object.assign(state, place);
    clearMap();
    now.solutions = [];
    now.isComplete = false;
    if (!isSolved && state.adapting) adapt();
    show();
    announceSoon();
  }

  byId("adapt").addEventListener("click", () => { state.adapting = true; adapt(); show(); announceSoon(); });
  byId("adapting").addEventListener("change", (event) => { state.adapting = event.target.checked; if (state.adapting) adapt(); show(); announceSoon(); });
  for (const kind of ["v", "global"]) {
    byId(`best-${kind}`).addEventListener("click", () => {
      if (isOwn()) goTo(fromKept(keptPlace(kind)), true);
      else { state.adapting = true; goTo(improved(fromKept(keptPlace(kind)))); }
    });
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

  byId("species").addEventListener("change", (event) => {
    state.species = event.target.value;
    state.speed = speciesNamed(state.species).bird.speed_m_s;
    remake();
    fillPlaces();
    nameLeader();
    goTo(firstPlace(), isOwn());
  });
  for (const name of ["paper", "limit"]) byId(`model-${name}`).addEventListener("change", () => { state.model = name; remake(); fillPlaces(); moved(); announceSoon(); });
  byId("law").addEventListener("change", (event) => { state.law = event.target.value; remake(); moved(); announceSoon(); });

  function fillPlaces() {
    const select = byId("place"), options = [["", "choose a place"]];
    if (now.species.paper_place) options.push(["paper", "the paper\u2019s point (its Table 1)"]);
    now.species.seen.forEach((one, i) => options.push([`seen-${i}`, `where birds were seen: ${one.x_m === null ? "" : `${metres(one.x_m)} behind, `}${metres(one.y_m)} aside (${one.label})`]));
    options.push(["straight", "straight behind, in antiphase with its path"]);
    select.replaceChildren(...options.map(([value, text]) => Object.assign(document.createElement("option"), { value, textContent: text })));
  }
  byId("place").addEventListener("change", (event) => {
    const chosen = event.target.value, { wavelength } = now.bird, wrap = (value) => value - Math.floor(value);
    if (chosen === "paper") {
      state.model = "paper";
      state.adapting = false;
      state.speed = now.species.bird.speed_m_s;
      state.core = data.constants.core_radius_ratio;
      remake();
      goTo(fromKept(now.species.paper_place), true);
    } else if (chosen.startsWith("seen-")) {
      const one = now.species.seen[Number(chosen.slice(5))], x = one.x_m ?? state.x;
      state.adapting = true;
      goTo({ x, y: one.y_m, z: 0, phase: wrap(x / wavelength) });
    } else if (chosen === "straight") {
      state.adapting = true;
      goTo({ x: wavelength, y: 0, z: 0, phase: 0.5 });
    }
    fillPlaces();
    event.target.value = chosen;
  });

  const nameLeader = () => { byId("leader-name").textContent = data.species.length && `${/^[aeiou]/i.test(now.species.name) ? "an" : "a"} ${now.species.name.toLowerCase()}`; };

  // ---- the map ----

  const FINE = { paper: 10, limit: 5 }; // places of the map a semispan
  const BLEND = 6; // points of the picture between two of them
  const PAYS = [150, 150, 150, 165]; // as in the style
  let worker = null, mapOf = null;

  function clearMap() {
    worker?.terminate();
    worker = mapOf = null;
    document.body.classList.remove("with-map");
    views.above.image.removeAttribute("href");
    byId("legend").hidden = true;
    byId("map").setAttribute("aria-pressed", "false");
    byId("map").textContent = "Show the map";
    byId("map-progress").textContent = "";
  }

  function startMap() {
    clearMap();
    const b = semispan(), { above } = views, columns = 4 * Math.ceil(above.right * FINE[state.model] / 4) + 1, rows = 4 * Math.ceil(above.high * FINE[state.model] / 4) + 1;
    const xs = Array.from({ length: columns }, (_, i) => i * above.right * b / (columns - 1)), ys = Array.from({ length: rows }, (_, j) => j * above.high * b / (rows - 1));
    mapOf = { columns, rows };
    const source = `"use strict";${makePhysics}${makeMap}(${mapWorker})(${JSON.stringify(data.constants)})`;
    const address = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    worker = new Worker(address);
    URL.revokeObjectURL(address);
    const mine = worker;
    worker.onmessage = ({ data: told }) => {
      if (worker !== mine) return;
      if (!told.values) { byId("map-progress").textContent = "map complete"; return; }
      byId("map-progress").textContent = `computing the map: ${told.stride === 4 ? "coarse" : told.stride === 2 ? "finer" : "fine"} grid \u2026`;
      paintMap(told.values, told.stride);
    };
    worker.postMessage({ inputs: now.inputs, model: now.model, weights, z: state.z, phase: state.phase, xs, ys });
    document.body.classList.add("with-map");
    byId("map").setAttribute("aria-pressed", "true");
    byId("map").textContent = "Hide the map";
    byId("map-progress").textContent = "computing the map \u2026";
  }

  const colourOf = (share) => {
    const at = clamp(share, [0, 1]) * (data.colours.length - 1), i = Math.min(Math.floor(at), data.colours.length - 2);
    return data.colours[i].map((one, k) => one + (data.colours[i + 1][k] - one) * (at - i));
  };

  function paintMap(values, stride) {
    const { columns, rows } = mapOf, { above } = views, canvas = document.createElement("canvas"), saved = values.filter((one) => one < NO_BALANCE);
    const most = Math.max(0.01, Math.max(...saved));
    // Both sides of the flight path, from left (below) to right (above). A coarse grid fills what is not yet known; savings
    // are blended between places, and where a neighbour has none the nearest counts.
    canvas.width = columns * BLEND;
    canvas.height = (2 * rows - 1) * BLEND;
    const context = canvas.getContext("2d"), picture = context.createImageData(canvas.width, canvas.height);
    const known = (i, j) => {
      const across = Math.min(columns - 1, Math.max(0, i)), up = Math.min(rows - 1, Math.abs(j));
      for (let s = 1; s <= 4; s *= 2) {
        const value = values[Math.min(columns - 1, s * Math.round(across / s)) + columns * Math.min(rows - 1, s * Math.round(up / s))];
        if (value !== UNKNOWN) return value;
      }
      return UNKNOWN;
    };
    for (let row = 0; row < canvas.height; row++) for (let column = 0; column < canvas.width; column++) {
      const x = (column + 0.5) / BLEND - 0.5, y = (row + 0.5) / BLEND - 0.5 - (rows - 1), i = Math.floor(x), j = Math.floor(y), a = x - i, c = y - j;
      const four = [known(i, j), known(i + 1, j), known(i, j + 1), known(i + 1, j + 1)];
      const value = four.every((one) => one < NO_BALANCE)
        ? (four[0] * (1 - a) + four[1] * a) * (1 - c) + (four[2] * (1 - a) + four[3] * a) * c
        : known(Math.round(x), Math.round(y));
      picture.data.set(value >= NO_BALANCE ? [0, 0, 0, 0] : value < 0 ? PAYS : [...colourOf(value / most), 255], 4 * (row * canvas.width + column));
    }
    context.putImageData(picture, 0, 0);
    const cell = above.right / (columns - 1), tall = above.high / (rows - 1);
    for (const [key, value] of Object.entries({ x: -cell / 2 * SCALE, y: -(above.high + tall / 2) * SCALE, width: (above.right + cell) * SCALE, height: (2 * above.high + tall) * SCALE, href: canvas.toDataURL() })) above.image.setAttribute(key, value);
    byId("legend").hidden = false;
    byId("legend-low").textContent = "saves 0";
    byId("legend-high").textContent = percent(most);
    byId("legend-words").textContent = `Each place with the stroke that balances there, ${state.z === 0 ? "level with the leader" : `${metres(Math.abs(state.z))} ${state.z < 0 ? "below" : "above"} it`}, ${number(state.phase, 2)} wingbeats later than it. Best on this map: ${percent(Math.max(...saved))}.`;
    const bar = byId("legend-colours").getContext("2d");
    for (let i = 0; i < 128; i++) {
      bar.fillStyle = `rgb(${colourOf(i / 127).map(Math.round).join()})`;
      bar.fillRect(i, 0, 1, 1);
    }
  }

  byId("map").addEventListener("click", () => { if (worker) clearMap(); else startMap(); });

  // ---- flapping ----

  const BEATS_PER_SECOND = 0.45; // slowed down so that one can see it
  let before = 0;
  function flap(stamp) {
    if (!isPlaying) return;
    time += Math.min(0.05, (stamp - before) / 1000) * BEATS_PER_SECOND;
    before = stamp;
    drawMoving();
    requestAnimationFrame(flap);
  }
  function play(isOn) {
    isPlaying = isOn;
    byId("play").setAttribute("aria-pressed", String(isOn));
    byId("play").textContent = isOn ? "Stop flapping" : "Flap";
    if (isOn) requestAnimationFrame((stamp) => { before = stamp; flap(stamp); });
  }
  byId("play").addEventListener("click", () => play(!isPlaying));
  lessMotion.addEventListener("change", () => { if (lessMotion.matches) play(false); });

  // ---- begin ----

  byId("species").replaceChildren(...data.species.map((one) => Object.assign(document.createElement("option"), { value: one.slug, textContent: `${one.name} (${one.scientific})` })));
  byId("controls").addEventListener("submit", (event) => event.preventDefault());

  function begin() {
    const isGiven = location.hash.length > 1;
    readAddress();
    byId("species").value = state.species;
    nameLeader();
    fillPlaces();
    sizeViews();
    drawMarks();
    if (!isOwn() || (isGiven && state.adapting)) {
      const stroke = physics.follow(now.bird, now.wake, placeNow(), weights, state);
      if (stroke) useStroke(stroke); else if (state.adapting) adapt();
    }
    show();
  }
  begin();
  play(!lessMotion.matches);
  addEventListener("hashchange", begin);
  new ResizeObserver(() => { for (const view of Object.values(views)) view.measure(); drawMarks(); drawMoving(); }).observe(byId("above"));
})();
