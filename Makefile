# Upwash. `make` alone lists what there is to do. Needs only make and a Python 3.11 or newer.

.DEFAULT_GOAL := help
.PHONY: help install test thorough portable reproduce reference wheel check bench uvlm mutants docs clean lock
.DELETE_ON_ERROR:

# The first of these that is a Python 3.11 or newer and can make virtual environments; `make PYTHON=… test` overrides.
PYTHON ?= $(firstword $(foreach name,python3 python3.14 python3.13 python3.12 python3.11 python,\
	$(shell $(name) -c 'import sys, venv, ensurepip; sys.version_info >= (3, 11) and print("$(name)")' 2>/dev/null)))

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PYTEST := $(BIN)/python -m pytest --numprocesses 2 --dist worksteal

help:  ## list these targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: $(VENV)/installed-dev  ## make .venv with everything a developer needs

test: $(VENV)/installed-dev  ## run the tests, in two processes, but for those that take long
	$(PYTEST) -m "not thorough"

thorough: $(VENV)/installed-dev  ## run the tests that take long: whole matrices of faults and forgeries, kills, generated code
	$(PYTEST) -m thorough

portable: $(VENV)/installed-dev  ## run all tests with kernels compiled for any processor instead of this one
	NUMBA_CPU_NAME=generic NUMBA_CPU_FEATURES= $(PYTEST)

reproduce: $(VENV)/installed  ## redo the paper: solve, check, print its table beside ours, write a page about it
	$(BIN)/upwash reproduce

reference: $(VENV)/installed  ## renew results/reference/ and what shows it in README and docs, when results are meant to change
	$(BIN)/python tools/renew_phase.py
	$(BIN)/python tools/renew_published.py
	$(BIN)/python tools/renew_reference.py
	$(BIN)/python tools/renew_claims.py
	$(BIN)/python tools/renew_literature.py

wheel: $(VENV)/installed-dev  ## build a wheel, and try it in a fresh environment and an empty folder
	$(BIN)/python tools/try_wheel.py

check: $(VENV)/installed-dev  ## lint and type-check
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(VENV)/installed-bench  ## measure what is fast, and against what
	$(BIN)/python -m benchmarks

uvlm: $(VENV)/installed-uvlm  ## fly the ibis in an unsteady vortex lattice anew: results/crosscheck/, docs/lattice.md (minutes)
	$(BIN)/python -m benchmarks.uvlm
	$(BIN)/python tools/renew_lattice.py

mutants: $(VENV)/installed-bench  ## put a hundred faults into the code, one at a time, and count those that tests notice (hours)
	$(BIN)/python tools/mutants.py

docs: $(VENV)/installed-dev  ## build the documentation into site/, warnings being errors
	$(BIN)/mkdocs build --strict

clean:  ## delete everything that a run or a build made, except results/
	rm -rf $(VENV) site build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# A lock file names each package's version and hashes for every supported Python. The development and benchmark
# locks take their versions from the run-time lock, so the sets never disagree and can share one .venv.
lock: $(BIN)/python  ## renew the lock files from pyproject.toml (UPGRADE=--upgrade for newer versions)
	$(PIP) install uv
	$(COMPILE) -o requirements.lock
	$(COMPILE) --extra dev -c requirements.lock -o requirements-dev.lock
	$(COMPILE) --extra bench -c requirements-dev.lock -o requirements-bench.lock
	$(COMPILE) --extra uvlm -c requirements-bench.lock -o requirements-uvlm.lock

COMPILE = echo 'setuptools>=77' | $(BIN)/python -m uv pip compile pyproject.toml - --quiet --universal \
	--python-version 3.11 --generate-hashes --no-header --no-annotate --no-emit-package upwash $(UPGRADE)

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "expected Python 3.11 or newer (with its venv module), found none on PATH:" \
		"install one, or name it: make PYTHON=/path/to/python3" >&2; exit 2; }
	@$(PYTHON) -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
		echo "expected PYTHON to be Python 3.11 or newer with its venv module, found '$(PYTHON)':" \
		"name another, or install one" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

# What .venv holds, as stamps; each is renewed when its lock file changes.
STAMPS := $(VENV)/installed $(VENV)/installed-dev $(VENV)/installed-bench $(VENV)/installed-uvlm
$(VENV)/installed: requirements.lock
$(VENV)/installed-dev: requirements-dev.lock
$(VENV)/installed-bench: requirements-bench.lock
$(VENV)/installed-uvlm: requirements-uvlm.lock
$(STAMPS): pyproject.toml | $(BIN)/python
	$(PIP) install --require-hashes -r $(filter %.lock,$^)
	$(PIP) install --no-deps --no-build-isolation --editable .
	$(BIN)/upwash warm >/dev/null
	@touch $@
