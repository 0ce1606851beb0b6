"""The section of the documentation about the Python API."""

from __future__ import annotations

API = """## Python API

```python
from gym_extensions.envs import Gravity, customize, group, make, make_vec

env = make("HopperGravityHalf")  # the same as gymnasium.make("gym_extensions/HopperGravityHalf-v0")
env = make("Hopper", [Gravity(0.8)], max_steps=500)  # more variations, another time limit
task = customize("Hopper", [Gravity(0.8)])  # the same as data, for make, make_vec and groups
envs = make_vec([task, "Hopper"], num_envs=8, num_threads=2)  # environment i has task i modulo 2
tasks = group("hopper-gravity").tasks  # in training order
```

`make` returns a Gymnasium environment, and `make_vec` a vector environment whose numbers are bit for bit
those of the single environments. `save_state` and `restore_state` of an environment, and `save_states` and
`restore_states` of a vector environment, copy and restore simulation states.

`gymnasium.make_vec(id, num_envs)` returns the same vector environment as `make_vec`;
`vectorization_mode="sync"` and `"async"` return Gymnasium's own. An int seed gives environment i the seed
`seed + i`, and infos have the keys and values of the single environments, with Gymnasium's `_key` masks.

A published id has one reward, body and time limit. `gymnasium.make` accepts `render_mode`, and for MuJoCo
bodies `width`, `height`, `camera_id`, `camera_name`, `default_camera_config`, `max_geom` and
`visual_options`. Other keywords and another `max_episode_steps` are errors: use `make` or `customize`. The
`spec` of a custom task can be written with `to_json`, read with `EnvSpec.from_json` and given to
`gymnasium.make`.

`copy.deepcopy` and `pickle` of an environment or vector environment return one that continues exactly
where the original is, and so does `copy.copy` of one without wrappers. A step before the first reset
raises `gymnasium.error.ResetNeeded`, and any use of a closed vector environment
`gymnasium.error.ClosedEnvironmentError`.

### Videos

```python
import gymnasium as gym
import gym_extensions.envs

env = gym.make("gym_extensions/HopperGravityHalf-v0", render_mode="rgb_array")
env = gym.wrappers.RecordVideo(env, "videos", episode_trigger=lambda episode: episode % 10 == 0)
```

`RecordVideo` needs moviepy: `pip install 'gym-extensions[examples]'`. On a machine without a screen, set the
environment variable `MUJOCO_GL=egl` (a GPU, or Mesa) or `MUJOCO_GL=osmesa` (on the CPU, with the library
OSMesa) before Python starts. Navigation draws its own frames and needs neither.
"""
