// The player of the Watch panel: adds Play to every task, and draws both episodes at once (figure.js).
// Kinematics as in gym_extensions.site.play.watch, the text of motions as in gym_extensions.submissions.poses.
"use strict";
(() => {
  const DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const { dot } = figure, { make } = page;

  // The coordinates of a clip: an array of numbers per frame.
  function decode([frames, motion], unit) {
    const rows = Array.from({ length: frames }, () => []);
    let rest = 0, shift = 0, total = 0, count = 0;
    for (const character of motion) {
      const digit = DIGITS.indexOf(character);
      rest += (digit & 31) * 2 ** shift;
      shift += 5;
      if (digit > 31) continue;
      const frame = count++ % frames;
      total = (frame ? total : 0) + (rest & 1 ? -(rest >> 1) : rest >> 1);
      rows[frame].push(total * unit);
      rest = shift = 0;
    }
    return rows;
  }

  // Rows of a rotation matrix.
  function rotation([w, x, y, z]) {
    const n = w * w + x * x + y * y + z * z, s = 2 / n;
    return [[1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
      [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
      [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)]];
  }
  const turned = (m, v) => m.map((row) => dot(row, v));
  const sum = (a, b, k = 1) => a.map((value, i) => value + k * b[i]);
  const product = (a, b) => a.map((row) => [0, 1, 2].map((j) => row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]));
  const WORLD = { origin: [0, 0, 0], turn: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] };

  // The shapes of a skeleton as [role, radius, x1, y1, x2, y2] in m, y up.
  function placed([view, links], q) {
    const { right, up } = figure.directions(...view.map((degrees) => degrees * Math.PI / 180));
    const poses = [], shapes = [];
    for (const [parent, position, quaternion, joints, content] of links) {
      const base = poses[parent] || WORLD;
      let origin = sum(base.origin, turned(base.turn, position)), turn = product(base.turn, rotation(quaternion));
      for (const [kind, at, axis, anchor, rest] of joints) {
        if (!kind) {
          origin = q.slice(at, at + 3);
          turn = rotation(q.slice(at + 3, at + 7));
        } else if (kind === 2) {
          origin = sum(origin, turned(turn, axis), q[at] - rest);
        } else {
          const half = (q[at] - rest) / 2, sine = Math.sin(half);
          const pivot = sum(origin, turned(turn, anchor));
          turn = product(turn, rotation([Math.cos(half), ...axis.map((value) => value * sine)]));
          origin = sum(pivot, turned(turn, anchor), -1);
        }
      }
      poses.push({ origin, turn });
      for (const [role, radius, first, second] of content) {
        const ends = role === "wall" ? [sum(first, second, -1), sum(first, second)] : [first, second];
        shapes.push([role, radius, ...ends.flatMap((end) => {
          const point = sum(origin, role === "world-beam" ? end : turned(turn, end));
          return [dot(point, right), dot(point, up)];
        })]);
      }
    }
    return shapes;
  }

  // Linear between two frames.
  function between(rows, time) {
    const frame = Math.min(Math.floor(time), rows.length - 1), next = rows[Math.min(frame + 1, rows.length - 1)];
    return rows[frame].map((value, i) => value + (next[i] - value) * (time - frame));
  }

  // The part of the view, [left, bottom, right, top], that shows a body in every frame; left and right are
  // relative to the body if it travels.
  function extent(task, skeleton) {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (const rows of task.rows) for (let i = 0; i < rows.length; i += 5) {
      for (const [role, radius, ...ends] of placed(skeleton, rows[i])) {
        if (role === "wall") box[2] = Math.max(box[2], 2.5);
        if (role === "wall" || role.endsWith("beam")) continue;
        for (const k of [0, 2]) {
          const x = ends[k] - (task.travels ? rows[i][0] : 0), y = ends[k + 1];
          box[0] = Math.min(box[0], x - radius);
          box[1] = Math.min(box[1], y - radius);
          box[2] = Math.max(box[2], x + radius);
          box[3] = Math.max(box[3], y + radius);
        }
      }
    }
    if (task.travels) box[1] = Math.min(box[1], -0.1);
    return [box[0] - 0.1, box[1] - 0.1, box[2] + 0.1, box[3] + 0.1];
  }

  function player(section, data) {
    const task = data.tasks[section.dataset.task];
    task.rows = task.clips.map((clip) => decode(clip, task.unit));
    const skeleton = data.skeletons[task.skeleton], frames = Math.max(...task.rows.map((rows) => rows.length));
    const box = skeleton ? extent(task, skeleton) : [0, 0, 640, 480];
    const canvases = [...section.querySelectorAll(".stage")].map((stage) => {
      const canvas = make("canvas", { role: "img", ariaLabel: stage.firstElementChild.getAttribute("aria-label") });
      stage.append(canvas);
      return canvas;
    });

    function draw(canvas, rows, time) {
      const q = between(rows, time), view = figure.view(canvas, box, task.travels ? q[0] : 0);
      if (skeleton) {
        if (task.travels) figure.floor(view);
        figure.shapes(view, placed(skeleton, q));
        return;
      }
      const { pen, colour, X, Y, scale, disc } = view;
      pen.fillStyle = colour("--strong-rule");
      for (const [x, y, w, h] of data.maps[task.map]) pen.fillRect(X(x), Y(480 - y), w * scale, h * scale);
      disc(X(task.goal[0]), Y(480 - task.goal[1]), 20 * scale, "--gain");
      pen.strokeStyle = colour("--accent");
      pen.lineWidth = 2;
      pen.beginPath();
      for (const [x, y] of [...rows.slice(0, Math.floor(time) + 1), q]) pen.lineTo(X(x), Y(y));
      pen.stroke();
      disc(X(q[0]), Y(q[1]), 5, "--ink");
    }

    const range = make("input", { type: "range", min: 0, max: frames - 1, step: 0.1, value: 0 });
    const select = make("select"), output = make("output", { ariaLive: "off" }), button = section.querySelector(".play");
    figure.speeds(select);
    button.after(make("div", { className: "controls" }, make("label", {}, "Time ", range), " ", make("label", {}, "Speed ", select), " ", output));
    section.classList.add("playing");

    let time = 0, running = false;
    function show() {
      const shown = skeleton ? `${(time / task.rate).toFixed(1)} s` : `${Math.round(100 * time / (frames - 1 || 1))} %`;
      canvases.forEach((canvas, i) => draw(canvas, task.rows[i], Math.min(time, task.rows[i].length - 1)));
      range.value = time;
      range.setAttribute("aria-valuetext", shown);
      output.value = shown;
    }
    const clock = figure.clock((elapsed) => {
      time += elapsed * task.rate * select.value;
      if (time >= frames - 1) {
        time = figure.calm.matches ? frames - 1 : 0;
        if (figure.calm.matches) run(false);
      }
      show();
    });
    function run(on) {
      if (on && time >= frames - 1) time = 0;
      running = on;
      button.textContent = on ? "Pause" : "Replay";
      clock(on);
    }
    range.addEventListener("input", () => { run(false); time = +range.value; show(); });
    addEventListener("resize", show);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
    show();
    return () => run(!running);
  }

  // The poses of a group, null where they are not loaded. Their script, loaded once, calls watchPoses. (fetch does not work from file://.)
  const loads = {}, ready = {};
  globalThis.watchPoses = (id, data) => ready[id](data);
  const load = ({ dataset: { poses, script } }) => loads[poses] ??= new Promise((done) => {
    ready[poses] = done;
    const onerror = () => { delete loads[poses]; done(null); };
    document.head.append(make("script", { src: script, onerror }));
  });

  for (const section of document.querySelectorAll(".watch")) {
    const button = make("button", { type: "button", className: "play" }, "Replay");
    let toggle = null;
    button.setAttribute("aria-describedby", section.getAttribute("aria-labelledby"));
    button.addEventListener("click", async () => {
      if (toggle) return toggle();
      button.disabled = true;
      button.textContent = "Loading …";
      const data = await load(section);
      button.disabled = false;
      button.textContent = data ? "Replay" : "Not loaded. Try again";
      button.focus();
      if (data) (toggle = player(section, data))();
    });
    section.querySelector("h4").after(button);
  }
})();
