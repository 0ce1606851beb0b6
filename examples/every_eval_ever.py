"""A scorecard as a record of Every Eval Ever: `python examples/every_eval_ever.py SUBMISSION > record.json`.

The schema, here of version 0.3.0, is at https://github.com/evaleval/every_eval_ever. Its records were made
for language models: what has no place there (protocol, budget, level) is in `additional_details`.
"""

import json
import sys
import time
from importlib.metadata import version
from typing import Any

from gym_extensions.metrics.formulas import BY_NAME
from gym_extensions.scoring import score_folder

NAME = "gym-extensions"


def record(submission: str, now: int) -> dict[str, Any]:
    """The record of a submission; `now` is in seconds since 1970."""
    card = score_folder(submission)
    authors = card.manifest.authors if card.manifest else ()
    results: list[dict[str, Any]] = []
    for group, protocols in card.groups.items():
        for protocol, score in protocols.items():
            facts = {"tasks": ", ".join(score.tasks), "protocol": protocol, "budget": score.budget}
            source = {"dataset_name": group, "source_type": "other", "additional_details": facts}
            for name, value in score.metrics.items():
                metric = BY_NAME[name]
                if value.mean is not None and metric.better:  # others are not ranked
                    ends = value.ends and {"lower": value.low, "upper": value.high, "confidence_level": 0.95}
                    uncertainty = {"confidence_interval": ends, "num_samples": len(value.runs)}
                    config = {
                        "evaluation_description": metric.formula,
                        "metric_id": f"gym_extensions.{name}",
                        "metric_name": metric.title,
                        "metric_unit": "normalized return: 0 = floor, 1 = expert",
                        "lower_is_better": metric.better == "lower",
                        "score_type": "continuous",
                    }
                    result: Any = {"evaluation_result_id": f"{group}/{protocol}/{name}"}
                    details = {"score": value.mean, **({"uncertainty": uncertainty} if ends else {})}
                    result |= {"evaluation_name": group, "source_data": source}
                    results.append(result | {"metric_config": config, "score_details": details})
    level = {"level": str(card.level), "decisions": "\n".join(card.doubts)}
    origin = {"source_name": NAME, "source_type": "evaluation_run", "source_organization_name": NAME}
    return {
        "schema_version": "0.3.0",
        "evaluation_id": f"{NAME}/{card.name}/{now}",
        "retrieved_timestamp": str(now),
        "source_metadata": origin | {"evaluator_relationship": "first_party", "additional_details": level},
        "eval_library": {"name": NAME, "version": version(NAME)},
        "model_info": {"name": card.title, "id": card.name, "developer": ", ".join(authors)},
        "evaluation_results": results,
    }


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python examples/every_eval_ever.py SUBMISSION")
    print(json.dumps(record(sys.argv[1], int(time.time())), indent=1, ensure_ascii=False))
