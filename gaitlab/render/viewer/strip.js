// Numbers over time below the scene: lean of the trunk, ZMP margin and loads, with a line at the clock.
const strip = (() => {
  const HEAD = 17, HEIGHT = 26, INSET = 9; // px; the inset is half of the slider's thumb
  const degrees = (turn) => (180 / Math.PI) * turn;
  // What a band shows of the channels at an instant k; the scene is turned as x, y, z, w.
  const lean = ({ turn0: x, turn1: y, turn2: z, turn3: w }, k) => [
    degrees(Math.asin(Math.min(Math.max(2 * (w[k] * y[k] - z[k] * x[k]), -1), 1))),
    degrees(Math.atan2(2 * (w[k] * x[k] + y[k] * z[k]), 1 - 2 * (x[k] ** 2 + y[k] ** 2))),
  ];
  const BANDS = [
    { names: ["pitch", "roll"], unit: "°", most: 30, of: lean },
    { names: ["ZMP margin"], unit: " mm", most: 100, of: ({ margin0: margin }, k) => [1000 * margin[k]] },
    {
      names: ["load L", "R"], unit: " %", most: 200,
      of: ({ load2: left, load5: right }, k, weight) => [left, right].map((load) => (100 * load[k]) / weight),
    },
  ];
  const LINES = ["--mark", "--fall"];
  const box = document.getElementById("strip"), canvas = box.querySelector("canvas");
  const cursor = box.querySelector("i"), text = box.querySelector("p");
  let stages = [], begin = 0, end = 1;

  const values = (stage, band, k) => band.of(stage.channels, k, stage.trial.weight);
  const across = (time, width) => INSET + ((time - begin) / (end - begin || 1)) * (width - 2 * INSET);

  function draw() {
    const width = box.clientWidth, height = BANDS.length * (HEAD + HEIGHT), ratio = Math.min(devicePixelRatio || 1, 2);
    if (!width || !stages.length) return;
    Object.assign(canvas, { width: width * ratio, height: height * ratio });
    canvas.style.height = `${height}px`;
    const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    pen.scale(ratio, ratio);
    BANDS.forEach((band, row) => {
      const top = row * (HEAD + HEIGHT) + HEAD;
      const all = stages.flatMap((stage) =>
        [...stage.times].flatMap((_, k) => values(stage, band, k)).filter(Number.isFinite));
      const low = Math.max(Math.min(0, ...all), -band.most), high = Math.min(Math.max(0, ...all), band.most);
      const up = (value) => top + HEIGHT * (1 - (Math.min(Math.max(value, low), high) - low) / (high - low || 1));
      pen.fillStyle = colour("--early");
      pen.fillRect(INSET, top, width - 2 * INSET, HEIGHT);
      pen.fillStyle = colour("--bar");
      pen.fillRect(INSET, up(0), width - 2 * INSET, 1);
      stages.forEach((stage, second) => band.names.forEach((_, line) => {
        pen.strokeStyle = colour(LINES[line]);
        pen.lineWidth = 1.5;
        pen.setLineDash(second ? [3, 3] : []);
        pen.beginPath();
        let drawn = false;
        stage.times.forEach((time, k) => {
          const value = values(stage, band, k)[line];
          if (Number.isFinite(value)) pen[drawn ? "lineTo" : "moveTo"](across(time, width), up(value));
          drawn = Number.isFinite(value);
        });
        pen.stroke();
      }));
    });
  }

  /** Move the line to an instant and write what is there. */
  function show(now) {
    if (box.hidden || !stages.length) return;
    cursor.style.left = `${across(now, box.clientWidth)}px`;
    text.replaceChildren(...BANDS.map((band) => {
      const made = document.createElement("span");
      stages.forEach((stage, second) => {
        const k = Math.max(stage.times.findLastIndex((time) => time <= now + 1e-6), 0);
        if (second) made.append(" | ");
        values(stage, band, k).forEach((value, line) => {
          const part = document.createElement("b");
          part.style.color = `var(${LINES[line]})`;
          part.textContent = `${band.names[line]} ${Number.isFinite(value) ? value.toFixed(0) : "–"}${band.unit} `;
          made.append(part);
        });
      });
      return made;
    }));
  }

  function of(chosen, from, to) {
    [stages, begin, end] = [chosen, from, to];
    draw();
  }

  function controls(seek) {
    const go = (event) => {
      const { left, width } = box.getBoundingClientRect();
      seek(begin + ((event.clientX - left - INSET) / (width - 2 * INSET)) * (end - begin));
    };
    box.addEventListener("pointerdown", (event) => { box.setPointerCapture(event.pointerId); go(event); });
    box.addEventListener("pointermove", (event) => { if (event.buttons) go(event); });
    new ResizeObserver(draw).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  }

  return { of, show, controls };
})();
