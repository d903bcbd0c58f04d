# Every target installs what it needs into .venv first, in the versions of constraints.txt.
# Another interpreter or place: make test PYTHON=python3.12 VENV=/tmp/doorman

PYTHON ?= python3
VENV ?= .venv
SCENARIO ?= paper
CONSTRAINTS ?= constraints.txt
TAG ?=

BIN := $(VENV)/bin
# A process that finds no bytecode takes twice as long to start, and tests start hundreds.
unexport PYTHONDONTWRITEBYTECODE
CHECK_PYTHON := import sys; sys.exit(sys.version_info < (3, 11) and "doorman needs Python 3.11 or newer: make PYTHON=python3.11")

.DELETE_ON_ERROR:
.PHONY: help demo rig-demo test-quick test test-docs test-all test-rig coverage lint warm docs bench test-lowest dist release-check clean

help:
	@sed -n 's/^#: *//p' $(firstword $(MAKEFILE_LIST))

#: make demo       open a door in simulation
demo: $(VENV)/.installed-for-demo
	$(BIN)/doorman open $(SCENARIO)

#: make rig-demo   open it through emulated autopilot, servos and cameras, on their real protocols
rig-demo: $(VENV)/.installed-for-demo
	$(BIN)/doorman rig $(SCENARIO) --fly

# One worker more than cores: time is virtual in most tests (tests/helpers/virtual_time.py), but some wait for pages, processes and sockets.
WORKERS ?= $(shell $(PYTHON) -c 'import os; print((os.cpu_count() or 1) + 1)')
CHOSEN := -m "not slow and not docs" --ignore=tests/rig
PYTEST = $(BIN)/python -m pytest --durations=10 $(PYTEST_OPTIONS)

#: make test-quick before each commit: style, types, parsers, units, one plan of each kind, one flight: 90 s with compiled kernels
QUICK := tests/scenario tests/kinematics/urdf tests/hardware/safety tests/hardware/pixhawk/link tests/hardware/dynamixel/test_servo_p* \
  tests/hardware/pixhawk/test_pixhawk_[cu]* tests/hardware/mocap/test_mocap_[cpt]* tests/hardware/mocap/test_mocap_f[ru]* tests/hardware/vehicle \
  tests/recording/test_recording*.py tests/campaign/test_j* tests/campaign/test_draws.py tests/control/estimation tests/summary \
  tests/planning/test_planner.py tests/planning/whole_body tests/planning/grip tests/mission/test_mission.py tests/package/test_checks.py \
  tests/docs/test_names.py tests/docs/test_prose.py tests/mission/flights/test_flights.py::test_the_papers_door_is_opened
LINT := lint
test-quick: $(VENV)/.installed-for-test
	$(MAKE) --jobs=2 $(LINT) warm
	$(PYTEST) -n $(WORKERS) --dist worksteal $(CHOSEN) $(QUICK)

#: make test       before each push: style, types, and every test but the slow ones; needs chromium and EGL: 7 to 12 minutes
test: $(VENV)/.installed-for-test
	$(MAKE) --jobs=2 lint warm
	$(PYTEST) -n $(WORKERS) --dist worksteal $(CHOSEN)

#: make test-docs  before docs change: tutorials, how-to pages and examples are executed: 2 minutes
test-docs: $(VENV)/.installed-for-test
	$(PYTEST) -n $(WORKERS) --dist loadfile -m docs

#: make test-all   before a release: the above and the slow tests, such as rare faults and whole campaigns: an hour more
test-all: CHOSEN := --ignore=tests/rig
test-all: test

#: make coverage   the tests, and what they do not reach; slower by half
coverage: PYTEST_OPTIONS += --cov --cov-report=term:skip-covered --cov-report=xml
coverage: test

#: make test-rig   whole flights over emulated links in real time, on an otherwise idle machine: about 20 minutes
test-rig: warm
	$(BIN)/python -m pytest tests/rig

#: make lint       style, types and imports
lint: $(VENV)/.installed-for-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Kernels are compiled once, by one process a core; what is compiled already is loaded.
warm: $(VENV)/.installed-for-test
	$(BIN)/doorman warmup paper push

#: make docs       build the documentation, with its tutorials executed: build/docs/index.html
docs: warm
	$(BIN)/python -m sphinx -q -W --keep-going -b html -c docs . build/docs

#: make bench      build the other solvers, measure all, and write docs/benchmarks.md: about an hour
# The peers get an environment of their own under build/.
bench: $(VENV)/.installed-for-test
	$(BIN)/python benchmarks/run.py --write-docs

#: make test-lowest    the quick tests with the lowest versions that pyproject.toml declares, in build/lowest
test-lowest: build/lowest.txt
	$(MAKE) test-quick LINT= VENV=build/lowest CONSTRAINTS=build/lowest.txt

build/lowest.txt: .ci/lowest.py pyproject.toml constraints.txt
	mkdir -p build
	$(PYTHON) .ci/lowest.py > $@

#: make dist       the sdist, and the wheel that is built from it: dist/
dist: $(VENV)/.installed-for-test
	rm -rf dist
	$(BIN)/hatchling build --target sdist
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist dist/*.tar.gz

#: make release-check  what a release must pass, with TAG=vX.Y.Z if there is one: versions, changelog, and the wheel in use
release-check: dist
	$(BIN)/python .ci/release.py dist $(TAG)
	$(BIN)/python .ci/smoke.py dist/*.whl $(CONSTRAINTS)

$(BIN)/python:
	$(PYTHON) -c '$(CHECK_PYTHON)'
	$(PYTHON) -m venv $(VENV) || { echo "no virtual environment: on Debian and Ubuntu, apt install python3-venv"; exit 1; }

$(VENV)/.installed-for-demo: pyproject.toml $(CONSTRAINTS) | $(BIN)/python
	@echo 'Installing into $(VENV): a minute or two the first time'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c $(CONSTRAINTS) -e '.[sim,viz,hardware]'
	touch $@

# Includes what the demos need: their stamp is set too, so that they do not install again. Python compiles what is imported.
$(VENV)/.installed-for-test: pyproject.toml $(CONSTRAINTS) | $(BIN)/python
	@echo 'Installing into $(VENV): a few minutes the first time'
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -c $(CONSTRAINTS) -e '.[sim,viz,hardware,campaign,test]'
	touch $(VENV)/.installed-for-demo $@

#: make clean      remove the virtual environment and everything that tools left behind
clean:
	rm -rf $(VENV) build dist coverage.xml .coverage .hypothesis .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
	find doorman tests benchmarks examples -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true
