"""Where no box can be started, one sentence says how to go on; what lies in it; limits of the protocol."""

import errno
import os
import platform
import shutil
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gym_extensions.baselines import algorithms, train
from gym_extensions.baselines.cli import main
from gym_extensions.baselines.isolated import box, confine, contents, frames
from gym_extensions.baselines.isolated.confine import ALLOW, FAIL, KILL, Limits, seccomp_program
from gym_extensions.baselines.isolated.proxy import IsolatedAgent
from gym_extensions.catalog.groups import group

from ...conftest import refused
from .conftest import Ordinary

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="boxes need Linux")
PACKAGES = """
import json
from gym_extensions.baselines.isolated import contents
print(json.dumps({name: str(path) for name, path in contents.packages().items()}))
"""
TRAIN = ["trpo", "--isolated", "--groups", "pusher", "--budget", "smoke", "--out"]


@pytest.fixture
def linux(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> pytest.MonkeyPatch:
    """An ordinary user of Linux on x86-64, with bubblewrap."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    for name in ("getuid", "geteuid"):
        monkeypatch.setattr(os, name, lambda: 1000, raising=False)
    monkeypatch.setattr(shutil, "which", lambda _: "/usr/bin/bwrap")
    return monkeypatch


class TestRefusals:
    def test_an_ordinary_user_with_bubblewrap_is_not_refused(self, linux: pytest.MonkeyPatch) -> None:
        box.require_possible()

    @pytest.mark.parametrize(
        ("change", "code", "advice"),
        [
            ((os, "getuid", lambda: 0), "box-as-root", "Run it as an ordinary user"),
            ((os, "geteuid", lambda: 0), "box-as-root", "Run it as an ordinary user"),
            ((shutil, "which", lambda _: None), "no-box", "sudo apt-get install bubblewrap"),
            ((sys, "platform", "darwin"), "no-box", "container"),
            ((sys, "platform", "win32"), "no-box", "container"),
            ((platform, "machine", lambda: "aarch64"), "no-box", "container"),
        ],
    )
    def test_root_another_system_or_no_bubblewrap_is_refused(
        self, linux: pytest.MonkeyPatch, change: Any, code: str, advice: str
    ) -> None:
        linux.setattr(*change)
        with refused(code, advice):
            box.require_possible()

    @LINUX
    def test_where_user_namespaces_are_forbidden(self, linux: pytest.MonkeyPatch, tmp_path: Path) -> None:
        fake = tmp_path / "bwrap"
        fake.write_text("#!/bin/sh\necho 'bwrap: setting up uid map: Permission denied' >&2\nexit 1\n")
        fake.chmod(0o755)
        linux.setenv("PATH", str(tmp_path), prepend=os.pathsep)
        facts = ("setting up uid map: Permission denied", "kernel.apparmor_restrict_unprivileged_userns=0")
        with refused("no-box", *facts, where="--isolated"):
            box.Box("agent", None, Limits())

    def test_the_command_says_it_before_it_trains(
        self, linux: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        linux.setattr(os, "getuid", lambda: 0, raising=False)
        assert main([*TRAIN, str(tmp_path / "mine")]) == 2
        assert "as root" in capsys.readouterr().err
        assert not (tmp_path / "mine").exists()


class TestHints:
    @pytest.mark.parametrize(
        ("raised", "advice"),
        [
            ("ModuleNotFoundError: No module named 'torch' (agent.py, line 2)", "'gym-extensions[sb3]'"),
            ("ModuleNotFoundError: No module named 'stable_baselines3.ppo'", "'gym-extensions[sb3]'"),
            ("ModuleNotFoundError: No module named 'onnxruntime'", "'gym-extensions[onnx]'"),
            ("ModuleNotFoundError: No module named 'numpy.missing'", "Correct it"),
            ("ModuleNotFoundError: No module named 'jax'", "no simulator"),
            ("ModuleNotFoundError: No module named 'gym_extensions.envs'", "no simulator"),
            ("ValueError: No module named 'torch'", "Correct it"),
        ],
    )
    def test_a_package_that_is_absent_or_not_installed_is_no_mistake_of_the_agents_code(
        self, raised: str, advice: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(box, "find_spec", lambda name: name == "numpy" or None)
        assert advice in box.hint_of(raised)


class TestNames:
    def test_an_agent_is_a_file_package_or_name(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        Path("deep").mkdir()
        for path in ("mine.py", "deep/other.py", "deep/__init__.py"):
            Path(path).write_text("raise SystemExit('the world imports no file of a stranger')")
        names = ("mine.py:make", "mine.py:Agent", "deep/other.py:make", "deep:make", "trpo")
        agents = [IsolatedAgent(name) for name in names]
        mine, deep = tmp_path / "mine.py", tmp_path / "deep"
        assert [agent.path for agent in agents] == [mine, mine, deep / "other.py", deep, None]
        assert [agent.__name__ for agent in agents] == ["mine", "Agent", "other", "deep", "trpo"]
        monkeypatch.chdir("deep")
        assert IsolatedAgent("__init__.py:make").path == deep

    @pytest.mark.parametrize("name", ["none.py:make", "none:make", "mine:make", "trop", ".:make"])
    def test_an_agent_that_does_not_exist_is_refused(
        self, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        with refused("unknown-agent"):
            IsolatedAgent(name)


class TestLimits:
    def test_an_agent_has_five_times_the_processor_time_of_trpo_and_a_minute(self) -> None:
        hopper, humanoid = group("hopper-gravity"), group("humanoid-gravity")
        assert Limits.of([(hopper, 1_500_000)]).cpu_seconds == 60 + 825
        assert Limits.of([(hopper, 1_500_000), (humanoid, 1_500_000)]).cpu_seconds == 60 + 3353
        assert Limits.of([(group("pusher"), 1000)]).cpu_seconds == 60 + 3

    def test_each_job_has_those_of_its_own_group_and_steps(
        self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        given = []

        def outside(factory: IsolatedAgent, *arguments: Any) -> Any:
            given.append(factory.limits)
            return algorithms.factory("zero")(*arguments)

        monkeypatch.setattr(IsolatedAgent, "__call__", outside)
        limits = Limits(cpu_seconds=100, memory=confine.MEBIBYTE)
        agent, protocols = IsolatedAgent("zero", limits), ["sequential", "single"]
        train(agent, "pusher", protocols, "smoke", 0, out=tmp_path / "mine", progress=False)
        assert [each.cpu_seconds for each in given] == [100, 100, 60 + 5, 60 + 3, 60 + 3]
        assert {each.memory for each in given} == {confine.MEBIBYTE}
        assert agent.for_job(group("nav-state"), 30_000).limits == limits

    def test_the_world_waits_four_times_as_long(self) -> None:
        assert Limits(cpu_seconds=100).longest_wait == 460


def verdict(number: int, *arguments: int, architecture: int = confine.X86_64) -> int:
    """What the filter answers to a system call: an interpreter of the instructions that it uses."""
    program, position, value = seccomp_program(), 0, 0
    data = struct.pack("<IIQ6Q", number, architecture, 0, *arguments, *[0] * (6 - len(arguments)))
    while True:
        code, if_true, if_false, k = program[position]
        position += 1
        if code == confine.RETURN:
            return k
        if code == confine.LOAD:
            (value,) = struct.unpack_from("<I", data, k)
            continue
        test = {confine.EQUAL: value == k, confine.AT_LEAST: value >= k, confine.BIT_SET: value & k}[code]
        position += if_true if test else if_false


class TestFilter:
    @pytest.mark.parametrize(
        ("answer", "number", "arguments"),
        [
            (ALLOW, 0, ()),  # read
            (ALLOW, 56, (0x3D0F00,)),  # a thread
            (FAIL | errno.EPERM, 56, (0x11,)),  # a process
            (FAIL | errno.EPERM, 56, (0x10000011,)),  # a user namespace
            (FAIL | errno.ENOSYS, 435, ()),  # clone3
            (FAIL | errno.EPERM, 59, ()),  # execve
            (FAIL | errno.EPERM, 173, ()),  # the last of the table
            (FAIL | errno.EPERM, 16, (0, 0x5412)),  # ioctl(TIOCSTI)
            (ALLOW, 16, (0, 0x5401)),
            (FAIL | errno.EPERM, 157, (4, 1)),  # prctl(PR_SET_DUMPABLE)
            (ALLOW, 157, (15,)),
            (ALLOW, 450, ()),
            (FAIL | errno.ENOSYS, 451, ()),
            (KILL, 0x40000000, ()),  # x32
        ],
    )
    def test_answers(self, answer: int, number: int, arguments: tuple[int, ...]) -> None:
        assert verdict(number, *arguments) == answer

    def test_other_architectures_are_killed(self) -> None:
        assert verdict(0, architecture=0x40000003) == KILL

    def test_the_table_names_every_call_once(self) -> None:
        words = " ".join(confine.REFUSED.values()).split()
        names, numbers = words[::2], words[1::2]
        assert len(set(names)) == len(names) == len(set(numbers))
        assert all(map(str.isdigit, numbers))


class TestContents:
    def test_the_box_has_no_simulator_no_experts_and_no_submissions(self) -> None:
        found = contents.packages()
        assert {"numpy", "gymnasium", "gym_extensions/baselines", "gym_extensions/errors.py"} <= found.keys()
        assert not [name for name in found if "mujoco" in name]
        own = {name.partition("/")[2] for name in found if name.startswith("gym_extensions/")}
        folders, files = {"baselines", "catalog", "submissions"}, "errors.py files.py versions.py policies.py"
        assert own == {*folders, *files.split()}

    def test_it_has_the_code_under_test(self, ordinary: Ordinary) -> None:
        assert ordinary.run(PACKAGES) == {name: str(path) for name, path in contents.packages().items()}


class TestFrames:
    def pipe(self, data: bytes) -> frames.Pipe:
        reader, writer = os.pipe()
        os.write(writer, data)
        os.close(writer)
        return frames.Pipe(reader, -1)

    def test_arrays_come_back_as_they_were(self) -> None:
        arrays = {
            "a": np.arange(6.0).reshape(2, 3),
            "b": np.array(1.5, np.float32),
            "c": np.zeros((0, 4), np.bool_),
            "d": np.frombuffer(b"text", np.uint8),
            "e": np.arange(4, dtype=">f8"),
        }
        shapes, blob = frames.packed(arrays)
        back = frames.unpacked(shapes, bytearray(blob))
        assert list(back) == list(arrays)
        for name, values in arrays.items():
            assert back[name].shape == values.shape
            np.testing.assert_array_equal(back[name], values)

    @pytest.mark.parametrize(
        "shapes",
        [
            *(None, 7, "text", [], [["a"]], [[["a"], "<f8", [1]]], [["a", "<f8", [1] * 9]]),
            *([["a", dtype, [1]]] for dtype in ("|O", "<U9", "<f4")),
            *([["a", "<f8", [size]]] for size in (2, -1, 0.5, True, 2**70)),
        ],
    )
    def test_arrays_that_do_not_fit_their_bytes_are_refused(self, shapes: Any) -> None:
        with pytest.raises(frames.ProtocolError):
            frames.unpacked(shapes, bytearray(8))

    @pytest.mark.parametrize(
        "data",
        [
            frames.LENGTHS.pack(2**17, 0),
            frames.LENGTHS.pack(2, 11) + b"[]",
            frames.LENGTHS.pack(3, 0) + b"[1,",
            frames.LENGTHS.pack(60_000, 0) + b"[" * 60_000,
            frames.LENGTHS.pack(2, 0) + b"\xff\xfe",
        ],
        ids=["long JSON", "too many bytes", "no JSON", "deep JSON", "no UTF-8"],
    )
    def test_what_no_frame_allows_is_refused(self, data: bytes) -> None:
        with pytest.raises(frames.ProtocolError):
            self.pipe(data).read_message(10)

    def test_a_closed_pipe_is_the_end(self) -> None:
        with pytest.raises(EOFError):
            self.pipe(b"x").read(2)
