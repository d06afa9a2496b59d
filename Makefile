# make demo and make test are all that a fresh machine needs; both set up .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# pip takes every package at the version that CI ran
PIP := $(BIN)/python -m pip --disable-pip-version-check --require-virtualenv
# pip compiles nothing (a minute less), so Python has to keep what it compiles: torch anew takes every process 3 s
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help install demo test test-quick check docs bench messages clean

help:
	@echo "make demo        install, judge the policy that comes with symdyn, write out/demo/report.md"
	@echo "make test        install, run every test"
	@echo "make test-quick  install, run the tests that are fast: what one runs while editing"
	@echo "make install     only install, into $(VENV)"
	@echo "make check       ruff, pyright, import-linter"
	@echo "make docs        the documentation as a site, into out/site"
	@echo "make bench       speed and memory, as ratios within one run, into out/bench.json"
	@echo "make clean       remove $(VENV) and out/"

install: $(VENV)/installed

$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "symdyn needs Python 3.11 or newer")'
	$(PYTHON) -m venv $(VENV)
	$(PIP) install --quiet --no-compile --constraint constraints.txt --editable '.[all]'
	@touch $@

demo: install
	$(BIN)/symdyn demo --out out/demo

# files in parallel, slow ones first (not those of many tests); then, alone, what runs by the clock
test: install
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not realtime"
	$(BIN)/python -m pytest -m realtime

# what one runs while editing: no browser, no renderer, no process by the clock (tests/conftest.py)
test-quick: install
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not slow and not realtime"

check: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

docs: install
	$(BIN)/mkdocs build --strict --site-dir out/site

# the Python classes of the LCM messages, from their definitions
messages: install
	$(BIN)/lcm-gen -p --ppath out/lcm hardware/wire/messages/*.lcm
	cp out/lcm/hardware/wire/messages/*.py hardware/wire/messages/

bench: install
	$(BIN)/python -m benchmarks --out out/bench.json

clean:
	rm -rf $(VENV) out
