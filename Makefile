# make demo    opens the door in simulation
# make test-rig   flies over emulated links in real time: about 20 minutes, on an otherwise idle machine
# make rig-demo    opens it through emulated autopilot, servos and cameras, on their real protocols
# make test    runs every check and every test; needs chromium
# make docs    builds the documentation, with its tutorials executed, from docs/ and the docstrings: build/docs/index.html
# make bench   measures the planner against other solvers and writes docs/benchmarks.md: about 45 minutes
# make clean   removes the virtual environment and everything that tools left behind
#
# Both install what they need into .venv first. Another interpreter or place: make test PYTHON=python3.12 VENV=/tmp/doorman

PYTHON ?= python3
VENV ?= .venv
SCENARIO ?= paper

BIN := $(VENV)/bin
CHECK_PYTHON := import sys; sys.exit(sys.version_info < (3, 11) and "doorman needs Python 3.11 or newer: make PYTHON=python3.11")

.DELETE_ON_ERROR:
.PHONY: demo rig-demo test test-all test-rig coverage lint docs bench clean

demo: $(VENV)/.installed-for-demo
	$(BIN)/doorman open $(SCENARIO)

rig-demo: $(VENV)/.installed-for-rig
	$(BIN)/doorman rig $(SCENARIO) --fly

# First what runs in real time or takes signals, with kernels compiled ahead; then everything else, which takes all of two cores.
# What a busy machine held up in real time gets a second chance; what fails twice fails.
REAL_TIME := tests/hardware tests/test_recording_signals.py
CHOSEN := -m "not slow"

test: lint
	$(BIN)/doorman warmup paper & other=$$!; $(BIN)/doorman warmup push && wait $$other
	$(BIN)/python -m pytest -n 2 $(REAL_TIME) || $(BIN)/python -m pytest --last-failed $(REAL_TIME)
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder $(CHOSEN) $(REAL_TIME:%=--ignore=%) --ignore=tests/rig $(PYTEST_OPTIONS)

# With the slow ones: rare faults, and kernels compiled for further arms and problems: 20 minutes more.
test-all: CHOSEN :=
test-all: test

# The same with a report of what the tests do not reach; slower by half.
coverage: PYTEST_OPTIONS := --cov --cov-report=term:skip-covered --cov-report=xml
coverage: test

# Whole flights over the emulated links, in real time: they need two cores of their own, which test machines do not promise.
test-rig: $(VENV)/.installed-for-test
	$(BIN)/doorman warmup paper
	$(BIN)/python -m pytest tests/rig

lint: $(VENV)/.installed-for-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/.installed-for-test
	$(BIN)/doorman warmup paper push
	$(BIN)/python -m sphinx -q -W --keep-going -b html -c docs . build/docs

# The peers get an environment of their own under build/.
bench: $(VENV)/.installed-for-test
	$(BIN)/python benchmarks/run.py --write-docs

$(BIN)/python:
	$(PYTHON) -c '$(CHECK_PYTHON)'
	$(PYTHON) -m venv $(VENV) || { echo "no virtual environment: on Debian and Ubuntu, apt install python3-venv"; exit 1; }

$(VENV)/.installed-for-demo: pyproject.toml | $(BIN)/python
	@echo 'Installing into $(VENV): a minute or two the first time'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[sim,viz]'
	touch $@

$(VENV)/.installed-for-rig: pyproject.toml | $(BIN)/python
	@echo 'Installing into $(VENV): a minute or two the first time'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[sim,viz,hardware]'
	touch $(VENV)/.installed-for-demo $@

# Includes what the demos need: their stamps are set too, so that they do not install again. Python compiles what is imported.
$(VENV)/.installed-for-test: pyproject.toml | $(BIN)/python
	@echo 'Installing into $(VENV): a few minutes the first time'
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -e '.[sim,viz,hardware,campaign,test]'
	touch $(VENV)/.installed-for-demo $(VENV)/.installed-for-rig $@

clean:
	rm -rf $(VENV) build dist coverage.xml .coverage .hypothesis .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
	find doorman tests benchmarks examples -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true
