"""Jobs whose files go to another machine and come back, and clusters of Ray, of which nodes are killed."""

from __future__ import annotations

import errno
import pickle
import socket
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import TaskEvaluated, train, train_agent
from gym_extensions.baselines.execution import ray_cluster as job_files
from gym_extensions.baselines.execution.ray_cluster import Files, Remote, RemoteJob
from gym_extensions.baselines.execution.workers import Failure, failure_of
from gym_extensions.baselines.training.events import Event, Listener
from gym_extensions.baselines.training.jobs import job_versions
from gym_extensions.errors import BenchError

from ..conftest import QUICK_GROUP, SHORT_GROUP, digests

NUM_ENVS = 10
"""More environments take less time."""


class NodeDiedError(RuntimeError):
    """A node ended while it ran a job."""


class Cluster(Remote):
    """A cluster in this process: every job is pickled, and the first node dies after one evaluated task."""

    def __init__(self) -> None:
        super().__init__(2)
        self.sent: list[int] = []
        self.has_died = False

    def submit(self, jobs: Sequence[RemoteJob], listen: Listener) -> Iterator[tuple[int, Files | Failure]]:
        def die(event: Event) -> None:
            listen(event)
            if isinstance(event, TaskEvaluated) and not self.has_died:
                self.has_died = True
                raise NodeDiedError

        for index, job in enumerate(jobs):
            self.sent.append(len(job.files))
            content = pickle.dumps(job)
            try:
                yield index, pickle.loads(content).run(die)  # noqa: S301
            except NodeDiedError:
                yield index, pickle.loads(content).run(listen)  # noqa: S301
            except BenchError as error:
                yield index, failure_of(error)


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """trpo, sequential and joint, trained in this process."""
    folder = tmp_path_factory.mktemp("local") / "trpo"
    train("trpo", QUICK_GROUP, ["sequential", "joint"], "smoke", 0, out=folder, num_envs=NUM_ENVS)
    return folder


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Cluster:
    """Replaces the executor that ``train(…, ray="fake")`` opens."""
    fake = Cluster()

    @contextmanager
    def open_executor(ray: str | None, processes: int) -> Iterator[Remote]:
        assert (ray, processes) == ("fake", 0)
        yield fake

    monkeypatch.setattr(train_agent, "_open_executor", open_executor)
    return fake


def test_a_job_whose_node_died_ends_with_the_same_bytes(
    cluster: Cluster, local: Path, tmp_path: Path
) -> None:
    out = tmp_path / "remote"
    train("trpo", QUICK_GROUP, "joint", "smoke", 0, out=out, num_envs=NUM_ENVS, ray="fake")
    assert cluster.has_died
    remote, expected = digests(out), digests(local)
    names = {name for name in expected if "joint" in name}
    assert {name for name in remote if "joint" in name} == names
    assert all(remote[name] == expected[name] for name in names)


