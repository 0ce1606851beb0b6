# The commands of this repository. `make leaderboard` and `make test` work on a fresh clone.

PYTHON ?= python3
PIP = .venv/bin/python -m pip --disable-pip-version-check --no-input install --quiet -c constraints.txt
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: leaderboard test check docs bench slow clean

leaderboard: .venv/scoring.installed  ## check and score every submission, build _site/
	@.venv/bin/gym-extensions site submissions --out _site

test: .venv/everything.installed  ## every test but the slow ones
	.venv/bin/pytest -n 2 --dist worksteal

slow: .venv/everything.installed  ## the tests that train for minutes
	.venv/bin/pytest -m slow

check: .venv/everything.installed  ## style, types, and the direction of imports
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports

docs: .venv/scoring.installed  ## write the generated tables of docs/*.md
	.venv/bin/python -m gym_extensions.scoring.output.docs docs

bench: .venv/everything.installed  ## speed, as ratios measured side by side in one run
	$(PIP) -e '.[dev,bench]'
	.venv/bin/pytest -m bench tests/benchmarks --ratios site/gym_extensions/site/measured/ratios.json

# The scoring set has no torch; the rest adds it, always through constraints.txt.
.venv/scoring.installed: pyproject.toml constraints.txt
	test -x .venv/bin/python || $(PYTHON) -m venv .venv
	$(PIP) -e .
	@touch $@

# Avalanche is an oracle in the tests; what it would bring along needs a CUDA build of torch (docs/adr/0053).
.venv/everything.installed: .venv/scoring.installed
	$(PIP) -e '.[dev]'
	$(PIP) --no-deps avalanche-lib
	@touch $@

clean:
	rm -rf .venv _site build dist
