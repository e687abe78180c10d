// The answer: whether a bird can fly where it is, what it saves, and what is to be said of its place.
"use strict";

// `on.chosen` is called once another of several strokes that balance was taken.
function makeAnswer(data, physics, { state, now, semispan, force, useStroke }, { number, metres, percent, placeWords }, on) {
  const weights = data.objective.weights;
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
      button.addEventListener("click", () => { useStroke(one); on.chosen(); announceSoon(); byId("ways").querySelectorAll("button")[i].focus(); });
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

  return { showAnswer, announceSoon };
}