def test_a_node_with_other_versions_refuses_the_job(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(job_files, "job_versions", lambda each: job_versions(each) | {"numpy": "1.0.0"})
    with pytest.raises(BenchError) as error:
        train("zero", QUICK_GROUP, ["single", "joint"], "smoke", 0, out=tmp_path / "mine", ray="fake")
    assert error.value.code == "jobs-failed"
    assert "has other packages than the machine that sends the jobs: numpy 1.0.0 (installed: " in str(
        error.value
    )
    assert "Install the same versions on every node." in str(error.value)
    assert not list((tmp_path / "mine").rglob("stage*"))


def test_finished_stages_travel_to_the_node_and_are_not_repeated(
    local: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    out = tmp_path / "remote"

    def stop(event: Event) -> None:
        if isinstance(event, TaskEvaluated) and event.stage == 2:
            raise KeyboardInterrupt

    arguments: Any = ("trpo", QUICK_GROUP, "sequential", "smoke", 0)
    with pytest.raises(KeyboardInterrupt):
        train(*arguments, out=out, num_envs=NUM_ENVS, callback=stop)
    cluster: Cluster = request.getfixturevalue("cluster")
    cluster.has_died = True
    stages: list[int] = []

    def record_stage(event: Event) -> None:
        if isinstance(event, TaskEvaluated):
            stages.append(event.stage)

    train(*arguments, out=out, num_envs=NUM_ENVS, ray="fake", callback=record_stage)
    assert set(stages) == {2}
    assert cluster.sent[0] == 6  # settings, two records, two policies, the agent
    assert (
        digests(out)[f"{QUICK_GROUP.name}/sequential/run0.json"]
        == digests(local)[f"{QUICK_GROUP.name}/sequential/run0.json"]
    )


def test_files_that_cannot_be_stored_are_a_failure_and_leave_no_part_of_a_job(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cluster.has_died = True
    write, out = Path.write_bytes, tmp_path / "mine"

    def fill_disk(path: Path, content: bytes) -> int:
        if path.name == "stage1.json" and out in path.parents:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", fill_disk)
    with pytest.raises(OSError, match="No space left on device"):
        train("zero", QUICK_GROUP, "joint", "smoke", 0, out=out, ray="fake")
    assert not list((out / ".progress").rglob("stage*"))


LOOPBACK = "127.0.0.1"
NODE = {"node_ip_address": LOOPBACK, "object_store_memory": 100_000_000}


@pytest.fixture
def real_cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A head without CPUs on the loopback interface."""
    pytest.importorskip("ray")
    from ray._private import services
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    # Ray replaces a loopback address by the machine's public one.
    monkeypatch.setattr(services, "get_node_ip_address", lambda *_, **__: LOOPBACK)
    local: Any = Cluster(
        initialize_head=True, head_node_args={**NODE, "num_cpus": 0, "include_dashboard": False}
    )
    yield local
    local.shutdown()


@pytest.mark.slow
def test_a_cluster_whose_node_is_killed_writes_the_same_files(real_cluster: Any, tmp_path: Path) -> None:
    nodes = [real_cluster.add_node(num_cpus=1, **NODE) for _ in range(2)]
    killed: list[str] = []

    def kill_the_first_node(event: Event) -> None:
        if isinstance(event, TaskEvaluated) and not killed:
            killed.append(event.job)
            real_cluster.remove_node(nodes[0], allow_graceful=False)

    arguments = ("trpo", SHORT_GROUP, "sequential", "smoke", [0, 1])
    train(*arguments, out=tmp_path / "ray", ray=real_cluster.address, callback=kill_the_first_node)
    train(*arguments, out=tmp_path / "local", jobs=1)
    assert killed
    assert digests(tmp_path / "ray") == digests(tmp_path / "local")


@pytest.mark.slow
def test_a_job_that_fits_on_no_node_is_an_error(real_cluster: Any, tmp_path: Path) -> None:
    real_cluster.add_node(num_cpus=2, **NODE)
    arguments: dict[str, Any] = {"out": tmp_path / "mine", "ray": real_cluster.address}
    with pytest.raises(BenchError) as error:
        train("zero", SHORT_GROUP, "joint", "smoke", 0, **arguments, num_threads=3)
    assert error.value.code == "bad-num-threads"
    train("zero", SHORT_GROUP, "joint", "smoke", 0, **arguments, num_threads=2)


def closed_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def test_a_cluster_that_cannot_be_reached_is_an_error_within_seconds(tmp_path: Path) -> None:
    pytest.importorskip("ray")
    address, start = f"{LOOPBACK}:{closed_port()}", time.monotonic()
    with pytest.raises(BenchError) as error:
        train("zero", SHORT_GROUP, "joint", "smoke", 0, out=tmp_path / "mine", ray=address)
    assert time.monotonic() - start < 20
    assert error.value.code == "ray-unreachable"


@pytest.mark.parametrize("address", ["somewhere", "host:", ":6379", "host:port"])
def test_an_address_without_a_port_is_rejected(address: str, tmp_path: Path) -> None:
    pytest.importorskip("ray")
    with pytest.raises(BenchError) as error:
        train("zero", SHORT_GROUP, "joint", "smoke", 0, out=tmp_path, ray=address)
    assert error.value.code == "bad-ray"


def test_a_missing_ray_is_named_with_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(BenchError) as error:
        train("zero", SHORT_GROUP, "joint", "smoke", 0, out=tmp_path, ray="auto")
    assert error.value.code == "missing-extra"
