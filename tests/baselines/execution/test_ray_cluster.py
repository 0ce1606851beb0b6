"""Ray: a local cluster of two nodes, one of which is killed, and clusters that cannot be reached."""

from __future__ import annotations

import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.baselines import TaskEvaluated, train
from gym_extensions.baselines.training.events import Event
from gym_extensions.errors import BenchError

from ..conftest import SHORT_GROUP, digests

LOOPBACK = "127.0.0.1"
NODE = {"node_ip_address": LOOPBACK, "object_store_memory": 100_000_000}


@pytest.fixture
def cluster(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
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
def test_a_cluster_whose_node_is_killed_writes_the_same_files(cluster: Any, tmp_path: Path) -> None:
    nodes = [cluster.add_node(num_cpus=1, **NODE) for _ in range(2)]
    killed: list[str] = []

    def kill_the_first_node(event: Event) -> None:
        if isinstance(event, TaskEvaluated) and not killed:
            killed.append(event.job)
            cluster.remove_node(nodes[0], allow_graceful=False)

    arguments = ("trpo", SHORT_GROUP, "sequential", "smoke", [0, 1])
    train(*arguments, out=tmp_path / "ray", ray=cluster.address, callback=kill_the_first_node)
    train(*arguments, out=tmp_path / "local", jobs=1)
    assert killed
    assert digests(tmp_path / "ray") == digests(tmp_path / "local")


@pytest.mark.slow
def test_a_job_that_fits_on_no_node_is_an_error(cluster: Any, tmp_path: Path) -> None:
    cluster.add_node(num_cpus=2, **NODE)
    arguments: dict[str, Any] = {"out": tmp_path / "mine", "ray": cluster.address}
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
