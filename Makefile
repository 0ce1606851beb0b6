# The commands of this repository. All of them work on a fresh clone.

PYTHON ?= python3
PIP = .venv/bin/python -m pip --disable-pip-version-check --no-input install --quiet -c constraints.txt
export OPENBLAS_NUM_THREADS ?= 1
# Every process compiles what it imports where bytecode is not stored; the tests start many.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help leaderboard verify test browser screenshots extras attack honest check docs docsite findings bench slow coverage reproduce changelog clean

help:  ## list the commands
	@awk -F ':.*  ## ' '/^[a-z]+:.*  ## / { printf "make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

leaderboard: .venv/scoring.installed  ## check and score every submission, build _site/
	@.venv/bin/gym-extensions site submissions --out _site

# Without the whole git history (a shallow clone, an archive), the ledger's old versions are not compared.
verify: .venv/scoring.installed  ## check the ledger and replay every entry as it states (a few minutes)
	.venv/bin/gym-extensions ledger verify --replay \
	  $(shell test "$$(git rev-parse --is-shallow-repository 2>/dev/null)" = false || echo --no-history)

test: .venv/everything.installed  ## run the tests, except the slow ones and the benchmarks
	.venv/bin/pytest -n 2 --no-loadscope-reorder $(PYTEST)

browser: .venv/everything.installed  ## run the tests of the pages in Chromium; none may be skipped
	.venv/bin/pytest --no-skips -m 'slow or not slow' tests/site/in_browser tests/site/test_html5.py

screenshots: .venv/everything.installed leaderboard  ## take the pictures of the README from _site (needs Chromium)
	.venv/bin/python docs/images/take.py _site docs/images

extras: .venv/everything.installed  ## run the tests of the extras cluster, sbx and examples (needs EGL and OSMesa); none may be skipped
	$(PIP) -e '.[dev,cluster,sbx,examples]'
	.venv/bin/pytest --no-skips tests/baselines/algorithms/test_ppo_and_sac.py tests/baselines/execution/test_ray_cluster.py \
	  tests/envs/test_videos.py

slow: .venv/everything.installed  ## run the tests that train for minutes
	.venv/bin/pytest -m slow

attack: .venv/everything.installed  ## play all attacks of docs/security.md and write its table (ten minutes)
	.venv/bin/pytest -n 2 --dist load -m attack tests/attacks
	.venv/bin/pytest -q tests/attacks -k table --write-table

honest: .venv/everything.installed  ## check 400 honest submissions with two instruction sets (an hour; can be resumed)
	.venv/bin/python tests/benchmarks/measure_honest.py --out _honest

check: .venv/everything.installed  ## check style, types, import layers and workflows
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports
	.venv/bin/zizmor --offline --quiet .github
	.venv/bin/check-jsonschema --quiet --builtin-schema vendor.github-workflows .github/workflows/*.yml
	.venv/bin/check-jsonschema --quiet --builtin-schema vendor.dependabot .github/dependabot.yml

coverage: .venv/everything.installed  ## run the tests and measure which lines and branches they reach
	.venv/bin/pytest -n 2 --no-loadscope-reorder --cov --cov-report=term

docs: .venv/scoring.installed  ## write the generated tables of docs/*.md
	.venv/bin/python -m gym_extensions.scoring.output.docs docs
	.venv/bin/python -m gym_extensions.rollouts.rules docs/rollout-log.md

findings: .venv/everything.installed  ## write docs/findings.md and docs/reproduction.md from the committed submissions
	.venv/bin/python docs/findings/build.py
	.venv/bin/python docs/findings/reproduction.py

docsite: .venv/docs.installed  ## build the documentation as a site, _site/docs/
	@NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --quiet

bench: .venv/everything.installed  ## measure speed, as ratios taken side by side in one run
	$(PIP) -e '.[dev,bench]'
	.venv/bin/pytest -m bench tests/benchmarks --ratios site/gym_extensions/site/measured/ratios.json

reproduce: .venv/everything.installed  ## retrain one run: make reproduce ENTRY=submissions/random GROUP=hopper-gravity RUN=0
	@test -n "$(ENTRY)" -a -n "$(GROUP)" || { echo "Name an entry and a group"; exit 2; }
	.venv/bin/gym-extensions reproduce $(ENTRY) --group $(GROUP) --run $(or $(RUN),0) --protocol $(or $(PROTOCOL),sequential)

changelog: .venv/everything.installed  ## move the fragments into CHANGELOG.md: make changelog VERSION=1.0.0
	@test -n "$(VERSION)" || { echo "Name the version: make changelog VERSION=1.0.0"; exit 2; }
	.venv/bin/towncrier build --yes --version $(VERSION)

# The scoring set has no torch; the rest adds it, always through constraints.txt.
.venv/scoring.installed: pyproject.toml constraints.txt
	test -x .venv/bin/python || $(PYTHON) -m venv .venv
	$(PIP) -e .
	@touch $@

.venv/docs.installed: .venv/scoring.installed
	$(PIP) -e '.[docs]'
	@touch $@

# Avalanche is an oracle of the tests; its dependencies need a CUDA build of torch (docs/adr/0053).
.venv/everything.installed: .venv/scoring.installed
	$(PIP) -e '.[dev]'
	$(PIP) --no-deps avalanche-lib
	@touch $@

clean:  ## remove .venv, _site and built packages
	rm -rf .venv _site build dist
