// A body in a world that can be changed while it runs: gravity, limbs, a wall, and a hand that pulls.
import { RULES, beams, readings } from "./rules.js";

const PARKED = -100;
const PULL = 25, STRONGEST = 12; // of a hand, per kg: N/m, and N

export class World {
  // `mujoco` is the module, `body` the facts of index.json, `base` its model, parsed.
  constructor(mujoco, body, base) {
    Object.assign(this, { mujoco, body, base, rules: RULES[body.name](body) });
    this.settings = { gravity: 1, limbs: {}, wall: null };
    this.build();
  }

  // Changes the world; the body keeps its state. `limbs` are factors of parts, `wall` is x of its center or null.
  change(settings) {
    const before = JSON.stringify(this.settings.limbs);
    this.settings = { ...this.settings, ...settings };
    if (JSON.stringify(this.settings.limbs) !== before) this.build();
    this.model.opt.gravity.set([0, 0, Number((this.gravity * this.settings.gravity).toPrecision(15))]);
    this.placeWall();
  }

  // Compiles the model as gym_extensions.catalog.variations changes it, with a wall that may be out of reach.
  // MuJoCo frees the memory of a copy; that of a parsed model it keeps.
  build() {
    const { mujoco } = this, spec = new mujoco.MjSpec(this.base);
    const geom = (name) => mujoco.mjs_asGeom(mujoco.mjs_findElement(spec, mujoco.mjtObj.mjOBJ_GEOM, name));
    const kilograms = (geoms) => geoms.reduce((sum, each) => sum + mass(each), 0);
    // HalfCheetah's compiler scales all masses to a total, which rises so that no other mass moves.
    const scale = spec.compiler.settotalmass / kilograms(Object.values(this.body.parts).flat().map(geom));
    for (const [part, factor] of Object.entries(this.settings.limbs)) {
      const geoms = this.body.parts[part].map(geom), before = geoms.map(mass);
      if (scale > 0) spec.compiler.settotalmass += (factor - 1) * kilograms(geoms) * scale;
      geoms.forEach((each, i) => {
        each.size[0] *= factor;
        each.mass = factor * before[i];
      });
    }
    const feet = this.body.feet;
    if (feet && feet.names.reduce((sum, name) => sum + geom(name).size[0], 0) > feet.distance) {
      const exclude = mujoco.mjs_addExclude(spec);
      [exclude.bodyname1, exclude.bodyname2] = feet.names;
    }
    this.addWall(spec);
    const model = mujoco.mj_compile(spec), data = new mujoco.MjData(model), old = this.data;
    spec.delete();
    if (old) {
      data.qpos.set(old.qpos);
      data.qvel.set(old.qvel);
      data.time = old.time;
      old.delete();
      this.model.delete();
    }
    Object.assign(this, { model, data });
    const torso = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, "torso"), joint = model.body_jntadr[torso];
    this.lift = model.jnt_type[joint] === 0 ? 0 : model.body_pos[3 * torso + 2] - model.qpos0[joint + 1];
    this.torso = torso;
    this.gravity = model.opt.gravity[2];
    this.dt = model.opt.timestep * this.body.frame_skip;
    this.kilograms = model.body_mass.reduce((sum, kg) => sum + kg, 0);
    this.names = Array.from({ length: model.ngeom }, (_, id) => mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM.value, id));
    this.placeWall();
    mujoco.mj_forward(model, data);
  }

  addWall(spec) {
    const { mujoco } = this, defaults = mujoco.mjs_getSpecDefault(spec);
    const wall = mujoco.mjs_addBody(mujoco.mjs_findBody(spec, "world"), defaults);
    mujoco.mjs_setName(wall.element, "wall");
    wall.mocap = true;
    const box = mujoco.mjs_addGeom(wall, defaults);
    mujoco.mjs_setName(box.element, "wall");
    box.size.set(this.body.wall.half);
    Object.assign(box, { type: mujoco.mjtGeom.mjGEOM_BOX, mass: 0, contype: 1, conaffinity: 1, condim: 1, priority: 1, material: "" });
  }

  placeWall() {
    const x = this.settings.wall;
    this.data.mocap_pos.set(x === null ? [0, 0, PARKED] : [x, 0, this.body.wall.height]);
  }

  // Starts an episode: at rest, with noise of the task, or in the state {qpos, qvel}.
  reset(start = null) {
    const { mujoco, model, data } = this;
    mujoco.mj_resetData(model, data);
    if (start) {
      data.qpos.set(start.qpos);
      data.qvel.set(start.qvel);
    }
    this.placeWall();
    mujoco.mj_forward(model, data);
    Object.assign(this, { steps: 0, total: 0, ended: false, hand: null });
  }

  // A random start, as the task draws it.
  drawStart() {
    const { qpos, qvel } = this.rules.noise;
    return { qpos: this.model.qpos0.map((value) => value + qpos()), qvel: new Float64Array(this.model.nv).map(qvel) };
  }

  // The observation of a policy with this many inputs; with ten more than the body's, the range beams follow.
  observe(inputs = null) {
    const values = this.rules.observe(this.data, this.model);
    if (inputs === values.length + 10) {
      const fan = beams(this.body.beams, this.data.qpos, this.lift);
      values.push(...(this.settings.wall === null ? fan[1].map(() => 0) : readings(fan, [...this.data.mocap_pos], this.body.wall.half)));
    }
    return values;
  }

  // One environment step. Returns the reward; `ended` says whether the episode is over.
  step(action) {
    const { mujoco, model, data, rules } = this, range = model.actuator_ctrlrange;
    const clipped = Float32Array.from(action, (value, i) => Math.min(Math.max(value, range[2 * i]), range[2 * i + 1]));
    const before = rules.mark(data, model);
    data.ctrl.set(clipped);
    for (let i = 0; i < this.body.frame_skip; i++) {
      this.pull();
      mujoco.mj_step(model, data);
    }
    if (rules.usesContacts) mujoco.mj_rnePostConstraint(model, data);
    const [reward, fell] = rules.reward(data, clipped, { before, dt: this.dt, timestep: model.opt.timestep, model });
    this.steps += 1;
    this.total += reward;
    this.fell = fell;
    this.ended = fell || this.steps >= this.body.max_steps;
    return reward;
  }

  // The force of the hand {body, target}: a spring between the body's center of mass and a point, never too strong.
  pull() {
    const { data, hand, kilograms } = this;
    if (!hand) return;
    const at = 3 * hand.body, force = hand.target.map((value, i) => PULL * kilograms * (value - data.xipos[at + i]));
    const size = Math.hypot(...force), most = STRONGEST * kilograms;
    data.xfrc_applied.set(force.map((f) => (size > most ? f * most / size : f)), 6 * hand.body);
  }

  // Takes the hand {body, target} or lets go (null).
  grasp(hand) {
    if (this.hand) this.data.xfrc_applied.fill(0, 6 * this.hand.body, 6 * this.hand.body + 6);
    this.hand = hand;
  }

  // The shapes of the body and the wall: [role, radius, start, end] in m; of a wall, center and half sizes.
  shapes() {
    const { model, data } = this, changed = new Set(Object.keys(this.settings.limbs).flatMap((part) => this.body.parts[part]));
    const shapes = [];
    for (let id = 0; id < model.ngeom; id++) {
      const type = model.geom_type[id], name = this.names[id], at = [...data.geom_xpos.subarray(3 * id, 3 * id + 3)];
      if (name === "wall") {
        if (this.settings.wall !== null) shapes.push(["wall", 0, at, this.body.wall.half, -1]);
      } else if (type !== 0) {
        const half = type === 3 ? model.geom_size[3 * id + 1] : 0, axis = [2, 5, 8].map((i) => half * data.geom_xmat[9 * id + i]);
        const role = changed.has(name) ? "changed" : name.includes("left") ? "far" : "body";
        shapes.push([role, model.geom_size[3 * id], at.map((v, i) => v - axis[i]), at.map((v, i) => v + axis[i]), model.geom_bodyid[id]]);
      }
    }
    return shapes;
  }
}

