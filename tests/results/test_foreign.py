"""Boards of other benchmarks from their own logs, in the forms that their public code writes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from gym_extensions import results
from gym_extensions.errors import BenchError

TASKS = ("reach-v1", "push-v1")


def continual_world(folder: Path, seed: int, final: float = 0.5, tasks: tuple[str, ...] = TASKS) -> Path:
    """A run on two tasks, two evaluations each: the first task is learned to 1 and falls to ``final``."""
    names = [f"test/stochastic/{index}/{name}/success" for index, name in enumerate(tasks)]
    rows = [(0, 0.5, 0.0), (0, 1.0, 0.0), (1, 0.75, 0.5), (1, final, 1.0)]
    run = folder / f"run{seed}"
    run.mkdir(parents=True)
    lines = ["\t".join([*names, "train/active_env"])]
    lines += ["\t".join([str(first), str(second), str(stage)]) for stage, first, second in rows]
    (run / "progress.tsv").write_text("\n".join(lines) + "\n")
    (run / "config.json").write_text(json.dumps({"cl_method": "ewc", "seed": seed}))
    return run


def alone(folder: Path, task: str, values: list[float]) -> None:
    """A run on one task."""
    run = folder / f"alone-{task}"
    run.mkdir()
    lines = [f"test/stochastic/0/{task}/success", *map(str, values)]
    (run / "progress.tsv").write_text("\n".join(lines) + "\n")
    (run / "config.json").write_text(json.dumps({"task": task}))


def test_runs_of_continual_world_are_imported_and_never_ranked(tmp_path: Path) -> None:
    continual_world(tmp_path, 0)
    continual_world(tmp_path, 1)
    alone(tmp_path, "reach-v1", [0.0, 1.0])
    alone(tmp_path, "push-v1", [0.0, 0.5])
    [runs] = results.foreign_runs(tmp_path, "continual-world")
    assert (runs.name, runs.tasks) == ("ewc", TASKS)
    # The last five evaluations of a stage are averaged, here both.
    assert runs.matrix.tolist() == [[[0.75, 0.0], [0.625, 0.75]]] * 2
    [row] = results.foreign_board(tmp_path, "continual-world").to_dict("records")
    assert (row["level"], row["ranked"], row["runs"]) == ("imported", False, 2)
    assert "not verified" in row["why"]
    assert row["final_performance"] == pytest.approx((0.625 + 0.75) / 2)
    assert row["forgetting"] == pytest.approx(0.125)
    assert row["forward_transfer_auc"] == pytest.approx(0.75 - 0.25)


def meal(folder: Path, seed: int, curves: list[list[float]], form: str = "json") -> None:
    """A run as the download script of MEAL writes it."""
    run = folder / "ippo" / "EWC" / f"seed_{seed}"
    run.mkdir(parents=True)
    for index, curve in enumerate(curves):
        if form == "json":
            (run / f"{index}_soup.json").write_text(json.dumps(curve))
        else:
            np.savez(run / f"{index}_soup.npz", data=np.array(curve, np.float32))
    (run / "training_soup.json").write_text("[0.0]")


@pytest.mark.parametrize("form", ["json", "npz"])
def test_curves_of_meal_are_cut_into_stages(tmp_path: Path, form: str) -> None:
    meal(tmp_path, 1, [[0.5, 1.0, 0.5, 0.25], [0.0, 0.0, 0.5, 1.0]], form)
    [runs] = results.foreign_runs(tmp_path, "meal")
    assert runs.name == "ippo/EWC"
    assert runs.matrix.tolist() == [[[1.0, 0.0], [0.25, 1.0]]]
    board = results.foreign_board(tmp_path, "meal")[["name", "level", "forgetting"]]
    assert board.values.tolist() == [["ippo/EWC", "imported", 0.75]]


def test_wrong_logs_are_errors_that_name_the_file(tmp_path: Path) -> None:
    def refused(folder: str, benchmark: str, fact: str) -> None:
        with pytest.raises(BenchError) as error:
            results.foreign_board(tmp_path / folder, benchmark)
        assert error.value.code == "bad-foreign-log"
        assert fact in str(error.value)

    (tmp_path / "empty").mkdir()
    refused("empty", "meal", "No run of meal")
    refused("empty", "continual-world", "No run of continual-world")
    meal(tmp_path / "nan", 1, [[float("nan"), 1.0], [0.0, 1.0]])
    refused("nan", "meal", "0_soup.json")
    meal(tmp_path / "odd", 1, [[0.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    refused("odd", "meal", "[3] evaluations")
    meal(tmp_path / "missing", 1, [[0.0, 1.0], [0.0, 1.0]])
    (tmp_path / "missing/ippo/EWC/seed_1/0_soup.json").unlink()
    meal(tmp_path / "mixed", 1, [[0.0, 1.0], [0.0, 1.0]])
    (tmp_path / "mixed/ippo/EWC/seed_1/0_return.json").write_text("[0.0, 1.0]")
    refused("mixed", "meal", "return, soup")
    refused("missing", "meal", "no curve of task 0")
    log = continual_world(tmp_path / "short", 0) / "progress.tsv"
    log.write_text("\n".join(log.read_text().splitlines()[:3]) + "\n")
    refused("short", "continual-world", "no row of stage 1")
    continual_world(tmp_path / "nan-cw", 0, float("nan"))
    refused("nan-cw", "continual-world", "not finite")
    log = continual_world(tmp_path / "text", 0) / "progress.tsv"
    log.write_text(log.read_text().replace("0.75", "often"))
    refused("text", "continual-world", "progress.tsv: The file cannot be read: could not convert string")
    log = continual_world(tmp_path / "further", 0) / "progress.tsv"
    log.write_text(log.read_text().replace("/push-v1/success", "/push-v1/return"))
    refused("further", "continual-world", "rows of stage 1, and no success rate of its task")
    (continual_world(tmp_path / "config", 0) / "config.json").unlink()
    refused("config", "continual-world", "config.json")
    continual_world(tmp_path / "two", 0)
    continual_world(tmp_path / "two", 1, tasks=("reach-v1", "pick-v1"))
    refused("two", "continual-world", "different tasks")
