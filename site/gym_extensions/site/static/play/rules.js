// Observation, reward, end and start of each body, as in gym_extensions.envs.mujoco (planar, humanoid).
const sumOfSquares = (values) => values.reduce((total, x) => total + x * x, 0);
const within = (value, [low, high]) => value > (low ?? -Infinity) && value < (high ?? Infinity);
const uniform = (size) => () => size * (2 * Math.random() - 1);
export const normal = (size) => () => size * Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());

// Forward speed, a bonus while healthy, and a cost on the action. Velocities are clipped to the body's limit.
function planar({ noise, ctrl_cost: cost, health, velocity_limit: limit }, velocities = uniform) {
  const healthy = ({ qpos, qvel }) => !health || (
    within(qpos[1], health.height) && within(qpos[2], health.angle)
    && (!health.state || [...qpos.slice(2), ...qvel].every((x) => Math.abs(x) < health.state)));
  return {
    noise: { qpos: uniform(noise), qvel: velocities(noise) },
    mark: ({ qpos }) => qpos[0],
    observe: ({ qpos, qvel }) => [...qpos.slice(1),
      ...(limit ? qvel.map((v) => Math.min(Math.max(v, -limit), limit)) : qvel)],
    reward(data, action, { before, dt }) {
      const fit = healthy(data);
      return [(data.qpos[0] - before) / dt + (health && fit ? 1 : 0) - cost * sumOfSquares(action), !fit];
    },
  };
}

const slice = (values, from, to, width) => [...values.subarray(from * width, to * width)];

// x of the center of mass.
function center({ xipos }, { body_mass: mass }) {
  let moment = 0, total = 0;
  for (let body = 0; body < mass.length; body++) {
    moment += mass[body] * xipos[3 * body];
    total += mass[body];
  }
  return moment / total;
}

// `gain(height, speed, upright)` is the reward without the costs of control and contact.
function humanoid({ noise, ctrl_cost: cost, health }, gain, canFall = false) {
  return {
    noise: { qpos: uniform(noise), qvel: uniform(noise) },
    usesContacts: true,
    mark: center,
    observe(data, { nbody, nmocap }) {
      const agent = [1, nbody - nmocap];
      return [...data.qpos.subarray(2), ...data.qvel, ...slice(data.cinert, ...agent, 10), ...slice(data.cvel, ...agent, 6),
        ...data.qfrc_actuator.subarray(6), ...slice(data.cfrc_ext, ...agent, 6)];
    },
    reward(data, action, { before, dt, timestep, model }) {
      const height = data.qpos[2], upright = within(height, health.height);
      const forces = data.cfrc_ext.subarray(0, 6 * (model.nbody - model.nmocap));
      const costs = cost * sumOfSquares(data.ctrl) + Math.min(5e-7 * sumOfSquares(forces), 10);
      return [gain(height / timestep, (center(data, model) - before) / dt, upright) - costs, canFall && !upright];
    },
  };
}

// By the name of a body: from its facts in index.json to its rules.
export const RULES = {
  Hopper: planar,
  Walker2d: planar,
  HalfCheetah: (body) => planar(body, normal),
  Humanoid: (body) => humanoid(body, (lift, speed, upright) => 1.25 * speed + (upright ? 5 : 0), true),
  HumanoidStandup: (body) => humanoid(body, (lift) => lift + 1),
  HumanoidStandupAndRun: (body) => humanoid(body, (lift, speed, upright) => 1.25 * speed + lift + (upright ? 5 : 1)),
};

// The ten range beams, as in gym_extensions.envs.range_beams: distance to the wall / 10 m, or 0.
const BEAMS = Array.from({ length: 10 }, (_, beam) => (-45 + 10 * beam) * Math.PI / 180), REACH = 10;

function axes(frame, qpos) {
  if (frame === "world") return [[1, 0, 0], [0, 0, 1]];
  if (frame === "pitch") {
    const cos = Math.cos(qpos[2]), sin = Math.sin(qpos[2]);
    return [[cos, 0, -sin], [sin, 0, cos]];
  }
  const [w, x, y, z] = qpos.slice(3, 7), n = w * w + x * x + y * y + z * z;
  return [[w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)].map((v) => v / n),
    [2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z].map((v) => v / n)];
}

// Origin and directions of the beams of a body; `lift` is the height of the torso where the root's z is 0.
export function beams(frame, qpos, lift) {
  const [forward, up] = axes(frame, qpos);
  const origin = frame === "pitch" ? [qpos[0], 0, lift + qpos[1]] : [qpos[0], qpos[1], lift + qpos[2]];
  return [origin, BEAMS.map((angle) => forward.map((value, i) => Math.cos(angle) * value + Math.sin(angle) * up[i]))];
}

// The reading of each beam for a box.
export function readings([origin, directions], box, half) {
  return directions.map((direction) => {
    let first = -Infinity, last = Infinity;
    for (let i = 0; i < 3; i++) {
      const offset = box[i] - origin[i];
      if (direction[i] === 0) {
        if (Math.abs(offset) > half[i]) return 0;
        continue;
      }
      const sides = [(offset - half[i]) / direction[i], (offset + half[i]) / direction[i]];
      first = Math.max(first, Math.min(...sides));
      last = Math.min(last, Math.max(...sides));
    }
    return first >= 0 && first <= last && first <= REACH ? first / REACH : 0;
  });
}
