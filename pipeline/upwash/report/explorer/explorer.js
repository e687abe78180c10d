// The page: its controls, and how what is moved is shown.
"use strict";

(() => {
  const data = JSON.parse(byId("data").textContent), physics = makePhysics(data.constants), { weights } = data.objective;
  const chosen = makeChosen(data, physics, LOWEST + 0.15);
  const { state, now, limits, isOwn, keptPlace, fromKept, speciesNamed } = chosen;
  const words = makeWords(chosen), { number, metres, sideWords, heightWords, placeWords } = words;
  const views = makeViews(data, chosen, words, { move: moveTo, rested: () => announceSoon() });
  const { sizeViews, drawMoving, drawMarks } = views;
  const { showAnswer, announceSoon } = makeAnswer(data, physics, chosen, words, { chosen: show });
  const { clearMap } = makeMapView(data, chosen, words, views.above);

  // ---- what is moved ----

  function show() {
    drawMoving();
    showAnswer();
    showControls();
    chosen.writeAddressSoon();
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

  // Follow a balance while something moves, and look for all of them once it rests.
  let waiting = 0;
  function moved() {
    now.solutions = [];
    now.isComplete = false;
    clearTimeout(waiting);
    if (state.adapting) {
      const stroke = physics.follow(now.bird, now.wake, chosen.placeNow(), weights, state);
      if (stroke) chosen.useStroke(stroke);
      waiting = setTimeout(() => { chosen.adapt(); show(); }, stroke ? 250 : 90);
    }
    show();
  }

  // After a change of bird, air or model.
  function remake() {
    chosen.makeBirdAndWake();
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
    if (!isSolved && state.adapting) chosen.adapt();
    show();
    announceSoon();
  }

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
    for (const [name, inWords] of Object.entries(SLIDERS)) {
      const input = byId(name), [least, most, step] = range[name];
      if (input.dataset.range !== `${range[name]}`) {
        Object.assign(input, { min: least, max: most, step: "any" });
        input.dataset.range = `${range[name]}`;
        input.dataset.step = step;
      }
      if (Number(input.value) !== state[name]) input.value = state[name];
      const text = inWords(state[name]);
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
    for (const view of views.all) {
      view.handle.setAttribute("aria-valuenow", number(state[view.across], 3).replace("\u2212", "-"));
      view.handle.setAttribute("aria-valuemin", number(range[view.across][0], 3).replace("\u2212", "-"));
      view.handle.setAttribute("aria-valuemax", number(range[view.across][1], 3).replace("\u2212", "-"));
      view.handle.setAttribute("aria-valuetext", placeWords());
    }
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

  byId("adapt").addEventListener("click", () => { state.adapting = true; chosen.adapt(); show(); announceSoon(); });
  byId("adapting").addEventListener("change", (event) => { state.adapting = event.target.checked; if (state.adapting) chosen.adapt(); show(); announceSoon(); });
  for (const kind of ["v", "global"]) {
    byId(`best-${kind}`).addEventListener("click", () => {
      if (isOwn()) goTo(fromKept(keptPlace(kind)), true);
      else { state.adapting = true; goTo(chosen.improved(fromKept(keptPlace(kind)))); }
    });
  }

  byId("species").addEventListener("change", (event) => {
    state.species = event.target.value;
    state.speed = speciesNamed(state.species).bird.speed_m_s;
    remake();
    fillPlaces();
    nameLeader();
    goTo(chosen.firstPlace(), isOwn());
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
    const place = event.target.value, { wavelength } = now.bird, wrap = (value) => value - Math.floor(value);
    if (place === "paper") {
      state.model = "paper";
      state.adapting = false;
      state.speed = now.species.bird.speed_m_s;
      state.core = data.constants.core_radius_ratio;
      remake();
      goTo(fromKept(now.species.paper_place), true);
    } else if (place.startsWith("seen-")) {
      const one = now.species.seen[Number(place.slice(5))], x = one.x_m ?? state.x;
      state.adapting = true;
      goTo({ x, y: one.y_m, z: 0, phase: wrap(x / wavelength) });
    } else if (place === "straight") {
      state.adapting = true;
      goTo({ x: wavelength, y: 0, z: 0, phase: 0.5 });
    }
    fillPlaces();
    event.target.value = place;
  });

  const nameLeader = () => { byId("leader-name").textContent = data.species.length && `${/^[aeiou]/i.test(now.species.name) ? "an" : "a"} ${now.species.name.toLowerCase()}`; };

  // ---- flapping ----

  const BEATS_PER_SECOND = 0.45; // slowed down so that one can see it
  const lessMotion = matchMedia("(prefers-reduced-motion: reduce)");
  let isPlaying = false, before = 0;
  function flap(stamp) {
    if (!isPlaying) return;
    now.time += Math.min(0.05, (stamp - before) / 1000) * BEATS_PER_SECOND;
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
    chosen.readAddress();
    byId("species").value = state.species;
    nameLeader();
    fillPlaces();
    sizeViews();
    drawMarks();
    if (!isOwn() || (isGiven && state.adapting)) {
      const stroke = physics.follow(now.bird, now.wake, chosen.placeNow(), weights, state);
      if (stroke) chosen.useStroke(stroke); else if (state.adapting) chosen.adapt();
    }
    show();
  }
  begin();
  play(!lessMotion.matches);
  addEventListener("hashchange", begin);
  new ResizeObserver(() => { for (const view of views.all) view.measure(); drawMarks(); drawMoving(); }).observe(byId("above"));
})();
