// The controls of the page Play, and its two sides: each a world with a policy, drawn while it runs.
import { readPolicies } from "./policy.js";
import { beams, normal } from "./rules.js";
import { World } from "./world.js";
import { camera, drawSpace } from "./space.js";

const PUSH = 0.15, PUSH_REACH = 1, LONGEST_FRAME = 0.1, MOST_WORK = 40;
const EXPERT = "/expert", NOBODY = "/none"; // no name of a submission has a slash
const BOX = [-1.7, -0.2, 1.9, 2], NEAR = 0.4, PAUSE = 1.5;
const by = (id) => document.getElementById(`play-${id}`);
const fill = (select, rows) => select.replaceChildren(...rows.map(([value, text]) => new Option(text, value)));
const numbered = (text, other) => (text && Number.isFinite(Number(text)) ? Number(text) : other);

// One of the two figures: menus, a canvas, a policy, and its own world.
class Side {
  constructor(figure, panel, at) {
    Object.assign(this, { panel, at, past: [] }); // returns of its episodes, and whether they ended with a fall
    this.canvas = figure.querySelector("canvas");
    this.caption = figure.querySelector("figcaption");
    this.menu = figure.querySelector(".policy");
    this.stages = figure.querySelector(".stage-of");
    this.runs = figure.querySelector(".run-of");
    this.take = figure.querySelector(".download");
    this.menu.addEventListener("change", () => this.choose().then(() => panel.restart()));
    this.runs.addEventListener("change", () => this.load(this.stages.value).then(() => panel.restart()));
    this.stages.addEventListener("change", () => panel.restart());
    this.canvas.addEventListener("pointerdown", (event) => this.grasp(event));
    // A finger scrolls the page, unless it is on a body.
    this.canvas.addEventListener("touchstart", (event) => { if (this.grip) event.preventDefault(); }, { passive: false });
    this.canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, () => this.release());
  }

  // The policies that fit the task: the submissions of the group, and its expert. Keeps the choice where it can.
  // `wanted` has the name of a submission, a run and a stage, or nothing.
  offer(task, group, wanted) {
    const rows = group.submissions.map(({ name, title }) => [name, title]);
    if (task.expert) rows.push([EXPERT, task.provisional ? "Expert (provisional)" : "Expert of the task"]);
    if (this.at || !rows.length) rows.push(["", this.at ? "no second body" : "none is published"]);
    const chosen = [wanted.submission, this.task && this.menu.value, this.panel.index.reference, rows[0][0]];
    fill(this.menu, rows);
    this.menu.value = chosen.find((name) => rows.some(([value]) => value === name)); // the first that there is
    Object.assign(this, { task, group });
    return this.choose(wanted.run, wanted.stage);
  }

  // Offers the runs of the chosen submission.
  choose(run = this.runs.value, stage) {
    const submission = this.group.submissions.find(({ name }) => name === this.menu.value), runs = submission?.runs || [];
    fill(this.runs, submission ? runs.map(([number]) => [number, number]) : [["", "–"]]);
    if (runs.some(([number]) => String(number) === run)) this.runs.value = run;
    this.runs.disabled = runs.length < 2;
    return this.load(stage);
  }

  // The chosen run: its number, the file of its policies below the root of the site, and its logged mean returns by stage
  // and task. The mean return of the expert is what 1 is.
  get chosen() {
    if (this.menu.value === EXPERT) return ["", this.task.expert, [this.group.tasks.map(() => this.task.one)]];
    const submission = this.group.submissions.find(({ name }) => name === this.menu.value);
    return submission?.runs.find(([number]) => String(number) === this.runs.value) || ["", "", []];
  }

  // The logged mean return of the policy on the task.
  get logged() {
    return this.chosen[2][this.stages.value]?.[this.panel.place];
  }

  get title() {
    return this.menu.selectedOptions[0]?.text + (this.runs.value && `, run ${this.runs.value}`);
  }

  // Without a stage, the first side is right after the training on the task, and the second one at the end.
  async load(stage) {
    const { chosen: [, file], title } = this;
    this.policies = null;
    this.problem = "";
    if (file) {
      try {
        const reply = await fetch(new URL(file, this.panel.site));
        if (!reply.ok) throw new Error("The policies could not be loaded.");
        const policies = await readPolicies(await reply.arrayBuffer());
        if (file !== this.chosen[1]) return;
        this.policies = policies;
      } catch (error) {
        this.problem = `${title}: ${error.message}`;
      }
    }
    const names = (this.policies || []).map((_, i) => [i, i ? `${i}: after ${this.group.tasks[i - 1]}` : "0: before training"]);
    fill(this.stages, names.length > 1 ? names : [[0, names.length ? "trained" : "–"]]);
    this.stages.disabled = names.length < 2;
    const last = Math.max(names.length - 1, 0), own = this.at ? last : Math.min(this.panel.place + 1, last);
    this.stages.value = names.some(([i]) => String(i) === stage) ? stage : own;
  }

  // The file of the policies, and the line of Python that makes an ONNX network of the one that runs.
  offerFile() {
    const { chosen: [run, file], panel, stages, menu } = this, name = panel.group.id.replace(/-v0$/, "");
    const source = menu.value === EXPERT ? `from gym_extensions.references import experts; experts.load("${by("task").value}")`
      : `from gym_extensions import policies; policies.load("submissions/${menu.value}", "${name}", run=${run}, stage=${stages.value})`;
    const [link, code] = this.take.querySelectorAll("a, code:last-child");
    link.href = new URL(file, panel.site);
    code.textContent = `${source}.to_onnx("policy.onnx"${this.policy.knowsTask ? `, task=${panel.place}` : ""})`;
  }

  get policy() {
    return this.policies?.[this.stages.value];
  }

  get running() {
    return this.policy && this.world && !this.world.ended;
  }

  place(mujoco, body, model, settings) {
    if (this.world?.body !== body) {
      for (const part of ["data", "model"]) this.world?.[part].delete(); // WebAssembly frees no memory by itself
      this.world = new World(mujoco, body, model);
    }
    this.world.change(settings);
  }

  reset(start) {
    this.owed = 0;
    this.top = BOX[3];
    this.world.reset(start);
    this.canvas.hidden = this.take.hidden = !this.policy;
    if (this.policy) this.offerFile();
  }

  step(task) {
    this.world.step(this.policy.act(this.world.observe(this.policy.inputs), task, normal(1)));
    if (this.world.ended && !this.panel.touched) this.past.push([this.world.total, this.world.fell]);
    if (this.released && this.world.data.time > this.released) {
      this.released = 0;
      this.world.grasp(null);
    }
  }

  push(direction) {
    const { data, torso } = this.world, at = [...data.xipos.subarray(3 * torso, 3 * torso + 3)];
    this.world.grasp({ body: torso, target: [at[0] + direction * PUSH_REACH, at[1], at[2]] });
    this.released = data.time + PUSH;
  }

  draw() {
    const { world, caption, policy } = this;
    if (!policy) {
      caption.textContent = this.problem;
      return;
    }
    const shapes = world.shapes(), seconds = world.steps * world.dt, { qpos } = world.data;
    if (world.body.is_planar) this.drawPlane(shapes, qpos);
    else drawSpace(this.view = figure.view(this.canvas, BOX, 0), shapes, [qpos[0], qpos[1]]);
    this.drawReturns();
    const waits = this.panel.sides.some((side) => side.running) ? " “Start again” restarts both." : "";
    const end = !world.ended ? "" : `${world.fell ? " It fell." : " End of the episode."}${waits}`;
    const falls = this.past.filter(([, fell]) => fell).length;
    const before = this.past.length ? ` Fell in ${falls} of ${this.past.length} finished.` : "";
    caption.textContent = `Return ${page.fixed(world.total, 1)}, step ${world.steps} (${seconds.toFixed(1)} s), ${page.fixed(qpos[0], 1)} m.${end}${before}`;
  }

  // The return on a scale with floor, expert and what was logged for this policy; a dot per finished episode, hollow after a fall.
  drawReturns() {
    const { world, task, past, view: { pen, colour, width }, logged, panel } = this, y = 34, far = width - 16;
    const marks = [["floor", task.floor, y - 12], ["expert", task.one, y - 12]];
    if (panel.isTask && this.menu.value !== EXPERT) marks.push(["logged mean", logged, y + 22]);
    const known = marks.filter(([, value]) => Number.isFinite(value));
    const values = [world.total, ...known.map(([, value]) => value), ...past.map(([value]) => value)];
    const low = Math.min(...values), reach = Math.max(...values) - low || 1, X = (value) => 16 + (far - 16) * (value - low) / reach;
    const line = (x1, y1, x2, y2) => {
      pen.beginPath();
      pen.moveTo(x1, y1);
      pen.lineTo(x2, y2);
      pen.stroke();
    };
    pen.lineWidth = 1;
    pen.strokeStyle = pen.fillStyle = colour("--soft");
    line(16, y, far, y);
    for (const [name, value, at] of known) {
      const text = `${name} ${page.fixed(value, 0)}`, half = pen.measureText(text).width / 2;
      line(X(value), y - 7, X(value), y + 7);
      pen.fillText(text, Math.min(Math.max(X(value) - half, 0), width - 2 * half), at);
    }
    pen.strokeStyle = pen.fillStyle = colour("--accent");
    for (const [value, fell] of past) {
      pen.beginPath();
      pen.arc(X(value), y, 3.5, 0, 7);
      pen[fell ? "stroke" : "fill"]();
    }
    pen.lineWidth = 3;
    line(X(world.total), y - 9, X(world.total), y + 9);
  }

  drawPlane(shapes, qpos) {
    const { world, policy } = this;
    const flat = shapes.map(([role, radius, a, b]) => (role === "wall"
      ? [role, 0, a[0] - b[0], a[2] - b[2], a[0] + b[0], a[2] + b[2]] : [role, radius, a[0], a[2], b[0], b[2]]));
    this.top = Math.max(this.top, ...flat.filter(([role]) => role !== "wall").map((shape) => Math.max(shape[3], shape[5]) + 0.2));
    this.view = figure.view(this.canvas, [BOX[0], BOX[1], BOX[2], this.top], qpos[0]);
    if (world.settings.wall !== null && policy.inputs > world.observe().length) {
      const [origin, directions] = beams(world.body.beams, qpos, world.lift);
      flat.push(...directions.map((d) => ["beam", 0, origin[0], origin[2], origin[0] + 10 * d[0], origin[2] + 10 * d[2]]));
    }
    figure.floor(this.view);
    figure.shapes(this.view, flat);
  }

  // Pixel positions of the ends of a shape, and the point of the world under a pixel at the depth of that shape.
  projection() {
    if (!this.world.body.is_planar) return camera(this.canvas, this.world.data.qpos);
    const { X, Y, scale, shift, width, height } = this.view;
    return {
      zoom: scale,
      project: ([x, , z]) => [X(x), Y(z), 1],
      unproject: (px, py) => [(px - width / 2) / scale + shift, 0, (height - py) / scale + BOX[1]],
    };
  }

  grasp(event) {
    this.grip = null;
    if (!this.running) return;
    const { project, zoom } = this.projection(), pixel = [event.offsetX, event.offsetY];
    let best = [NEAR, null];
    for (const [role, , start, end, body] of this.world.shapes()) {
      if (role === "wall") continue;
      const a = project(start), b = project(end), along = [b[0] - a[0], b[1] - a[1]];
      const length = along[0] ** 2 + along[1] ** 2 || 1;
      const share = Math.min(Math.max(((pixel[0] - a[0]) * along[0] + (pixel[1] - a[1]) * along[1]) / length, 0), 1);
      const distance = Math.hypot(a[0] + share * along[0] - pixel[0], a[1] + share * along[1] - pixel[1]) * a[2] / zoom;
      if (distance < best[0]) best = [distance, { body, depth: a[2] }];
    }
    this.grip = best[1];
    if (!this.grip) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.released = 0;
    this.world.grasp({ body: this.grip.body, target: this.projection().unproject(...pixel, this.grip.depth) });
    this.panel.touched = true;
  }

  release() {
    this.grip = null;
    this.world?.grasp(null);
  }

  drag(event) {
    if (!this.grip || !this.world.hand) return;
    this.world.grasp({ body: this.grip.body, target: this.projection().unproject(event.offsetX, event.offsetY, this.grip.depth) });
  }
}

