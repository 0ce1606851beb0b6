"""Examples that read the logs of another benchmark, and write the formats of other projects."""

import json
import runpy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from gym_extensions.metrics.formulas import BY_NAME
from gym_extensions.scoring import score_folder

EXAMPLES = Path(__file__).parents[2] / "examples"
TRPO = EXAMPLES.parent / "submissions" / "trpo"


def example(name: str) -> dict[str, Any]:
    """The names of an example; its ``__main__`` block does not run."""
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


def write_run(folder: Path, config: object, columns: list[str], rows: Sequence[Sequence[float]]) -> None:
    """A run as Continual World writes it."""
    folder.mkdir()
    (folder / "config.json").write_text(json.dumps(config), encoding="utf-8")
    lines = ["\t".join(columns), *("\t".join(map(str, row)) for row in rows)]
    (folder / "progress.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_logs_of_continual_world_give_every_metric_of_their_matrix(tmp_path: Path) -> None:
    names = [f"test/stochastic/{at}/{task}/success" for at, task in enumerate(("reach", "push"))]
    # Two evaluations per stage: reach is learned to 1 and falls to .5 at the end.
    rows = [(0.5, 0.0, 0), (1.0, 0.0, 0), (0.75, 0.5, 1), (0.5, 1.0, 1)]
    for run in range(2):
        write_run(tmp_path / f"run{run}", {"cl_method": "ewc"}, [*names, "train/active_env"], rows)
    board = example("foreign_logs")["board"]
    assert board(tmp_path)["asymptotic_transfer"].isna().all(), "no run on a task alone"
    for task, values in (("reach", (0.0, 1.0)), ("push", (0.0, 0.5))):
        column = f"test/stochastic/0/{task}/success"
        write_run(tmp_path / task, {"task": task}, [column], [(value,) for value in values])
    row = board(tmp_path).loc["ewc"]
    # The last five evaluations of a stage are averaged, here both: the matrix is .75, 0 and .625, .75.
    assert row["final_performance"] == pytest.approx((0.625 + 0.75) / 2)
    assert row["forgetting"] == pytest.approx(0.75 - 0.625)
    assert row["forward_transfer_auc"] == pytest.approx(0.75 - 0.25)


@pytest.mark.committed
def test_a_record_of_every_eval_ever_has_every_ranked_metric_and_its_interval() -> None:
    record = example("every_eval_ever")["record"](str(TRPO), 0)
    assert (record["schema_version"], record["model_info"]["name"]) == ("0.3.0", "TRPO")
    assert record["source_metadata"]["additional_details"]["level"] == "verified"
    found = {each["evaluation_result_id"]: each for each in record["evaluation_results"]}
    ranked = {
        f"{group}/{protocol}/{name}": value
        for group, protocols in score_folder(TRPO).groups.items()
        for protocol, score in protocols.items()
        for name, value in score.metrics.items()
        if BY_NAME[name].better and value.mean is not None
    }
    assert found.keys() == ranked.keys()
    for name, value in ranked.items():
        details = found[name]["score_details"]
        interval = details["uncertainty"]["confidence_interval"]
        assert (details["score"], interval["lower"], interval["upper"]) == (value.mean, value.low, value.high)


@pytest.mark.committed
def test_minari_loads_the_data_and_its_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    minari = pytest.importorskip("minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    name = example("minari_dataset")["write"](str(TRPO), "hopper-wall", episodes=1)
    dataset = minari.load_dataset(name)
    assert dataset.total_episodes == 1
    assert dataset.recover_environment().spec.id == "gym_extensions/HopperWall-v0"
