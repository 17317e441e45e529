"use strict";

const CLOSEST = 40; // largest magnification
const STEP = 1.4; // of one press of a key or button
const HINT =
  "Click, then turn the wheel to zoom (or hold Ctrl); drag to move; double-click to reset. " +
  "Keys: + and -, arrows, 0.";

/** Let a reader look closer at one drawing: wheel, drag, double-click, keys and buttons. */
function zoomable(figure) {
  const svg = figure.querySelector("svg");
  const [left, top, width, height] = svg.getAttribute("viewBox").split(/[\s,]+/).map(Number);
  let view = { x: left, y: top, share: 1 };

  const between = (value, low, high) => Math.min(Math.max(value, low), high);
  const show = ({ x, y, share }) => {
    const kept = between(share, 1 / CLOSEST, 1);
    view = {
      x: between(x, left, left + width * (1 - kept)),
      y: between(y, top, top + height * (1 - kept)),
      share: kept,
    };
    svg.setAttribute("viewBox", `${view.x} ${view.y} ${width * kept} ${height * kept}`);
    figure.classList.toggle("zoomed", kept < 1);
  };
  const reset = () => show({ x: left, y: top, share: 1 });
  const zoom = (factor, at) => {
    const share = between(view.share / factor, 1 / CLOSEST, 1);
    const ratio = share / view.share;
    const x = at.x - (at.x - view.x) * ratio;
    show({ x, y: at.y - (at.y - view.y) * ratio, share });
  };
  const pan = (dx, dy) => show({ ...view, x: view.x + dx, y: view.y + dy });
  const middle = () => ({
    x: view.x + 0.5 * width * view.share,
    y: view.y + 0.5 * height * view.share,
  });
  const place = (event) =>
    new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());

  svg.addEventListener(
    "wheel",
    (event) => {
      const meant = event.ctrlKey || document.activeElement === svg;
      if (!meant || (event.deltaY > 0 && view.share === 1)) return; // the page scrolls
      event.preventDefault();
      zoom(Math.exp(-0.002 * between(event.deltaY, -250, 250)), place(event));
    },
    { passive: false },
  );
  let held = null;
  svg.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    svg.focus({ preventScroll: true });
    held = place(event);
    svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointermove", (event) => {
    if (held === null || view.share === 1) return;
    const now = place(event);
    pan(held.x - now.x, held.y - now.y);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    svg.addEventListener(end, () => {
      held = null;
    });
  }
  svg.addEventListener("dblclick", reset);
  const move = 0.1;
  const keys = {
    "+": () => zoom(STEP, middle()),
    "=": () => zoom(STEP, middle()),
    "-": () => zoom(1 / STEP, middle()),
    0: reset,
    Escape: reset,
    ArrowLeft: () => pan(-move * width * view.share, 0),
    ArrowRight: () => pan(move * width * view.share, 0),
    ArrowUp: () => pan(0, -move * height * view.share),
    ArrowDown: () => pan(0, move * height * view.share),
  };
  svg.addEventListener("keydown", (event) => {
    const moves = event.key.startsWith("Arrow") && view.share === 1;
    if (event.ctrlKey || event.metaKey || event.altKey || moves || !(event.key in keys)) return;
    event.preventDefault();
    keys[event.key]();
  });

  const bar = document.createElement("div");
  bar.className = "zoom";
  bar.title = HINT;
  const buttons = [
    ["+", "Zoom in", keys["+"]],
    ["\u2212", "Zoom out", keys["-"]],
    ["\u21ba", "Show all", reset],
  ];
  for (const [sign, name, act] of buttons) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = sign;
    button.setAttribute("aria-label", name);
    button.addEventListener("click", act);
    bar.append(button);
  }
  figure.append(bar);
}

/** Let a reader order a table by a column: rising, falling, as it was. */
function sortable(table) {
  const body = table.tBodies[0];
  const heads = table.tHead ? [...table.tHead.rows[0].cells] : [];
  if (!body || body.rows.length < 2) return;
  const before = [...body.rows];
  const key = (row, column) => row.cells[column].textContent.trim();
  const number = (text) => {
    const found = text.match(/[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?/);
    return found ? Number(found[0]) : Number.NaN;
  };
  heads.forEach((head, column) => {
    if (!head.textContent.trim()) return;
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const state = head.getAttribute("aria-sort");
      for (const other of heads) other.removeAttribute("aria-sort");
      if (state === "descending") return body.append(...before);
      const sign = state === "ascending" ? -1 : 1;
      head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
      const known = before.filter((row) => key(row, column) !== "\u2014");
      const numeric = known.every((row) => !Number.isNaN(number(key(row, column))));
      const compare = numeric
        ? (a, b) => number(key(a, column)) - number(key(b, column))
        : (a, b) => key(a, column).localeCompare(key(b, column));
      known.sort((a, b) => sign * compare(a, b));
      const unknown = before.filter((row) => !known.includes(row));
      return body.append(...known, ...unknown);
    });
  });
}

/** Open the blocks around what a link points to. */
function reveal() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (let block = target; block; block = block.parentElement) {
    if (block instanceof HTMLDetailsElement) block.open = true;
  }
  target?.scrollIntoView();
}

document.querySelectorAll("figure.drawing").forEach(zoomable);
document.querySelectorAll("table").forEach(sortable);
addEventListener("hashchange", reveal);
if (location.hash) reveal();
addEventListener("beforeprint", () => {
  for (const block of document.querySelectorAll("details")) block.open = true;
});
if (matchMedia("(max-width: 83.9rem)").matches) {
  document.querySelector("nav details")?.removeAttribute("open");
}
