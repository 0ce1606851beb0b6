// A published policy, evaluated as by gym_extensions.submissions.policies.mlp. The file has a header of JSON and its arrays.
const FUNCTIONS = {
  linear: (x) => x, tanh: Math.tanh, relu: (x) => Math.max(x, 0), leaky_relu: (x) => (x > 0 ? x : 0.01 * x),
  elu: (x) => (x > 0 ? x : Math.expm1(x)), silu: (x) => x / (1 + Math.exp(-x)),
};
const TYPES = { f4: Float32Array, f8: Float64Array, u1: Uint8Array };
const FORMAT = 1;

// The policies of a file, one per stage. Throws an Error with a sentence for the reader.
export function readPolicies(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  if (header.format !== FORMAT) throw new Error(`These policies have format ${header.format}, which this page cannot evaluate.`);
  return header.policies.map((facts) => {
    for (const name of [facts.activation, facts.output_activation, facts.squash]) {
      if (!FUNCTIONS[name]) throw new Error(`These policies use ${name}, which this page cannot evaluate.`);
    }
    const arrays = {};
    for (const [name, [type, shape, at]] of Object.entries(facts.arrays)) {
      const count = shape.reduce((product, n) => product * n, 1);
      arrays[name] = { shape, values: new TYPES[type](buffer, 4 + size + at, count) };
    }
    return new Policy(facts, arrays);
  });
}

export class Policy {
  constructor(facts, arrays) {
    Object.assign(this, facts);
    this.arrays = arrays;
    this.layers = Object.keys(arrays).filter((name) => name.startsWith("weight_")).length;
    this.inputs = this.layers ? arrays.weight_0.shape.at(-2) : null;
  }

  // The row of a task: of the leading axis, where an array has it.
  row(name, dimensions, task) {
    const array = this.arrays[name];
    if (!array || array.shape.length === dimensions) return array && array.values;
    const size = array.values.length / array.shape[0], at = Math.min(task, array.shape[0] - 1) * size;
    return array.values.subarray(at, at + size);
  }

  // h · weight + bias, each sum rounded to float32 as numpy stores it.
  product(input, weight, bias, mask) {
    return Float32Array.from(bias, (start, j) => {
      let total = 0;
      for (let i = 0; i < input.length; i++) {
        const at = i * bias.length + j;
        if (!mask || mask[at]) total += input[i] * weight[at];
      }
      return total + start;
    });
  }

  // The action for an observation; normal() draws the noise of a policy that samples, null takes its mean.
  act(observation, task = 0, normal = null) {
    const { activation, output_activation: last, squash, observation_clip: bound } = this;
    const mean = this.row("observation_mean", 1, task), scale = this.row("observation_scale", 1, task);
    let hidden = Float32Array.from(observation, (value, i) => {
      let x = this.observation_dtype === "float32" ? Math.fround(value) : value;
      if (mean) x = (x - mean[i]) / scale[i];
      return bound ? Math.min(Math.max(x, -bound), bound) : x;
    });
    const offset = this.arrays.action_offset.values, size = this.arrays.action_scale.values;
    let output = new Float32Array(offset.length), before = hidden;
    for (let layer = 0; layer < this.layers; layer++) {
      const part = (name, dimensions) => this.row(`${name}_${layer}`, dimensions, task);
      before = hidden;
      output = this.product(hidden, part("weight", 2), part("bias", 1), part("mask", 2));
      hidden = output.map(FUNCTIONS[layer < this.layers - 1 ? activation : last]);
      output = hidden;
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
    return Float32Array.from(log, (value) => Math.exp(Math.min(Math.max(value, low), high)));
  }
}
