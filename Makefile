# Everything runs in .venv, made from requirements.lock. GNU make 3.81 (macOS) is enough.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/installed
OLDEST := .venv-oldest
SMOKE := tests/certify/test_check.py tests/certify/test_tubes.py tests/spec/test_specification.py tests/surfaces/test_mesh.py \
  tests/results/test_result.py tests/solvers/test_slsqp.py tests/fabricate/test_crease_sheets.py tests/repair/test_repair.py
UV_VERSION := 0.13.9

# One BLAS thread: at these matrix sizes two are about four times slower.
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: help demo setup test test-slow test-oldest lint format docs bench bench-solving lock clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

demo: $(STAMP) ## solve targets/vault.yaml and say where the pictures are
	$(BIN)/inverse solve targets/vault.yaml

setup: $(STAMP) ## make .venv with the locked dependencies and this checkout

test: lint ## lint, types and the tests, without the slow ones
	$(BIN)/python -m pytest -m "not slow" --numprocesses auto --maxprocesses 4 --dist loadfile

test-slow: $(STAMP) ## only the slow tests
	$(BIN)/python -m pytest -m slow

test-oldest: $(OLDEST)/installed ## a few of the tests with the oldest libraries that pyproject.toml admits, on the built wheel
	$(BIN)/python -m hatchling build -t wheel -d $(OLDEST)
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall $(OLDEST)/inverse-*.whl
	$(OLDEST)/bin/pytest --quiet -m "not slow" -k "not command_line" $(SMOKE)

lint: $(STAMP) ## ruff and mypy
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

format: $(STAMP) ## let ruff rewrite what it can
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

docs: $(STAMP) ## pages of docs/ and of the docstrings, build/docs/index.html; warnings are errors
	$(BIN)/python docs/keys.py
	$(BIN)/python -m sphinx -W --keep-going --quiet docs build/docs

bench: $(STAMP) ## quality of fits, tubes, speed from 16 x 16 to 128 x 128, films, thick panels (a quarter of an hour)
	$(BIN)/python -m benchmarks.fit
	$(BIN)/python -m benchmarks.tubes
	$(BIN)/python -m benchmarks.live
	$(BIN)/python -m benchmarks.speed
	$(BIN)/python -m benchmarks.verdicts
	$(BIN)/python -m benchmarks.commands
	$(BIN)/python -m benchmarks.motion
	$(BIN)/python -m benchmarks.panels

bench-solving: $(STAMP) ## how often a solve succeeds, with and without IPOPT; strong bends, drags, footprints (an hour)
	$(BIN)/python -m benchmarks.robustness
	$(BIN)/python -m benchmarks.robustness --method nlopt
	$(BIN)/python -m benchmarks.brief
	$(BIN)/python -m benchmarks.strong
	$(BIN)/python -m benchmarks.refine
	$(BIN)/python -m benchmarks.footprint

LOCKED := --python-version 3.11 --generate-hashes --no-annotate --no-header --no-emit-index-url --quiet

lock: ## write requirements.lock and requirements-oldest.lock anew from pyproject.toml
	$(PYTHON) -m venv .venv-lock
	.venv-lock/bin/pip install --quiet uv==$(UV_VERSION)
	.venv-lock/bin/uv pip compile pyproject.toml --extra dev --extra fabricate --universal --fork-strategy fewest \
	  $(LOCKED) --output-file requirements.lock
	rm -f requirements-oldest.lock  # what it holds would be kept
	.venv-lock/bin/uv pip compile pyproject.toml --extra test --extra fabricate --resolution lowest-direct \
	  $(LOCKED) --output-file requirements-oldest.lock

clean: ## remove the environment, results and caches
	rm -rf .venv .venv-lock .venv-oldest out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis tests/node/node_modules
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The build backend is locked too, so nothing is fetched that has no hash.
$(STAMP): requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' || { \
	  echo "inverse needs Python 3.11 to 3.13 and $(PYTHON) is not one: name one that is, as in make demo PYTHON=python3.12." >&2; \
	  exit 1; }
	$(PYTHON) -m venv --clear .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $@

$(OLDEST)/installed: requirements-oldest.lock $(STAMP)
	$(PYTHON) -m venv --clear $(OLDEST)
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-oldest.lock
	@touch $@
