# Everything a newcomer needs: `make bench` measures, `make test` tests.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# What the gate tries: every seventh object and more, an upper bound and the shipped network.
GATE_OBJECTS := adjustable_wrench,balloon_whisk,bottle_opener,carabiner,chef_knife,combination_pliers,croissant,$\
	dumbbell,espresso_cup,french_press,hair_dryer,hex_key,juice_box,lemon_squeezer,milk_carton,$\
	needle_nose_pliers,paint_brush,pepper_mill,power_plug,salt_shaker,soup_ladle,$\
	stubby_phillips_screwdriver,telephone_handset,toy_boat
GATE_PREDICTORS := oracle htc-grasp
GATE_RUN = $(BIN)/grasp-bench run --objects $(GATE_OBJECTS) --trials 24 --quiet --predictor

.PHONY: bench test check build docs objects gate gate-objects baseline clean

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
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

build: $(STAMP)
	rm -rf dist
	$(BIN)/python -m build --quiet
	$(BIN)/python -m build --quiet --wheel --outdir dist rivals
	$(PYTHON) scripts/smoke_wheel.py dist

# The two variables silence notices about the future of MkDocs; warnings of the site itself still fail.
docs: $(STAMP)
	NO_MKDOCS_2_WARNING=1 DISABLE_MKDOCS_2_WARNING=true $(BIN)/mkdocs build --strict --quiet

objects: $(STAMP)
	$(BIN)/grasp-bench objects build

# Did the rate drop? Against the committed baseline, 24 trials a predictor: enough to see something break (five
# trials lost and none gained), not a drop of some points. Paired and statistical rather than exact, because a
# network's last digits depend on the processor.
gate: $(STAMP)
	rm -rf results/gate
	set -e; for p in $(GATE_PREDICTORS); do \
	  $(GATE_RUN) $$p --out results/gate/$$p --max-errors 24; \
	  $(BIN)/grasp-bench check results/gate/$$p --baseline results/baseline/$$p --margin 0.15; \
	done

gate-objects:
	@echo objects=$(GATE_OBJECTS)

# Makes the gate's baseline anew, on an idle machine: a timeout or any other fault of the harness is refused.
# Commit results/baseline with the change that moved it, and say why.
baseline: $(STAMP)
	rm -rf results/baseline
	set -e; for p in $(GATE_PREDICTORS); do $(GATE_RUN) $$p --out results/baseline/$$p; done

clean:
	rm -rf dist build site results/gate .pytest_cache .ruff_cache