class Panel {
  constructor(mujoco, index, site) {
    Object.assign(this, { mujoco, index, site, models: {}, running: true, touched: false, work: [0, 0] });
    this.sides = [...document.querySelectorAll(".sides figure")].map((figure, at) => new Side(figure, this, at));
    // The methods of the core come first, as on its board.
    const place = ({ name }) => index.core.indexOf(name) + 1 || index.core.length + 1;
    for (const group of index.groups) {
      group.submissions = Object.entries(group.submissions).map(([name, submission]) => ({ name, ...submission }))
        .sort((a, b) => place(a) - place(b));
    }
    fill(by("group"), index.groups.map(({ id }) => [id, id]));
    figure.speeds(by("speed"));
  }

  get group() {
    return this.index.groups.find(({ id }) => id === by("group").value);
  }

  get task() {
    return this.index.tasks[by("task").value];
  }

  // The position of the task in its group.
  get place() {
    return this.group.tasks.indexOf(by("task").value);
  }

  get settings() {
    const factor = Number(by("factor").value);
    return {
      gravity: Number(by("gravity").value),
      limbs: factor === 1 ? {} : { [by("part").value]: factor },
      wall: by("has-wall").checked ? Number(by("wall").value) : null,
    };
  }

  async start() {
    by("group").addEventListener("change", () => this.chooseGroup());
    by("task").addEventListener("change", () => this.chooseTask());
    by("has-wall").addEventListener("input", () => this.putWall());
    by("wall").addEventListener("input", () => { this.wallIsDrawn = false; });
    for (const name of ["gravity", "factor", "part", "wall", "has-wall"]) by(name).addEventListener("input", () => this.change());
    by("run").addEventListener("click", () => this.run(!this.running));
    by("again").addEventListener("click", () => this.restart());
    by("back").addEventListener("click", () => this.push(-1));
    by("forward").addEventListener("click", () => this.push(1));
    by("panel").addEventListener("change", () => this.write());
    by("panel").hidden = false;
    addEventListener("hashchange", () => { if (location.hash.startsWith("#?")) this.visit(); });
    await this.visit();
    figure.clock((elapsed) => this.frame(Math.min(elapsed, LONGEST_FRAME)))(true);
  }

