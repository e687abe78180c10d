// The three views, from above, from the side and from behind: birds, rings, marks, and a follower that can be moved in
// each. Pictures are in semispans.
"use strict";

const SCALE = 100; // units of a picture per semispan
const LOWEST = -2; // how far to the left the views reach, in semispans

const byId = (name) => document.getElementById(name);

// `on.move` is called with the coordinates to which the follower is moved, in m, `on.rested` once it is let go.
function makeViews(data, { state, now, semispan, limits, isOwn }, { metres }, on) {
  const SVG = "http://www.w3.org/2000/svg";
  const part = (parent, name, attributes = {}) => {
    const one = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    parent.append(one);
    return one;
  };

  const HEARD = {
    above: "seen from above; left and right arrows move it along the flight path, up and down to its sides",
    side: "seen from the side; left and right arrows move it along the flight path, up and down in height",
    behind: "seen from behind; left and right arrows move it sideways, up and down in height",
  };

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
        on.move({ [this.across]: (at.x / SCALE - this.grip[0]) * semispan(), [this.up]: (-at.y / SCALE - this.grip[1]) * semispan() });
      };
      this.handle.addEventListener("pointerdown", (event) => {
        this.handle.setPointerCapture(event.pointerId);
        this.handle.focus({ preventScroll: true });
        const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
        this.grip = [at.x / SCALE - state[this.across] / semispan(), -at.y / SCALE - state[this.up] / semispan()];
        event.preventDefault();
      });
      this.handle.addEventListener("pointermove", (event) => { if (this.handle.hasPointerCapture(event.pointerId)) move(event); });
      for (const name of ["pointerup", "pointercancel"]) this.handle.addEventListener(name, () => on.rested());
      // A touch or click elsewhere takes the follower there.
      this.svg.addEventListener("click", (event) => {
        if (this.handle.contains(event.target)) return;
        this.grip = [0, 0];
        move(event);
        on.rested();
      });
      this.handle.addEventListener("keydown", (event) => {
        const step = limits()[this.across][2] * (event.shiftKey ? 10 : 1);
        const by = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
        if (!by) return;
        event.preventDefault();
        on.move({ [this.across]: state[this.across] + by[0], [this.up]: state[this.up] + by[1] });
        on.rested();
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
    const lead = Drawing.pose(now.time, law), own = Drawing.pose(now.time - state.phase, law);
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
    const shed = { time: now.time, wavelength, amplitude: bird.amplitude_m / b, ratio: bird.upstroke_span_ratio, rollUp: data.constants.roll_up };
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

  return { ...views, all: Object.values(views), sizeViews, drawMoving, drawMarks };
}
