// A published policy, with the bits of gym_extensions.submissions.policies.arithmetic (docs/rollout-log.md#arithmetic).
// Its file is the .npz file of a run (docs/policies.md).
const TERMS = [1], POWERS = Array.from({ length: 121 }, (_, at) => 2 ** (at - 60));
for (let n = 1; n <= 13; n++) TERMS.push(TERMS[n - 1] * n);

function exp(value) {
  const x = value < -40 ? -40 : value > 40 ? 40 : value;
  const k = Math.floor(x * 1.4426950408889634 + 0.5);
  const r = (x - k * 0.6931471803691238) - k * 1.9082149292705877e-10;
  let p = 1 / TERMS[13];
  for (let n = 12; n >= 0; n--) p = p * r + 1 / TERMS[n];
  return p * POWERS[k + 60];
}

function tanh(x) {
  const t = 1 - 2 / (exp(2 * Math.abs(x)) + 1);
  return x < 0 ? -t : t;
}

const FUNCTIONS = {
  linear: (x) => x, tanh, relu: (x) => (x < 0 ? 0 : x), leaky_relu: (x) => (x < 0 ? 0.01 * x : x),
  elu: (x) => (x < 0 ? exp(x) - 1 : x), silu: (x) => x * (0.5 * tanh(0.5 * x) + 0.5),
};
const TYPES = { "<f4": Float32Array, "<f8": Float64Array, "|u1": Uint8Array, "|b1": Uint8Array, "<i8": BigInt64Array };
const NAMES = ["activation", "output_activation", "squash", "head", "observation_dtype"];
const FORMAT = 1;
const latin = (bytes) => String.fromCharCode(...bytes);

const HEADER = /^\{'descr': '([^']*)', 'fortran_order': (True|False), 'shape': \(([^)]*)\), \}\s*$/;

// An array of numpy, {shape, values}, with the values in the order of C. Throws if numpy did not write its header.
function readArray(buffer) {
  const size = new DataView(buffer).getUint16(8, true);
  const [, type, isFortran, axes] = latin(new Uint8Array(buffer, 10, size)).match(HEADER);
  const shape = axes.split(",").filter((n) => n.trim()).map(Number), values = new TYPES[type](buffer, 10 + size);
  return { shape, values: isFortran === "True" ? inOrderOfC(values, shape) : values };
}

// Values in Fortran's order, in which the first index changes fastest.
function inOrderOfC(values, shape) {
  const strides = shape.map((_, axis) => shape.slice(0, axis).reduce((a, b) => a * b, 1));
  return values.map((_, at) => {
    let from = 0;
    for (let axis = shape.length - 1; axis >= 0; at = Math.floor(at / shape[axis]), axis--) from += (at % shape[axis]) * strides[axis];
    return values[from];
  });
}

// The arrays of an .npz file by name: a ZIP archive without a comment, whose directory is at its end.
async function readArrays(buffer) {
  const view = new DataView(buffer), short = (at) => view.getUint16(at, true), long = (at) => view.getUint32(at, true);
  const arrays = {}, end = buffer.byteLength - 22;
  for (let at = long(end + 16), left = short(end + 10); left; left--) {
    const name = latin(new Uint8Array(buffer, at + 46, short(at + 28))).replace(".npy", ""), start = long(at + 42);
    const packed = new Blob([new Uint8Array(buffer, start + 30 + short(start + 26) + short(start + 28), long(at + 20))]).stream();
    const unpacked = short(at + 10) ? packed.pipeThrough(new DecompressionStream("deflate-raw")) : packed;
    arrays[name] = readArray(await new Response(unpacked).arrayBuffer());
    at += 46 + short(at + 28) + short(at + 30) + short(at + 32);
  }
  return arrays;
}