  // The task of a body of a plane whose logged return falls most under the reference agent, as a share of its scale.
  get forgotten() {
    const rows = this.index.groups.flatMap(({ id, tasks, submissions }) => tasks.map((task, at) => {
      const [, , logged] = submissions.find(({ name }) => name === this.index.reference)?.runs[0] || [];
      const { floor, one, body } = this.index.tasks[task], isShown = logged && one && this.index.bodies[body].is_planar;
      return { group: id, task, lost: isShown ? (logged[at + 1][at] - logged.at(-1)[at]) / (one - floor) : 0 };
    }));
    return rows.reduce((most, each) => (each.lost > most.lost ? each : most));
  }

  // Chooses what the address names, and says what is not here.
  async visit() {
    const named = Object.fromEntries(new URLSearchParams(location.hash.slice(2))), groups = this.index.groups;
    const wanted = named.group || named.task ? named : { ...this.forgotten, ...named };
    const group = groups.find(({ id }) => id === wanted.group) || groups.find(({ tasks }) => tasks.includes(wanted.task)) || groups[0];
    by("group").value = group.id;
    await this.chooseGroup(wanted);
    if (this.wanted !== wanted) return;
    const lost = Object.entries(this.choices).filter(([name, value]) => wanted[name] && wanted[name] !== value && Number(wanted[name]) !== Number(value))
      .map(([name]) => `${name} ${wanted[name]}`);
    if (lost.length) this.missing = `This page has no ${lost.join(", ")}; shown is another. `;
  }

