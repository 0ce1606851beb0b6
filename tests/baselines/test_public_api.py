"""The public names of ``gym_extensions.baselines``."""

import subprocess
import sys
from pathlib import Path

from ..conftest import loaded


def test_a_missing_extra_is_named_with_the_command_that_installs_it() -> None:
    code = "import sys; sys.modules['torch'] = None; from gym_extensions.baselines import sb3"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    message = "sb3 needs torch. Install it with: pip install 'gym-extensions[sb3]'"
    assert done.stderr.splitlines()[-1] == f"ModuleNotFoundError: {message}"


def test_reference_agents_train_without_torch(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['torch'] = sys.modules['stable_baselines3'] = None;"
        "from gym_extensions.baselines import Agent, Card, Factory, Resumable, algorithms, train;"
        "others = ('ppo', 'sac', 'sac64');"
        "names = [name for name in algorithms.names() if name.partition('-')[0] not in others];"
        "[algorithms.factory(name) for name in names];"
        f"out = {str(tmp_path / 'mine')!r};"
        "train('trpo', 'pusher', 'joint', 'smoke', 0, out=out, progress=False);"
        "del sys.modules['torch'], sys.modules['stable_baselines3']"
    )
    assert loaded(code, "mujoco torch stable_baselines3") == ["mujoco"]
    assert (tmp_path / "mine/pusher/joint/run0.csv").exists()