// The policies of a file, one per stage. Throws an Error with a sentence for the reader.
export async function readPolicies(buffer) {
  const stages = {};
  for (const [path, array] of Object.entries(await readArrays(buffer))) {
    const [name, stage = ""] = path.split("/").reverse();
    (stages[stage] ||= {})[name] = array;
  }
  const order = (a, b) => a.localeCompare(b, "en", { numeric: true });
  return Object.keys(stages).sort(order).map((stage) => {
    const arrays = stages[stage], format = Number(arrays.format.values[0]);
    if (format !== FORMAT) throw new Error(`These policies have format ${format}, which this page cannot evaluate.`);
    const facts = Object.fromEntries(NAMES.map((name) => [name, latin(arrays[name].values)]));
    for (const name of [facts.activation, facts.output_activation, facts.squash]) {
      if (!FUNCTIONS[name]) throw new Error(`These policies use ${name}, which this page cannot evaluate.`);
    }
    return new Policy({ ...facts, observation_clip: arrays.observation_clip?.values[0] }, arrays);
  });
}

class Policy {
  constructor(facts, arrays) {
    Object.assign(this, facts);
    this.arrays = arrays;
    this.layers = Object.keys(arrays).filter((name) => name.startsWith("weight_")).length;
    this.inputs = this.layers ? arrays.weight_0.shape.at(-2) : null;
    this.knowsTask = Object.entries(arrays).some(([name, { shape }]) => shape.length > (/weight|mask/.test(name) ? 2 : 1));
  }

  // The row of a task: of the leading axis, where an array has it.
  row(name, dimensions, task) {
    const array = this.arrays[name];
    if (!array || array.shape.length === dimensions) return array && array.values;
    const size = array.values.length / array.shape[0], at = Math.min(task, array.shape[0] - 1) * size;
    return array.values.subarray(at, at + size);
  }

  // The bias plus h · weight, one input after another.
  product(input, weight, bias, mask) {
    const total = Float64Array.from(bias);
    for (let i = 0, at = 0; i < input.length; i++) {
      for (let j = 0; j < total.length; j++, at++) total[j] += input[i] * (mask && !mask[at] ? 0 : weight[at]);
    }
    return total;
  }

  // The action for an observation; normal() draws the noise of a policy that samples, null takes its mean.
  act(observation, task = 0, normal = null) {
    const { activation, output_activation: last, squash, observation_clip: bound } = this;
    const mean = this.row("observation_mean", 1, task), scale = this.row("observation_scale", 1, task);
    let hidden = Float64Array.from(observation, (value, i) => {
      let x = this.observation_dtype === "float32" ? Math.fround(value) : value;
      if (mean) x = (x - mean[i]) / scale[i];
      return bound && x < -bound ? -bound : bound && x > bound ? bound : x;
    });
    const offset = this.arrays.action_offset.values, size = this.arrays.action_scale.values;
    let output = new Float64Array(offset.length), before = hidden;
    for (let layer = 0; layer < this.layers; layer++) {
      const part = (name, dimensions) => this.row(`${name}_${layer}`, dimensions, task);
      before = hidden;
      hidden = this.product(hidden, part("weight", 2), part("bias", 1), part("mask", 2));
      output = hidden = hidden.map(FUNCTIONS[layer < this.layers - 1 ? activation : last]);
    }
    const sigma = normal && this.head === "gaussian" ? this.sigma(before, task) : null;
    return output.map((mean_, i) => {
      let y = sigma ? mean_ + sigma[i] * normal() : mean_;
      if (normal && this.head === "uniform") y = 2 * Math.random() - 1;
      return offset[i] + size[i] * FUNCTIONS[squash](y);
    });
  }

  // The standard deviation of a Gaussian policy.
  sigma(hidden, task) {
    const base = this.row("log_sigma", 1, task), weight = this.row("log_sigma_weight", 2, task);
    const [low, high] = this.arrays.log_sigma_clip?.values || [-Infinity, Infinity];
    const log = weight ? this.product(hidden, weight, base) : base;
    return Float64Array.from(log, (value) => Math.exp(Math.min(Math.max(value, low), high)));
  }
}