  // Every choice by its name in the address.
  get choices() {
    const sides = this.sides.map(({ menu, runs, stages }, at) => [["submission", menu.value || NOBODY], ["run", runs.value], ["stage", stages.value]]
      .map(([name, value]) => [`${name}${at ? "2" : ""}`, value]));
    const named = (names) => names.map((name) => [name, by(name).value]);
    return Object.fromEntries([...named(["group", "task"]), ...sides.flat(), ...named(["gravity", "part", "factor"]), ["wall", `${this.settings.wall ?? "none"}`], ...named(["speed"])]);
  }

  // Puts every choice into the address, as far as it differs from what the task says.
  write() {
    const { task, settings } = this, isWhole = JSON.stringify(settings.limbs) === JSON.stringify(task.limbs);
    const same = { gravity: settings.gravity === task.gravity, part: isWhole, factor: isWhole,
      wall: settings.wall === null ? !task.wall : this.wallIsDrawn, speed: by("speed").value === "1" };
    const given = Object.entries(this.choices).filter(([name, value]) => value && !same[name]);
    history.replaceState(null, "", `#?${new URLSearchParams(given)}`);
  }

  // `wanted` is what the address asks for: a task; a submission, its run and stage, and the same of the second body, without
  // which it is the same run at the end; what of the world differs from the task.
  chooseGroup(wanted = {}) {
    fill(by("task"), this.group.tasks.map((name) => [name, name]));
    if (this.group.tasks.includes(wanted.task)) by("task").value = wanted.task;
    return this.chooseTask(wanted);
  }

