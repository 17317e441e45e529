// Plays the scenes: where they are looked at from, the clock, and what the page says.
(() => {
  const { page, shown, stage } = walks;
  const by = (id) => document.getElementById(id);

  // Where it is looked at from: the same for both trials.

  const view = { ...page.view, follow: true, moved: [0, 0, 0] };
  const first = { ...view };

  function look(camera, focus, size) {
    const { azimuth: a, elevation: e } = view, distance = view.distance * size;
    const target = focus.map((value, k) => value + view.moved[k] * size);
    camera.position.set(
      target[0] + distance * Math.cos(e) * Math.cos(a),
      target[1] + distance * Math.cos(e) * Math.sin(a),
      target[2] + distance * Math.sin(e),
    );
    camera.lookAt(...target);
  }

  function steer(canvas) {
    const fingers = new Map();
    const spread = () => {
      const [p, q] = [...fingers.values()];
      return { x: (p.x + q.x) / 2, y: (p.y + q.y) / 2, apart: Math.hypot(p.x - q.x, p.y - q.y) };
    };
    const turn = (dx, dy) => {
      view.azimuth -= 0.007 * dx;
      view.elevation = Math.min(Math.max(view.elevation + 0.007 * dy, -0.05), 1.55);
    };
    const shift = (dx, dy) => {
      const scale = (view.distance * 0.44) / canvas.clientHeight, { azimuth: a, elevation: e } = view;
      view.moved = view.moved.map((value, k) => value + scale * (
        dx * [Math.sin(a), -Math.cos(a), 0][k]
        + dy * [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)][k]));
    };
    const zoom = (factor) => { view.distance = Math.min(Math.max(view.distance * factor, 0.6), 40); };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const before = fingers.size === 2 ? spread() : null;
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (before) {
        const after = spread();
        shift(after.x - before.x, after.y - before.y);
        zoom(before.apart / Math.max(after.apart, 1));
      } else if (event.shiftKey || event.buttons & 6) shift(dx, dy);
      else turn(dx, dy);
      draw();
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(kind, (event) => fingers.delete(event.pointerId));
    }
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      zoom(Math.exp(0.001 * event.deltaY));
      draw();
    }, { passive: false });
  }

  // The clock, and what the page says.

  let stages = [], now = 0, begin = 0, end = 0, playing = false, last = 0, wanted = false, kept = [];
  let renderer = null;
  const camera = new THREE.PerspectiveCamera(24, 1, 0.02, 60);
  camera.up.set(0, 0, 1);
  const speed = () => Number(by("speed").value);
  const clock = (value) => `${value.toFixed(2)} s`;

  function element(kind, name, text) {
    const made = document.createElement(kind);
    if (name) made.className = name;
    if (text !== undefined) made.textContent = text;
    return made;
  }

  function panel({ trial }) {
    const section = element("section", `panel${trial.fell === null ? "" : " fell"}`), plate = element("div");
    plate.append(element("h2", "", trial.title));
    if (trial.cell) plate.append(element("p", "cell", trial.cell));
    plate.append(element("p", "caption", trial.caption), element("p", "verdict", trial.verdict));
    const gait = element("p", "gait"), meter = element("meter"), text = element("span");
    const feet = ["L", "R"].map((name) => element("b", "", name));
    feet[0].title = "left foot loaded"; feet[1].title = "right foot loaded";
    meter.setAttribute("aria-label", "gait phase");
    gait.append(meter, ...feet, text);
    plate.append(gait);
    section.append(plate);
    section.update = ({ phase, contact }) => {
      meter.value = Number.isFinite(phase) ? phase : 0;
      text.textContent = Number.isFinite(phase) ? `phase ${phase.toFixed(2)}` : "start-up";
      contact.forEach((loaded, k) => feet[k].classList.toggle("loaded", loaded));
      section.classList.toggle("down", trial.fell !== null && now >= trial.fell - 1e-6);
    };
    return section;
  }

  function marks() {
    by("timeline").querySelectorAll(".fall").forEach((mark) => mark.remove());
    const share = (value) => (end > begin ? (value - begin) / (end - begin) : 0);
    by("time").style.setProperty("--start", `${100 * Math.min(Math.max(share(0), 0), 1)}%`);
    stages.forEach(({ trial }, k) => {
      if (trial.fell === null || trial.fell < begin - 1e-6 || trial.fell > end + 1e-6) return;
      const at = share(trial.fell), right = at > 0.5;
      const name = stages.length > 1 ? ["first", "second"][k] : "";
      const mark = element("button", `fall ${right ? "right" : "left"}`, right ? `${name ? `${name} ` : ""}fell ${clock(trial.fell)} ▼` : `▼ ${name ? `${name} ` : ""}fell ${clock(trial.fell)}`);
      mark.title = "show the second before it";
      mark.style.left = `calc(9px + ${at} * (100% - 18px))`;
      if (k && Math.abs(at - share(stages[0].trial.fell ?? -1e9)) < 0.2) mark.style.top = "-17px";
      mark.addEventListener("click", () => { seek(trial.fell - 1); play(true); });
      by("timeline").append(mark);
    });
  }

  function paint() {
    wanted = false;
    if (playing) {
      const moment = performance.now();
      now += (Math.min(moment - last, 250) / 1000) * speed();
      last = moment;
      if (now >= end) { now = end; play(false); }
    }
    const canvas = by("canvas"), box = canvas.getBoundingClientRect(), ratio = Math.min(devicePixelRatio || 1, 2);
    renderer.setPixelRatio(ratio);
    if (canvas.width !== Math.floor(box.width * ratio) || canvas.height !== Math.floor(box.height * ratio)) renderer.setSize(box.width, box.height, false);
    renderer.setScissorTest(true);
    stages.forEach((each, k) => {
      const section = by("panels").children[k], place = section.getBoundingClientRect();
      const state = each.show(now);
      if (!view.follow) state.focus = kept[k] ?? state.focus;
      kept[k] = state.focus;
      const area = [place.left - box.left, box.bottom - place.bottom, place.width, place.height];
      renderer.setViewport(...area);
      renderer.setScissor(...area);
      camera.aspect = place.width / Math.max(place.height, 1);
      // A narrow panel would cut the robot off at its sides.
      camera.fov = camera.aspect < 0.8 ? (2 * 180 / Math.PI) * Math.atan(0.17 / camera.aspect) : 24;
      const plate = section.firstElementChild.getBoundingClientRect(); // the robot stands below what is said of it
      const covered = plate.right > place.left + place.width / 2 ? plate.bottom - place.top : 0;
      camera.setViewOffset(place.width, place.height, 0, -covered / 2, place.width, place.height);
      camera.updateProjectionMatrix();
      look(camera, state.focus, each.trial.size);
      renderer.render(each.scene, camera);
      section.update(state);
    });
    strip.show(now);
    by("time").value = now;
    by("clock").textContent = clock(now);
    by("time").setAttribute("aria-valuetext", clock(now));
    if (playing) draw();
  }

  function draw() {
    if (!wanted && renderer) { wanted = true; requestAnimationFrame(paint); }
  }

  function seek(instant) {
    now = Math.min(Math.max(instant, begin), end);
    draw();
  }

  function play(on) {
    if (on && now >= end) now = begin;
    playing = on && end > begin;
    last = performance.now();
    by("play").textContent = playing ? "❚❚" : "▶";
    by("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    draw();
  }

  function step(count) {
    play(false);
    const times = stages[0].times, near = times.findIndex((time) => time >= now - 1e-6);
    const index = (near < 0 ? times.length - 1 : near) + count;
    seek(times[Math.min(Math.max(index, 0), times.length - 1)]);
  }

  const short = (id) => id.slice(0, 8); // as `address` in replay_page.py

  // Addresses: replay.html#TRIAL, #TRIAL,OTHER, #TRIAL&t=1.5
  async function choose() {
    const [names, ...options] = decodeURIComponent(location.hash.slice(1)).split("&");
    const byName = (name) => name.length > 3 && page.trials.find((trial) => trial.id.startsWith(name));
    const asked = names.split(",").map(byName).filter(Boolean);
    const chosen = asked.length ? asked.slice(0, 2) : page.shown.map((k) => page.trials[k]);
    if (!stages.length || stages.some((each, k) => each.trial !== chosen[k]) || stages.length !== chosen.length) {
      play(false);
      stages = await Promise.all(chosen.map(stage));
      kept = [];
      begin = Math.min(...stages.map((each) => each.begin));
      end = Math.max(...stages.map((each) => each.end));
      Object.assign(by("time"), { min: begin, max: end });
      by("panels").replaceChildren(...stages.map(panel));
      strip.of(stages, begin, end);
      marks();
      const falls = stages.map((each) => each.trial.fell).filter((fell) => fell !== null);
      now = page.menu && falls.length ? Math.max(Math.min(...falls) - 2, begin) : begin;
      document.querySelectorAll("#menu a").forEach((link) => {
        const own = chosen.some((trial) => link.hash === `#${short(trial.id)}`);
        if (own) link.setAttribute("aria-current", "true"); else link.removeAttribute("aria-current");
      });
      by("canvas").setAttribute("aria-label", chosen.map((trial) => `${trial.title}: ${trial.verdict}`).join("; "));
      by("beside").value = chosen[1] ? chosen[1].id : "";
    }
    const instant = options.find((option) => option.startsWith("t="));
    if (instant) { play(false); seek(Number(instant.slice(2)) || 0); }
    else play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  function trouble(text) {
    by("trouble").textContent = text;
    by("trouble").hidden = false;
  }

  const pressed = (id, on) => by(id).setAttribute("aria-pressed", on);

  function controls() {
    for (const name of [...Object.keys(shown), "follow", "plots"]) pressed(name, true);
    strip.controls((instant) => { play(false); seek(instant); });
    by("plots").addEventListener("click", () => {
      by("strip").hidden = !by("strip").hidden;
      pressed("plots", !by("strip").hidden);
      draw();
    });
    by("play").addEventListener("click", () => play(!playing));
    by("back").addEventListener("click", () => step(-1));
    by("on").addEventListener("click", () => step(1));
    by("time").addEventListener("input", (event) => { play(false); seek(Number(event.target.value)); });
    by("speed").addEventListener("change", () => { last = performance.now(); });
    by("reset").addEventListener("click", () => { Object.assign(view, first); pressed("follow", true); draw(); });
    for (const name of Object.keys(shown)) {
      by(name).addEventListener("click", () => { shown[name] = !shown[name]; pressed(name, shown[name]); draw(); });
    }
    by("follow").addEventListener("click", () => { view.follow = !view.follow; pressed("follow", view.follow); draw(); });
    const beside = by("beside");
    page.trials.forEach((trial) => {
      const option = element("option", "", [trial.cell || trial.title, trial.role, short(trial.id)].filter(Boolean).join(", "));
      option.value = trial.id;
      beside.append(option);
    });
    beside.parentElement.hidden = page.trials.length < 3;
    beside.addEventListener("change", () => {
      const names = [stages[0].trial.id, beside.value].filter(Boolean).map(short);
      location.hash = names.join(",");
    });
    addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, textarea")) return;
      const keys = {
        " ": () => play(!playing), ArrowLeft: () => step(event.shiftKey ? -10 : -1),
        ArrowRight: () => step(event.shiftKey ? 10 : 1), Home: () => seek(begin), End: () => seek(end),
      };
      const action = keys[event.key];
      // A button that has the focus is pressed by the space bar itself.
      if (!action || (event.key === " " && event.target.matches("button, a, summary"))) return;
      event.preventDefault();
      action();
    });
    addEventListener("resize", draw);
    new ResizeObserver(draw).observe(by("stage"));
    addEventListener("hashchange", () => {
      choose();
      by("stage").scrollIntoView({ block: "nearest" }); // on a phone the table lies below it
    });
  }

  async function start() {
    try {
      renderer = new THREE.WebGLRenderer({ canvas: by("canvas"), antialias: true, alpha: true });
    } catch (error) {
      trouble("This browser draws no 3-D pictures (WebGL is off or missing). Another browser will; or write a film with gaitlab replay TRIAL --output fall.mp4.");
      return;
    }
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    if (typeof DecompressionStream === "undefined") {
      trouble("This browser is too old to unpack the trial: Chromium 80, Firefox 113 or Safari 16.4 and later do.");
      return;
    }
    controls();
    steer(by("canvas"));
    if (page.trials.length) await choose();
    else by("controls").hidden = true;
  }

  // For scripts of a page around it.
  window.replay = {
    seek: (instant) => { play(false); seek(instant); },
    state: () => ({ now, begin, end, playing, speed: speed(), view: { ...view }, shown: { ...shown }, trials: stages.map((each) => each.trial.id) }),
    links: (k = 0) => { stages[k].show(now); return stages[k].places(); },
  };
  start().finally(() => { document.body.dataset.ready = "yes"; });
})();
