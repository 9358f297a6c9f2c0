# Two commands do everything on a fresh machine with Python 3.11 or later and make:
#   make drive ROAD=C      sets up, drives, leaves recordings/ROAD.rrd
#   make test              sets up, checks format, lint and types, and runs the tests
# ARGS="..." passes further options:  make drive ROAD=D ARGS="--pressure fl=180 --speed 100"

PYTHON ?= python3
ROAD ?= C
BIN = .venv/bin
SOURCES := $(shell find models testbed estimators -name '*.py' -o -name '*.toml')

.PHONY: drive test check validation bench setup clean

drive: setup
	$(BIN)/python -m testbed.drive --road "$(ROAD)" $(ARGS)

test: check
	$(BIN)/python -m pytest -n auto --dist loadfile

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

# what the validation tests measured, as the README's table
validation: setup
	$(BIN)/python -m pytest --claims

bench: setup
	$(BIN)/python -m testbed.bench $(ARGS)

setup: .venv/kernels

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	touch $@

# compiled kernels are cached on disk; a short drive compiles what the sources' present state needs
.venv/kernels: .venv/installed $(SOURCES)
	$(BIN)/python -m testbed.warm
	touch $@

clean:
	rm -rf .venv recordings/*.rrd recordings/*.json