// Mass of a geom before compilation, in kg, as gym_extensions.catalog.variations.mass.
function mass({ mass: kilograms, size, fromto, density, type }) {
  if (!Number.isNaN(kilograms)) return kilograms;
  let half = Number.isNaN(fromto[0]) ? size[1] : Math.hypot(...[0, 1, 2].map((i) => fromto[i + 3] - fromto[i])) / 2;
  if (type.value === 2) half = 0;
  return density * Math.PI * size[0] ** 2 * (2 * half + 4 / 3 * size[0]);
}

// Loads the simulator. Throws where a file is missing or is not the one that the site was built with.
export async function loadMujoco({ script, script_integrity, wasm, wasm_integrity }, base) {
  const address = new URL(script, base).href;
  await new Promise((done, failed) => {
    const element = Object.assign(document.createElement("script"), { type: "module", src: address, integrity: script_integrity });
    element.onload = done;
    element.onerror = () => failed(new Error("mujoco.js"));
    document.head.append(element);
  });
  const packed = await fetch(new URL(wasm, base), { integrity: wasm_integrity });
  if (!packed.ok) throw new Error(`${wasm}: ${packed.status}`);
  const bytes = await new Response(packed.body.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
  const { default: load } = await import(address);
  return load({ wasmBinary: bytes });
}
