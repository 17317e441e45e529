"use strict";
// The trials of the page as scenes of three.js. Metres, seconds, z up; the clock is that of the walk.
const walks = (() => {
  const page = JSON.parse(document.getElementById("replay").textContent);
  const ABSENT = 65535;
  const BLUE = 0x0072b2, VERMILLION = 0xd55e00;

  // What moves: one number over time a channel.

  async function unpacked(trial) {
    const bytes = Uint8Array.from(atob(trial.data), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const plain = new Uint8Array(await new Response(stream).arrayBuffer());
    const all = trial.channels.length * trial.count, channels = {};
    trial.channels.forEach(([name, low, step], k) => {
      const values = new Float64Array(trial.count);
      let level = 0;
      for (let i = 0, at = k * trial.count; i < trial.count; i += 1, at += 1) {
        level = (level + plain[at] + 256 * plain[all + at]) & 0xffff;
        values[i] = level === ABSENT ? NaN : low + step * level;
      }
      channels[name] = values;
    });
    return channels;
  }

  // What a trial is at an instant: between two frames in proportion.
  function sampler(channels, count) {
    const times = channels.time0;
    return (now) => {
      let low = 0, high = count - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (times[middle] <= now) low = middle; else high = middle;
      }
      const span = times[high] - times[low];
      const share = span > 0 ? Math.min(Math.max((now - times[low]) / span, 0), 1) : 1;
      const near = share < 0.5 ? low : high;
      const value = (name) => {
        const values = channels[name], a = values[low], b = values[high];
        return Number.isNaN(a + b) ? values[near] : a + share * (b - a);
      };
      const vector = (name, n, first = 0) =>
        Array.from({ length: n }, (_, k) => value(`${name}${first + k}`));
      return { value, vector, nearest: (name) => channels[name][near], now: times[near] };
    };
  }

  // The robot: a tree of groups, one a link, turned by its joint.

  function shapes(link) {
    const places = [], normals = [], colours = [];
    const a = new THREE.Vector3(), b = new THREE.Vector3(), c = new THREE.Vector3();
    for (const shape of link.shapes) {
      const colour = new THREE.Color(shape.colour);
      for (const polygon of shape.polygons) {
        a.fromArray(polygon[0]); b.fromArray(polygon[1]); c.fromArray(polygon[2]);
        const normal = b.sub(a).cross(c.sub(a)).normalize().toArray();
        for (let k = 1; k < polygon.length - 1; k += 1) {
          for (const corner of [polygon[0], polygon[k], polygon[k + 1]]) {
            places.push(...corner); normals.push(...normal); colours.push(...colour.toArray());
          }
        }
      }
    }
    return geometry(places, colours, normals);
  }

  function geometry(places, colours, normals) {
    const made = new THREE.BufferGeometry();
    made.setAttribute("position", new THREE.Float32BufferAttribute(places, 3));
    if (colours) made.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
    if (normals) made.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
    return made;
  }

  function body(robot, parts, material, throwsShadow) {
    const nodes = robot.links.map((link, k) => {
      const node = new THREE.Group(), mesh = new THREE.Mesh(parts[k], material);
      mesh.castShadow = throwsShadow;
      mesh.renderOrder = throwsShadow ? 0 : 4;
      node.add(mesh);
      node.position.fromArray(link.origin);
      return node;
    });
    robot.links.forEach((link, k) => link.parent >= 0 && nodes[link.parent].add(nodes[k]));
    const turns = robot.links.map((link) => link.turn && new THREE.Quaternion(...link.turn));
    const axes = robot.links.map((link) => link.axis && new THREE.Vector3(...link.axis));
    const turn = new THREE.Quaternion();
    function pose(trunk, rotation, angles) {
      nodes[0].position.fromArray(trunk);
      nodes[0].quaternion.set(...rotation).normalize();
      for (let k = 1; k < nodes.length; k += 1) {
        turn.setFromAxisAngle(axes[k], angles[k - 1]);
        if (turns[k]) nodes[k].quaternion.multiplyQuaternions(turns[k], turn);
        else nodes[k].quaternion.copy(turn);
      }
      nodes[0].updateMatrixWorld(true);
    }
    return { root: nodes[0], nodes, pose };
  }

  // The ground: a board in tiles, a layer or a pile on it, blades that give way to the soles.

  function seeded(state) {
    return () => {
      state = (state + 0x6d2b79f5) | 0;
      let t = Math.imul(state ^ (state >>> 15), 1 | state);
      t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
      return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
    };
  }

  function board(ground) {
    const { x, y, tile } = ground, top = ground.layer ? 0 : ground.bottom.height;
    const cover = new THREE.Color(ground.layer ? ground.board : ground.bottom.colour);
    const places = [], colours = [], normals = [];
    const quad = (corners, normal, colour, light) => {
      for (const k of [0, 1, 2, 0, 2, 3]) {
        places.push(...corners[k]); normals.push(...normal);
        colours.push(...colour.clone().multiplyScalar(light).toArray());
      }
    };
    const edges = ([low, high]) => {
      const cuts = [low];
      for (let k = Math.ceil(low / tile + 1e-9); k * tile < high - 1e-9; k += 1) cuts.push(k * tile);
      return [...cuts, high];
    };
    const [xs, ys] = [edges(x), edges(y)];
    for (let i = 0; i + 1 < xs.length; i += 1) {
      for (let j = 0; j + 1 < ys.length; j += 1) {
        const [a, b, c, d] = [xs[i], xs[i + 1], ys[j], ys[j + 1]];
        const odd = (Math.floor((a + b) / 2 / tile) + Math.floor((c + d) / 2 / tile)) & 1;
        const corners = [[a, c, top], [b, c, top], [b, d, top], [a, d, top]];
        quad(corners, [0, 0, 1], cover, odd ? ground.darker : 1);
      }
    }
    const wood = new THREE.Color(ground.board), low = -0.035;
    const ring = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
    [[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]].forEach((normal, k) => {
      const [p, q] = [ring[k], ring[(k + 1) % 4]];
      quad([[...p, low], [...q, low], [...q, top], [...p, top]], normal, wood, 1);
    });
    const material = new THREE.MeshLambertMaterial({ vertexColors: true });
    const mesh = new THREE.Mesh(geometry(places, colours, normals), material);
    mesh.receiveShadow = true;
    return mesh;
  }

  function pile(ground) {
    const group = new THREE.Group(), { x, y, height } = ground;
    if (!height) return { group, press: () => {} };
    const colour = ground.layer ? ground.bottom.colour : "#6fa548";
    const box = new THREE.BoxGeometry(x[1] - x[0], y[1] - y[0], height);
    const look = { color: colour, transparent: true, depthWrite: false, opacity: ground.layer ? 0.5 : 0.16 };
    const surface = new THREE.Mesh(box, new THREE.MeshLambertMaterial(look));
    surface.position.set((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, height / 2);
    surface.renderOrder = 2;
    group.add(surface);
    const { density, thinner, width, nap, dark, light } = ground.blades;
    if (!density) return { group, press: () => {} };

    const random = seeded(7), step = 1 / Math.sqrt(density), wide = width * thinner ** 0.58;
    const blades = [];
    for (let u = x[0] + step / 2; u < x[1]; u += step) {
      for (let v = y[0] + step / 2; v < y[1]; v += step) {
        const tall = height * (0.82 + 0.24 * random()), towards = 2 * Math.PI * random();
        const amount = 0.05 + 0.3 * random(), shade = random() ** 1.5;
        blades.push({
          u: Math.min(Math.max(u + (random() - 0.5) * 1.4 * step, x[0]), x[1]),
          v: Math.min(Math.max(v + (random() - 0.5) * 1.4 * step, y[0]), y[1]),
          tall, shade, towards: 2 * Math.PI * random(),
          lean: [tall * (amount * Math.cos(towards) + nap[0]), tall * (amount * Math.sin(towards) + nap[1])],
        });
      }
    }
    // A blade leans along its x by the square of its height, is wide along y and high along z.
    const at = [0, 0.55, 1], size = [0.5, 0.375, 0], places = [], colours = [];
    const point = (k, side) => {
      places.push(at[k] ** 2, side * size[k], at[k]);
      const bright = k === 0 ? 0.6 : k === 1 ? 0.8 : 1;
      colours.push(bright, bright, bright);
    };
    for (const [k, side] of [[0, -1], [0, 1], [1, 1], [0, -1], [1, 1], [1, -1], [1, -1], [1, 1], [2, 0]]) point(k, side);
    const material = new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide });
    const lawn = new THREE.InstancedMesh(geometry(places, colours), material, blades.length);
    lawn.frustumCulled = false;
    const matrix = new THREE.Matrix4(), colour2 = new THREE.Color();
    const set = (k, lean, tall, squeezed) => {
      const { u, v, towards, shade } = blades[k], bright = squeezed ? shade / 2 : shade;
      const [ex, ey] = [-Math.sin(towards) * wide, Math.cos(towards) * wide];
      matrix.set(lean[0], ex, 0, u, lean[1], ey, 0, v, 0, 0, tall, 0, 0, 0, 0, 1);
      lawn.setMatrixAt(k, matrix);
      lawn.setColorAt(k, colour2.setRGB(...dark.map((d, i) => d + bright * (light[i] - d))));
    };
    blades.forEach((blade, k) => set(k, blade.lean, blade.tall, false));
    group.add(lawn);

    let pressed = new Set();
    const inverse = new THREE.Matrix4(), root = new THREE.Vector3();
    function press(soles) {
      const now = new Map();
      for (const { matrix: placed, corners } of soles) {
        inverse.copy(placed).invert();
        const [low, high] = [corners[0], corners[2]], e = placed.elements;
        if (e[10] < 0.2) continue; // tipped over: it lies beside the blades, not on them
        blades.forEach((blade, k) => {
          if (Math.abs(blade.u - e[12]) > 0.3 || Math.abs(blade.v - e[13]) > 0.3) return;
          root.set(blade.u, blade.v, e[14]).applyMatrix4(inverse);
          if (root.x < low[0] || root.x > high[0] || root.y < low[1] || root.y > high[1]) return;
          // The sole's height over the root: along world z through its plane.
          const gap = Math.max(e[14] + (low[2] - root.z) / e[10], 0);
          if (gap < blade.tall && gap < (now.get(k) ?? Infinity)) now.set(k, gap);
        });
      }
      for (const k of pressed) if (!now.has(k)) set(k, blades[k].lean, blades[k].tall, false);
      for (const [k, gap] of now) {
        const { towards, tall } = blades[k], fold = 0.5 * Math.sqrt(tall * tall - gap * gap);
        set(k, [Math.cos(towards) * fold, Math.sin(towards) * fold], gap, true);
      }
      if (now.size || pressed.size) {
        lawn.instanceMatrix.needsUpdate = true;
        lawn.instanceColor.needsUpdate = true;
      }
      pressed = new Set(now.keys());
    }
    return { group, press };
  }

  // What is drawn over it: loads, ZMP, support polygon.

  const over = (colour, opacity = 1) =>
    new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity, depthTest: false, depthWrite: false, side: THREE.DoubleSide });

  function arrow(size) {
    const group = new THREE.Group(), material = over(VERMILLION, 0.92);
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 12), material);
    const head = new THREE.Mesh(new THREE.ConeGeometry(1, 1, 16), material);
    const thin = 0.007 * size, wide = 0.02 * size, tip = 0.05 * size;
    group.add(shaft, head);
    group.traverse((part) => { part.renderOrder = 11; });
    const along = new THREE.Vector3(), axis = new THREE.Vector3(0, 1, 0);
    function point(from, force) {
      along.fromArray(force);
      const length = along.length(), cone = Math.min(tip, 0.7 * length);
      group.position.copy(from);
      group.quaternion.setFromUnitVectors(axis, along.normalize());
      shaft.scale.set(thin, Math.max(length - cone, 1e-6), thin);
      shaft.position.y = (length - cone) / 2;
      head.scale.set(wide, cone, wide);
      head.position.y = length - cone / 2;
    }
    return { group, point };
  }

  function hull(points) {
    const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
    const half = (ordered) => {
      const kept = [];
      for (const p of ordered) {
        while (kept.length > 1) {
          const [a, b] = kept.slice(-2);
          if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
          kept.pop();
        }
        kept.push(p);
      }
      return kept.slice(0, -1);
    };
    return [...half(sorted), ...half(sorted.reverse())];
  }

  function polygon(size) {
    const group = new THREE.Group(), fill = new THREE.Mesh(geometry([]), over(BLUE, 0.22));
    const rim = new THREE.Mesh(geometry([]), over(BLUE));
    fill.renderOrder = 8; rim.renderOrder = 9;
    fill.frustumCulled = rim.frustumCulled = false;
    group.add(fill, rim);
    const wide = 0.005 * size;
    function draw(points) {
      const ring = points.length > 2 ? hull(points) : [];
      group.visible = ring.length > 2;
      const inner = [], edge = [];
      ring.forEach((p, k) => {
        const q = ring[(k + 1) % ring.length];
        if (k > 0 && k < ring.length - 1) inner.push(...ring[0].toArray(), ...p.toArray(), ...q.toArray());
        const length = Math.hypot(q.x - p.x, q.y - p.y) || 1;
        const [dx, dy] = [(-(q.y - p.y) / length) * wide, ((q.x - p.x) / length) * wide];
        const [a, b] = [[p.x - dx, p.y - dy, p.z], [q.x - dx, q.y - dy, q.z]];
        const [c, d] = [[q.x + dx, q.y + dy, q.z], [p.x + dx, p.y + dy, p.z]];
        edge.push(...a, ...b, ...c, ...a, ...c, ...d);
      });
      fill.geometry.setAttribute("position", new THREE.Float32BufferAttribute(inner, 3));
      rim.geometry.setAttribute("position", new THREE.Float32BufferAttribute(edge, 3));
    }
    return { group, draw };
  }

  function dot(size) {
    const group = new THREE.Group(), ball = new THREE.SphereGeometry(1, 20, 12);
    [[0xffffff, 0.0145, 12], [0x000000, 0.0105, 13]].forEach(([colour, radius, order]) => {
      const mesh = new THREE.Mesh(ball, over(colour));
      mesh.scale.setScalar(radius * size);
      mesh.renderOrder = order;
      group.add(mesh);
    });
    return group;
  }

  // A trial with everything that shows it.

  const shown = { target: true, load: true, support: true, zmp: true, pile: true };

  async function stage(trial) {
    const channels = await unpacked(trial), at = sampler(channels, trial.count);
    const robot = page.robots[trial.robot], { size } = trial;
    const scene = new THREE.Scene();
    scene.add(new THREE.HemisphereLight(0xffffff, 0xb9ae9c, 0.72));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.42);
    lamp.castShadow = true;
    lamp.shadow.mapSize.set(1024, 1024);
    lamp.shadow.bias = -0.002;
    Object.assign(lamp.shadow.camera, { left: -1.3 * size, right: 1.3 * size, top: 1.3 * size, bottom: -1.3 * size, near: 0.1 * size, far: 8 * size });
    scene.add(lamp, lamp.target);

    const parts = robot.links.map(shapes);
    const solid = new THREE.MeshLambertMaterial({ vertexColors: true });
    // Where the target is met, the robot itself is seen.
    const pale = new THREE.MeshBasicMaterial({ color: 0x3a9bd9, transparent: true, opacity: 0.34, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 400 });
    const real = body(robot, parts, solid, true), wanted = body(robot, parts, pale, false);
    const grass = pile(trial.ground), support = polygon(size), zmp = dot(size);
    const loads = [arrow(size), arrow(size)];
    scene.add(real.root, wanted.root, board(trial.ground), grass.group, support.group, zmp);
    loads.forEach((load) => scene.add(load.group));
    const corners = robot.soles.map((sole) => sole.map((corner) => new THREE.Vector3(...corner)));
    const joints = trial.joints;

    function show(now) {
      const state = at(now), trunk = state.vector("trunk", 3), turn = state.vector("turn", 4);
      real.pose(trunk, turn, state.vector("joint", joints));
      wanted.root.visible = shown.target;
      if (shown.target) wanted.pose(trunk, turn, state.vector("target", joints));
      const feet = robot.feet.map((foot) => real.nodes[foot].matrixWorld);
      const placed = corners.map((sole, f) => sole.map((corner) => corner.clone().applyMatrix4(feet[f])));
      const loaded = placed.filter((_, f) => state.nearest(`contact${f}`) > 0.5);
      support.draw(shown.support ? loaded.flat() : []);
      loads.forEach((load, f) => {
        const force = state.vector("load", 3, 3 * f);
        load.group.visible = shown.load && force[2] > trial.unloaded * trial.weight;
        const middle = placed[f].reduce((sum, p) => sum.add(p), new THREE.Vector3()).divideScalar(4);
        if (load.group.visible) load.point(middle, force.map((part) => (trial.reach * size * part) / trial.weight));
      });
      const place = state.vector("zmp", 3);
      zmp.visible = shown.zmp && place.every(Number.isFinite);
      if (zmp.visible) zmp.position.fromArray(place);
      grass.group.visible = shown.pile;
      if (shown.pile) grass.press(robot.feet.map((_, f) => ({ matrix: feet[f], corners: robot.soles[f] })));
      const focus = [...state.vector("focus", 2), 0.53 * size];
      lamp.target.position.fromArray(focus);
      lamp.position.set(focus[0] + 1.4 * size, focus[1] - 2.2 * size, focus[2] + 3.04 * size);
      return { focus, phase: state.nearest("phase0"), contact: [0, 1].map((f) => state.nearest(`contact${f}`) > 0.5) };
    }
    const places = () => Object.fromEntries(robot.links.map((link, k) =>
      [link.name, new THREE.Vector3().setFromMatrixPosition(real.nodes[k].matrixWorld).toArray()]));
    const times = channels.time0;
    return { trial, scene, show, places, channels, times, begin: times[0], end: times[trial.count - 1] };
  }

  return { page, shown, stage };
})();
