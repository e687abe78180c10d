// The map of savings as a picture in the view from above: coarse first, then finer, from a worker.
"use strict";

function makeMapView(data, { state, now, semispan }, { number, metres, percent }, above) {
  const { UNKNOWN, NO_BALANCE } = makeMap(), { weights } = data.objective;
  const FINE = { paper: 10, limit: 5 }; // places of the map a semispan
  const BLEND = 6; // points of the picture between two of them
  const PAYS = [150, 150, 150, 165]; // as in the style
  let worker = null, mapOf = null;

  function clearMap() {
    worker?.terminate();
    worker = mapOf = null;
    document.body.classList.remove("with-map");
    above.image.removeAttribute("href");
    byId("legend").hidden = true;
    byId("map").setAttribute("aria-pressed", "false");
    byId("map").textContent = "Show the map";
    byId("map-progress").textContent = "";
  }

  function startMap() {
    clearMap();
    const b = semispan(), columns = 4 * Math.ceil(above.right * FINE[state.model] / 4) + 1, rows = 4 * Math.ceil(above.high * FINE[state.model] / 4) + 1;
    const xs = Array.from({ length: columns }, (_, i) => i * above.right * b / (columns - 1)), ys = Array.from({ length: rows }, (_, j) => j * above.high * b / (rows - 1));
    mapOf = { columns, rows };
    const source = `"use strict";${[...PHYSICS, makeMap].join("\n")}(${mapWorker})(${JSON.stringify(data.constants)})`;
    const address = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    worker = new Worker(address);
    URL.revokeObjectURL(address);
    const mine = worker;
    worker.onmessage = ({ data: told }) => {
      if (worker !== mine) return;
      if (!told.values) { byId("map-progress").textContent = "map complete"; return; }
      byId("map-progress").textContent = `computing the map: ${told.stride === 4 ? "coarse" : told.stride === 2 ? "finer" : "fine"} grid \u2026`;
      paintMap(told.values);
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

  function paintMap(values) {
    const { columns, rows } = mapOf, canvas = document.createElement("canvas"), saved = values.filter((one) => one < NO_BALANCE);
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

  return { clearMap };
}
