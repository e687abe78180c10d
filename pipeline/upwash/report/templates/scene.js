// The V from above, to scale: a leader, a follower at its best place and its mirror image, and the rings they shed.
{
  const svg = document.getElementById("scene");
  const SVG = "http://www.w3.org/2000/svg";
  const B = 100, END = 640, BEAT_MS = 3000, STILL = 0.2;

  const make = (name, attributes, parent = svg) => {
    const one = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
    return parent.appendChild(one);
  };

  // Half-span over the semispan: whole on the downstroke's half, drawn in as the wing rises.
  const reach = (phase, ratio) => {
    const height = Math.abs(1 - 2 * (phase - Math.floor(phase)));
    return 1 - height + ratio * height;
  };

  // The rings behind a bird as two paths, one for those of downstrokes and one for those of upstrokes.
  const rings = (scene, bird, phase) => {
    const half = scene.wavelength * B / 2, paths = { down: "", up: "" };
    const end = Math.min(END, scene.length === null ? Infinity : bird.x * B + scene.length * scene.wavelength * B);
    const beats = phase - Math.floor(phase);
    let isDown = beats < 0.5, from = bird.x * B, to = from + (isDown ? beats : beats - 0.5) * 2 * half;
    while (from < end) {
      const width = scene.half_width * B * (isDown ? 1 : bird.ratio), y = bird.y * B, last = Math.min(to, end);
      paths[isDown ? "down" : "up"] += `M${from.toFixed(1)},${(y - width).toFixed(1)}H${last.toFixed(1)}V${(y + width).toFixed(1)}H${from.toFixed(1)}Z`;
      [from, to, isDown] = [to, to + half, !isDown];
    }
    return paths;
  };

  let birds = [], scene = null, beat = STILL;
  const build = () => {
    scene = told.scenes[settings()] ?? told.scenes[`${root.dataset.cost} paper`] ?? Object.values(told.scenes)[0];
    for (const one of Array.from(svg.children).slice(1)) one.remove();
    birds = [
      { x: 0, y: 0, lag: 0, ratio: scene.leader_ratio, look: "leader", name: "leader" },
      { x: scene.x, y: -scene.y, lag: scene.phase, ratio: scene.ratio, look: "follower", name: "follower" },
      { x: scene.x, y: scene.y, lag: scene.phase, ratio: scene.ratio, look: "follower faint", name: "" },
    ];
    // The wake that matters is the leader's: it is drawn whole, those of followers faint.
    for (const bird of birds) bird.paths = ["down", "up"].map((kind) => make("path", { class: `ring ${kind}${bird.x > 0 ? " faint" : ""}` }));
    for (const bird of birds) bird.body = make("use", { href: "#bird", class: bird.look });
    for (const bird of birds.filter((one) => one.name)) {
      const above = Math.max(bird.y * B + (bird.x > 0 ? -112 : -122), -270);
      make("text", { x: bird.x * B - 45, y: above, "text-anchor": "middle" }).textContent = bird.name;
    }
    const metre = scene.metre * B;
    make("path", { class: "scale", d: `M-70,265h${metre.toFixed(1)}m0,-7v14m${-metre.toFixed(1)},-14v14` });
    make("text", { x: -70 + metre + 12, y: 272 }).textContent = "1 m";
    document.getElementById("scene-label").textContent = scene.label;
    draw();
  };

  const draw = () => {
    for (const bird of birds) {
      const phase = beat - bird.lag, paths = rings(scene, bird, phase);
      bird.paths[0].setAttribute("d", paths.down || "M0,0");
      bird.paths[1].setAttribute("d", paths.up || "M0,0");
      bird.body.setAttribute("transform", `translate(${bird.x * B},${bird.y * B}) scale(0.9,${reach(phase, bird.ratio).toFixed(3)})`);
    }
  };

  if (svg) {
    const calm = matchMedia("(prefers-reduced-motion: reduce)"), button = document.getElementById("motion");
    let isMoving = !calm.matches, seen = null, isInView = true;
    const step = (now) => {
      if (!isMoving || !isInView) { seen = null; return; }
      if (seen !== null) beat += (now - seen) / BEAT_MS;
      seen = now;
      draw();
      requestAnimationFrame(step);
    };
    const move = (on) => {
      const starts = on && !isMoving;
      isMoving = on;
      button.setAttribute("aria-pressed", String(!on));
      button.textContent = on ? "Pause" : "Play";
      if (starts) requestAnimationFrame(step);
    };
    build();
    button.hidden = false;
    move(isMoving);
    button.addEventListener("click", () => move(!isMoving));
    calm.addEventListener("change", () => move(!calm.matches));
    document.addEventListener("switched", build);
    new IntersectionObserver(([entry]) => {
      const starts = entry.isIntersecting && !isInView;
      isInView = entry.isIntersecting;
      if (starts && isMoving) requestAnimationFrame(step);
    }).observe(svg);
    if (isMoving) requestAnimationFrame(step);
  }
}