  async chooseTask(wanted = {}) {
    this.wanted = wanted; // the last choice, which may come while files of another one are loaded
    this.missing = "";
    const task = this.task, body = this.index.bodies[task.body], [[part, factor] = [Object.keys(body.parts)[0], 1]] = Object.entries(task.limbs);
    fill(by("part"), Object.keys(body.parts).map((name) => [name, name]));
    by("part").value = wanted.part in body.parts ? wanted.part : part;
    by("factor").value = numbered(wanted.factor, factor);
    by("gravity").value = numbered(wanted.gravity, task.gravity);
    by("has-wall").checked = wanted.wall ? wanted.wall !== "none" : task.wall;
    this.wallIsDrawn = !numbered(wanted.wall, 0);
    by("wall").max = Math.max(10, Math.ceil(numbered(wanted.wall, 0)));
    by("wall").value = numbered(wanted.wall, by("wall").value);
    if (wanted.speed) by("speed").value = [...by("speed").options].some(({ value }) => value === wanted.speed) ? wanted.speed : "1";
    this.work = [0, 0];
    this.ready = false; // policies and bodies of two tasks do not fit each other
    const other = wanted.submission2 === NOBODY ? "" : wanted.submission2 ?? wanted.submission;
    const second = { submission: other, run: wanted.run2 ?? wanted.run, stage: wanted.stage2 };
    const offered = Promise.all(this.sides.map((side, i) => side.offer(task, this.group, i ? second : wanted)));
    try {
      const reply = this.models[body.name] ? null : await fetch(new URL(body.model, this.site));
      if (reply && !reply.ok) throw new Error("no model");
      if (reply) this.models[body.name] = this.mujoco.parseXMLString(await reply.text());
    } catch {
      by("status").textContent = `${task.body} could not be loaded. Choose a task to try again.`;
      return;
    }
    await offered;
    if (this.wanted !== wanted) return;
    for (const side of this.sides) side.place(this.mujoco, body, this.models[body.name], this.settings);
    this.ready = true;
    this.restart();
  }

