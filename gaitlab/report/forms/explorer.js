/** The cells of an experiment, or the candidates of a study: each opens its seeds, and one figure
 * draws any measure of them, over the rows of a table or over every number that was searched. */
const data = JSON.parse(document.getElementById("data").textContent);
const trials = data.trials;
const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "star", "hexagon"];
const NARROW = 640; // px, below which panels stand one below the other
const seedsOf = data.cells.map(() => []);
trials.cell.forEach((cell, trial) => {
  if (cell !== null) seedsOf[cell].push(trial);
});

function element(name, text = "", attributes = {}) {
  const made = document.createElement(name);
  made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

const shown = (value) => (value === null ? "\u2014" : String(Number(value.toPrecision(3))));
const percent = (share) => `${Math.round(100 * share)} %`;

function shareText(cell) {
  if (!cell.n) return cell.text || "No seed has been scored.";
  const [low, high] = cell.interval.map((end) => Math.round(100 * end));
  const lead = cell.stands ? "" : "The robot does not stand here. ";
  return `${lead}${cell.stable} of ${cell.n} seeds stayed up, ${percent(cell.stable / cell.n)} ` +
    `[${low}\u2013${high}].${cell.text ? ` ${cell.text}` : ""}`;
}

/** Show the seeds of a cell, a row each. */
function openCell(number, marked = null) {
  const dialog = document.getElementById("cell");
  const cell = data.cells[number];
  document.getElementById("cell-title").textContent = cell.title;
  document.getElementById("cell-text").textContent = shareText(cell);
  const measures = data.measures.filter(({ name }) =>
    seedsOf[number].some((trial) => trials.values[name][trial] !== null),
  );
  const more = Object.keys(trials.more);
  const linked = seedsOf[number].some((trial) => trials.replay[trial]);
  const head = document.createElement("tr");
  const titles = [
    ["seed", "Number of the replicate"],
    ...more.map((name) => [name, ""]),
    ["ended", "How the trial ended"],
    ["time to fall [s]", "From the first full step to the fall; below zero while starting"],
    ...measures.map(({ title, meaning }) => [title, meaning]),
    ["trial", "First digits of its id"],
    ...(linked ? [["replay", "To look at it"]] : []),
  ];
  for (const [text, title] of titles) {
    head.append(element("th", text, title ? { scope: "col", title } : { scope: "col" }));
  }
  const body = document.createElement("tbody");
  for (const trial of seedsOf[number]) {
    const row = document.createElement("tr");
    if (trial === marked) row.className = "marked";
    row.append(element("th", String(trials.seed[trial]), { scope: "row" }));
    const texts = [
      ...more.map((name) => trials.more[name][trial]),
      trials.ended[trial],
      shown(trials.time[trial]),
      ...measures.map(({ name }) => shown(trials.values[name][trial])),
    ];
    for (const text of texts) row.append(element("td", text));
    const id = element("td");
    id.append(element("code", trials.id[trial]));
    row.append(id);
    if (linked) {
      const link = element("td");
      const file = trials.replay[trial];
      const name = `Replay of seed ${trials.seed[trial]}`;
      if (file) link.append(element("a", "replay", { href: file, "aria-label": name }));
      row.append(link);
    }
    [...row.cells].forEach((item, column) => {
      item.dataset.label = titles[column][0];
    });
    body.append(row);
  }
  const table = element("table", "", { class: titles.length > 4 ? "wide" : "" });
  const top = document.createElement("thead");
  top.append(head);
  table.append(top, body);
  dialog.querySelector("table").replaceWith(table);
  sortable(table);
  const watch = document.getElementById("cell-watch");
  const [trial] = marked === null ? seedsOf[number] : [marked];
  watch.textContent = trial === undefined ? "" : "To watch one: ";
  const name = trials.id[trial];
  const command = `gaitlab replay ${name}${data.options} --output ${name}.html`;
  if (trial !== undefined) watch.append(element("code", command));
  dialog.showModal();
  dialog.querySelector("tr.marked")?.scrollIntoView({ block: "center" });
}

for (const button of document.querySelectorAll("button[data-cell]")) {
  button.addEventListener("click", () => openCell(Number(button.dataset.cell)));
}
document.getElementById("cell").addEventListener("click", (event) => {
  if (event.target === event.currentTarget) event.currentTarget.close(); // beside it
});

const SHARE = { name: "", title: "stable share [%]", meaning: "Seeds that stayed up, with the " +
  "95 % Wilson interval. More is better." };
// Of a study one number a candidate; of an experiment one a seed.
const measures = data.axes ? [...data.scores, SHARE] : [SHARE, ...data.measures];
const chooser = document.getElementById("measure");
const plot = document.getElementById("plot");
const dark = matchMedia("(prefers-color-scheme: dark)");
for (const { title } of measures) chooser.append(element("option", title));

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
/** Places of the variants, and of the seeds of each, around the tick of a row. */
const beside = (k, n, width) => (n > 1 ? width * (k / (n - 1) - 0.5) : 0);

/** The cells of a panel, and where each stands across it. */
function cellsOf(variant, panel) {
  const shift = beside(variant, data.variants.length, 0.4);
  return data.cells
    .map((cell, number) => ({
      ...cell, number, across: data.axes ? cell.at[panel] : cell.place[1] + shift,
    }))
    .filter(({ place, across }) =>
      place[0] === variant && (data.axes ? across !== null : place[2] === panel));
}

/** Round values at equal ratios over what a panel has; plotly's own would run into each other. */
function steps(panel) {
  const known = data.cells.map(({ at }) => at[panel]).filter((value) => value > 0);
  const low = Math.min(...known), ratio = Math.max(...known) / low;
  return [0, 1, 2, 3].map((k) => Number((low * ratio ** (k / 3)).toPrecision(2)));
}

/** One point a candidate. */
function scores({ name, title }, variant, panel) {
  const cells = cellsOf(variant, panel).filter(({ values }) => values[name] !== null);
  return {
    x: cells.map(({ across }) => across),
    y: cells.map(({ values }) => values[name]),
    customdata: cells.map(({ number }) => [number, null]),
    text: cells.map((cell) =>
      `${safe(cell.title)}<br>${safe(title)}: <b>${shown(cell.values[name])}</b><br>` +
        cell.given.map(safe).join("<br>")),
  };
}

/** One point a cell, with its interval. */
function shares(variant, panel) {
  const cells = cellsOf(variant, panel).filter(({ n }) => n);
  const ends = cells.map(({ interval }) => interval.map((end) => 100 * end));
  const y = cells.map(({ stable, n }) => (100 * stable) / n);
  return {
    x: cells.map(({ across }) => across),
    y,
    error_y: {
      array: ends.map(([, high], k) => high - y[k]),
      arrayminus: ends.map(([low], k) => y[k] - low),
      thickness: 1.5,
      width: 3,
    },
    customdata: cells.map(({ number }) => [number, null]),
    text: cells.map((cell) => `${safe(cell.title)}<br>${safe(shareText(cell))}`),
  };
}

const safe = (text) => text.replace(/[&<>]/g, (c) => `&#${c.charCodeAt(0)};`);

/** One point a seed; those that fell are crosses. */
function seeds({ name, title }, variant, column) {
  const x = [], y = [], customdata = [], text = [], symbols = [];
  data.cells.forEach((cell, number) => {
    if (cell.place[0] !== variant || cell.place[2] !== column) return;
    const width = 0.6 / data.variants.length;
    const shift = beside(variant, data.variants.length, 0.8 - width);
    seedsOf[number].forEach((trial, k) => {
      const value = trials.values[name][trial];
      if (value === null) return;
      x.push(cell.place[1] + shift + beside(k, seedsOf[number].length, 0.8 * width));
      y.push(value);
      customdata.push([number, trial]);
      symbols.push(trials.ended[trial].startsWith("fell") ? "x" : SYMBOLS[variant % SYMBOLS.length]);
      const time = trials.time[trial] === null ? "" : ` after ${shown(trials.time[trial])} s`;
      text.push(
        `${safe(cell.title)}<br>seed ${trials.seed[trial]}: ${safe(trials.ended[trial])}${time}` +
          `<br>${safe(title)}: <b>${shown(value)}</b>`,
      );
    });
  });
  return { x, y, customdata, text, symbols };
}

function draw() {
  const measure = measures[chooser.selectedIndex];
  document.getElementById("meaning").textContent = measure.meaning;
  const wide = plot.clientWidth >= NARROW;
  const columns = (data.axes ?? data.columns).length, across = wide ? Math.min(columns, 4) : 1;
  const down = Math.ceil(columns / across);
  const ink = colour("--ink"), line = colour("--line"), paper = colour("--paper");
  const font = { color: ink, family: "system-ui, sans-serif", size: 13 };
  const names = data.variants.map((name) => 60 + 8 * name.length); // px in the legend
  const lines = wide
    ? Math.ceil(names.reduce((sum, width) => sum + width, 0) / plot.clientWidth)
    : names.length;
  const top = names.length < 2 ? 56 : 34 + 22 * lines;
  const layout = {
    autosize: true,
    height: down * (wide ? 300 : 230) + top + 34,
    margin: { l: 56, r: 8, t: top, b: 48 },
    paper_bgcolor: paper,
    plot_bgcolor: paper,
    font,
    hoverlabel: { bgcolor: paper, bordercolor: ink, font: { color: ink } },
    showlegend: data.variants.length > 1,
    legend: { orientation: "h", y: 1, yref: "container", yanchor: "top", x: 0 },
    dragmode: wide ? "zoom" : false, // a finger scrolls the page
    annotations: [],
    grid: {
      rows: down, columns: across, pattern: "independent", xgap: 0.04, ygap: data.axes ? 0.45 : 0.35,
    },
  };
  const traces = [], named = new Set(); // variants that the legend has
  const tints = dark.matches ? data.colours.dark : data.colours.light;
  for (let column = 0; column < columns; column++) {
    const end = column ? String(column + 1) : "";
    const first = column % across === 0;
    const axis = data.axes?.[column];
    const ticks = axis ? axis.ticks : data.rows;
    const below = axis ? axis.title : column >= columns - across ? data.row : "";
    layout[`xaxis${end}`] = {
      ...(ticks
        ? {
            tickvals: ticks.map((_, k) => k),
            ticktext: ticks.map(safe),
            range: [-0.6, ticks.length - 0.4],
          }
        : axis.log
          ? { type: "log", tickvals: steps(column), tickangle: 0 }
          : { nticks: 5, tickangle: 0 }),
      gridcolor: line, linecolor: line, zeroline: false, automargin: true,
      title: { text: safe(below), standoff: 8, font },
    };
    layout[`yaxis${end}`] = {
      gridcolor: line, zerolinecolor: line, showticklabels: first,
      matches: column ? "y" : undefined,
      title: { text: first ? safe(measure.title) : "", standoff: 8, font },
      ...(measure === SHARE ? { range: [-4, 104] } : {}),
    };
    layout.annotations.push({
      text: `<b>${safe(axis ? axis.name : data.columns[column])}</b>`, showarrow: false,
      xref: `x${end} domain`, yref: `y${end} domain`, x: 0, y: 1, xanchor: "left", yanchor: "bottom",
    });
    data.variants.forEach((name, variant) => {
      const of = measure === SHARE ? shares : data.axes ? scores : seeds;
      const points = of === shares ? shares(variant, column) : of(measure, variant, column);
      const tint = tints[variant % tints.length];
      const own = data.symbols?.[variant] ?? SYMBOLS[variant % SYMBOLS.length];
      const { symbols = own, error_y, ...rest } = points;
      traces.push({
        ...rest,
        type: "scatter", mode: "markers", name: safe(name), legendgroup: String(variant),
        showlegend: points.x.length > 0 && !named.has(variant), xaxis: `x${end}`, yaxis: `y${end}`, hoverinfo: "text",
        marker: { color: tint, symbol: symbols, size: own === "star" ? 14 : of === seeds ? 7 : 9 },
        ...(error_y ? { error_y: { ...error_y, color: tint } } : {}),
      });
      if (points.x.length) named.add(variant);
    });
  }
  const options = { responsive: true, displaylogo: false, displayModeBar: false, scrollZoom: false };
  window.Plotly.react(plot, traces, layout, options);
}

/** Unpack plotly and draw; the page is whole without it. */
async function start() {
  const packed = document.getElementById("plotly").textContent;
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);
  draw();
  plot.on("plotly_click", ({ points: [point] }) => openCell(...point.customdata));
  chooser.addEventListener("change", draw);
  dark.addEventListener("change", draw);
  addEventListener("beforeprint", draw);
  let width = plot.clientWidth;
  new ResizeObserver(() => {
    if ((plot.clientWidth >= NARROW) !== (width >= NARROW)) draw();
    width = plot.clientWidth;
  }).observe(plot);
  plot.dataset.drawn = "yes";
}

if (chooser) {
  new IntersectionObserver((seen, observer) => {
    if (!seen.some(({ isIntersecting }) => isIntersecting)) return;
    observer.disconnect();
    start();
  }, { rootMargin: "600px" }).observe(plot);
}
