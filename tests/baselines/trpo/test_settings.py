"""The table of settings: the values of the two agents, and their rows in a manifest."""

from __future__ import annotations

from gym_extensions.baselines.algorithms.trpo import HENDERSON_2017, REFERENCE, manifest_settings


def test_the_2017_settings_are_those_of_the_committed_entry() -> None:
    settings = manifest_settings(HENDERSON_2017)
    assert settings["hidden"] == [100, 50, 25]
    assert (settings["activation"], settings["tanh_mean"]) == ("relu", True)
    assert (settings["max_kl"], settings["cg_damping"], settings["cg_iterations"]) == (0.01, 1e-5, 10)
    assert (settings["gae_lambda"], settings["discount"], settings["initial_log_sigma"]) == (1.0, 0.99, 0.0)
    assert not settings["normalize_observations"]
    assert settings["value_function"] == "MLP 64-64 relu, 10 epochs of Adam at 0.001 per batch"


def test_the_two_agents_differ_in_the_rows_of_the_table_in_docs_learners() -> None:
    reference, old = manifest_settings(REFERENCE), manifest_settings(HENDERSON_2017)
    assert {name for name in reference if reference[name] == old[name]} == {"cg_iterations", "value_function"}
    assert REFERENCE.deterministic_evaluation
    assert not HENDERSON_2017.deterministic_evaluation