  change() {
    if (!this.ready) return;
    const world = JSON.stringify([by("task").value, { ...this.settings, wall: this.wallIsDrawn || this.settings.wall }]);
    for (const side of this.sides) {
      side.world.change(this.settings);
      if (side.policy !== side.before || world !== this.world) side.past = []; // episodes of another policy or world
      side.before = side.policy;
    }
    this.touched ||= world !== this.world; // until both start again
    this.world = world;
    this.describe();
  }

  // A wall that is ticked by hand stands in front of the first body, and stays there when both start again.
  putWall() {
    const wall = by("wall"), [near] = this.index.bodies[this.task.body].wall.range;
    const at = this.ready ? Math.max(...this.sides.map(({ world }) => world.data.qpos[0])) : 0;
    wall.max = Math.max(10, Math.ceil(at + near));
    wall.value = Math.max(at, 0) + near;
    this.wallIsDrawn = false;
  }

  describe() {
    const { settings, task } = this, text = (id, value) => { by(id).nextElementSibling.value = value; };
    text("gravity", `${settings.gravity.toFixed(2)} g`);
    text("factor", `× ${Number(by("factor").value).toFixed(2)}`);
    text("wall", `${Number(by("wall").value).toFixed(1)} m`);
    by("wall").disabled = !by("has-wall").checked;
    const [near, far] = this.index.bodies[task.body].wall.range;
    this.isTask = settings.gravity === task.gravity && (settings.wall !== null) === task.wall
      && (!task.wall || (settings.wall >= near && settings.wall <= far)) && JSON.stringify(settings.limbs) === JSON.stringify(task.limbs);
  }

  // Both sides start from one state. A wall that nobody has moved is drawn again, as the task does.
  restart() {
    if (!this.ready) return;
    const [near, far] = this.index.bodies[this.task.body].wall.range;
    if (this.wallIsDrawn) by("wall").value = near + Math.random() * (far - near);
    this.change();
    const [first] = this.sides, start = first.world.drawStart();
    for (const side of this.sides) side.reset(start);
    this.touched = false;
    this.over = 0;
    this.write();
    this.show();
  }

  push(direction) {
    for (const side of this.sides.filter(({ running }) => running)) {
      side.push(direction);
      this.touched = true;
    }
  }

  run(on) {
    this.running = on;
    by("run").textContent = on ? "Pause" : "Play";
  }

  frame(elapsed) {
    if (!this.ready) return;
    if (this.running) this.advance(elapsed);
    this.show();
  }

  advance(elapsed) {
    const { place } = this, active = this.sides.filter((side) => side.running);
    for (const side of active) {
      side.owed += elapsed * by("speed").value;
      const begin = performance.now();
      let steps = 0;
      for (; side.owed >= side.world.dt && side.running; steps++) {
        if (performance.now() - begin > MOST_WORK) side.owed = 0;
        side.step(place);
        side.owed -= side.world.dt;
      }
      this.work[0] += steps * side.world.dt;
      this.work[1] += (performance.now() - begin) / 1000;
    }
    this.over = active.length ? 0 : this.over + elapsed;
    if (this.over > PAUSE && !figure.calm.matches) this.restart();
  }

  show() {
    for (const side of this.sides) {
      side.draw();
      side.canvas.setAttribute("aria-label", `${this.task.body} under ${side.title}, stage ${side.stages.selectedOptions[0]?.text}`);
    }
    const [simulated, spent] = this.work, ratio = spent > 0 ? simulated / spent : 0;
    const world = !this.isTask ? "This world is no task of the benchmark."
      : this.touched ? "The body was pushed or the world changed: this return is not one of the task." : `This is ${by("task").value}.`;
    by("status").textContent = `${this.missing}${world}${ratio ? ` One body simulates ${ratio.toFixed(ratio < 10 ? 1 : 0)}\u00a0× as fast as real time.` : ""}`;
    by("status").dataset.ratio = ratio;
  }
}

export const startPanel = (mujoco, index, site) => new Panel(mujoco, index, site).start();
