# Everything a newcomer needs: `make bench` measures, `make test` tests.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: bench test check build docs objects clean

$(STAMP): pyproject.toml constraints.txt
	test -d $(VENV) || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet -c constraints.txt -e ".[dev]"
	touch $@

bench: $(STAMP)
	$(BIN)/grasp-bench run --objects all --trials 180
	$(BIN)/grasp-bench report results/

test: $(STAMP)
	$(BIN)/python -m pytest -n auto

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/pyright

build: $(STAMP)
	rm -rf dist
	$(BIN)/python -m build --quiet
	$(PYTHON) tests/smoke_wheel.py dist

# The two variables silence notices about the future of MkDocs; warnings of the site itself still fail.
docs: $(STAMP)
	NO_MKDOCS_2_WARNING=1 DISABLE_MKDOCS_2_WARNING=true $(BIN)/mkdocs build --strict --quiet

objects: $(STAMP)
	$(BIN)/grasp-bench objects build

clean:
	rm -rf dist build site .pytest_cache .ruff_cache
