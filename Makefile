# The commands of this repository. All of them work on a fresh clone, some need its submissions (CONTRIBUTING.md).

PYTHON ?= python3
PIP = .venv/bin/python -m pip --disable-pip-version-check --no-input install --quiet -c constraints.txt
export OPENBLAS_NUM_THREADS ?= 1
# Every process compiles what it imports where bytecode is not stored; the tests start many.
unexport PYTHONDONTWRITEBYTECODE

# The address of the public repository, and that of the pages, where there are any: make docsite REPOSITORY=https://… SITE_URL=https://…
export REPOSITORY ?=
SITE_URL ?=
PUBLIC = $(if $(REPOSITORY),--repository $(REPOSITORY)) $(if $(SITE_URL),--url $(SITE_URL))

.DEFAULT_GOAL := help
.PHONY: help leaderboard site-assets test browser extras check docs docsite findings bench slow clean

help:  ## list the commands
	@awk -F ':.*  ## ' '/^[a-z-]+:.*  ## / { printf "make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

site-assets: .venv/scoring.installed  ## fetch MuJoCo for the browser, 3 MB, for the page Play (needs npm)
	.venv/bin/python -m tools.mujoco_wasm

leaderboard: .venv/scoring.installed  ## check and score every submission, build _site/
	@.venv/bin/gym-extensions site submissions --out _site $(PUBLIC)

test: .venv/everything.installed  ## run the tests, except the slow ones and the benchmarks
	.venv/bin/pytest -n 2 --dist loadfile $(PYTEST)

browser: .venv/everything.installed .venv/docs.installed site-assets  ## run the tests of the pages in Chromium; none may be skipped
	.venv/bin/pytest --no-skips -m 'slow or not slow' tests/site/in_browser

extras: .venv/everything.installed  ## run the tests of the extras onnx, sbx, examples and parquet, and of Minari (needs EGL and OSMesa); none may be skipped
	$(PIP) -e '.[dev,onnx,sbx,examples,parquet]' mlcroissant 'minari[create,hdf5]>=0.5.3,<0.6'
	.venv/bin/pytest --no-skips tests/baselines/algorithms/test_ppo_and_sac.py tests/baselines/adapters tests/baselines/test_submission.py \
	  tests/envs/test_wrappers.py tests/export tests/examples/test_formats.py tests/results/test_frames.py tests/submissions/policies tests/verification/test_networks.py tests/test_policies.py

slow: .venv/everything.installed  ## run the tests that are marked as slow
	.venv/bin/pytest -m slow

check: .venv/everything.installed .venv/docs.installed  ## check style, types, import layers and workflows
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports
	.venv/bin/zizmor --offline --quiet .github
	.venv/bin/check-jsonschema --quiet --builtin-schema vendor.github-workflows .github/workflows/*.yml
	.venv/bin/check-jsonschema --quiet --builtin-schema vendor.dependabot .github/dependabot.yml

docs: .venv/everything.installed  ## write the generated pages, tables and outputs of docs/
	.venv/bin/python -m tools.docs

findings: .venv/everything.installed  ## write docs/findings.md, docs/reproduction.md and figures from the committed submissions
	.venv/bin/python -m tools.findings

docsite: .venv/docs.installed  ## build the boards and the documentation as one site, _site/ and _site/docs/
	@.venv/bin/gym-extensions site submissions --out _site --docs $(PUBLIC)
	@NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build

bench: .venv/everything.installed  ## measure speed, as ratios taken side by side in one run
	$(PIP) -e '.[dev,bench]'
	.venv/bin/pytest -m bench tools/benchmarks --ratios tools/benchmarks/ratios.json

# The scoring set has no torch; the rest adds it, always through constraints.txt.
.venv/scoring.installed: pyproject.toml constraints.txt
	test -x .venv/bin/python || $(PYTHON) -m venv .venv
	$(PIP) -e .
	@touch $@

.venv/docs.installed: .venv/scoring.installed
	$(PIP) -e '.[docs]'
	@touch $@

.venv/everything.installed: .venv/scoring.installed
	$(PIP) -e '.[dev]'
	@touch $@

clean:  ## remove .venv, _site and built packages
	rm -rf .venv _site build dist
