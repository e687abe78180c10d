// The value behind each mark of a figure: under the pointer or a finger, and with the arrow keys.
{
  const NEAR = 24;

  for (const stage of document.querySelectorAll(".stage")) {
    const marks = told.marks[stage.dataset.figure] ?? [], region = stage.parentElement;
    if (!marks.length) continue;
    const ring = document.createElement("span"), output = document.createElement("output"), hint = document.createElement("p");
    ring.className = "ring";
    ring.hidden = output.hidden = true;
    hint.className = "answers";
    hint.textContent = `Point at a mark, touch it, or use the arrow keys: ${marks.length} marks tell their values.`;
    stage.append(ring, output);
    region.after(hint);
    let chosen = -1;

    const show = (number) => {
      chosen = number;
      ring.hidden = output.hidden = number < 0;
      if (number < 0) return;
      const [left, top, text] = marks[number];
      for (const one of [ring, output]) one.style.top = `${100 * top}%`;
      ring.style.left = `${100 * left}%`;
      output.textContent = text;
      // It stands beside the mark, on the side that has room.
      output.style.left = left < 0.55 ? `calc(${100 * left}% + 14px)` : "auto";
      output.style.right = left < 0.55 ? "auto" : `calc(${100 * (1 - left)}% + 14px)`;
    };

    const nearest = (event) => {
      const box = stage.getBoundingClientRect();
      let best = -1, least = NEAR * NEAR;
      marks.forEach(([left, top], number) => {
        const dx = left * box.width - (event.clientX - box.left), dy = top * box.height - (event.clientY - box.top);
        if (dx * dx + dy * dy < least) [best, least] = [number, dx * dx + dy * dy];
      });
      return best;
    };

    stage.addEventListener("pointermove", (event) => show(nearest(event)));
    stage.addEventListener("pointerdown", (event) => show(nearest(event)));
    stage.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") show(-1); });
    region.addEventListener("blur", () => show(-1));
    region.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (event.key === "Escape") show(-1);
      if (!step) return;
      event.preventDefault();
      show((chosen < 0 && step < 0 ? marks.length - 1 : chosen + step + marks.length) % marks.length);
      stage.querySelector(".ring").scrollIntoView({ block: "nearest", inline: "nearest" });
    });
  }
}
