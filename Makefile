# Everything a newcomer needs; .ci/run calls the same targets.
PYTHON ?= python3
ENV := .venv
BIN := $(ENV)/bin
OUT := out
# So many random models are tried; `make random-models` begins with seed FIRST, `make reliability` with PDDECONT_SEED where it is set.
MODELS ?= 90
FIRST ?= 1000
# The version that branches are timed against: the last one whose branches were assembled by Python alone.
BEFORE ?= 0d30e19
LARGE ?=

.PHONY: setup demo figures images atlas test browser browser-tests page-times page-pictures reliability random-models random-delays stress packages check docs reference layers bench estimates versions cost tracking chain-order schema clean \
  distclean
setup: $(ENV)/ready

$(ENV)/ready: pyproject.toml setup.py $(wildcard pddecont/native/*.py pddecont/native/*.pxi pddecont/native/*/*.py pddecont/native/*/*.pxi)
	$(PYTHON) -m venv $(ENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -e ".[dev]"
	touch $@

demo: setup          ## figure 4.6 of the paper, from its YAML file to a picture
	mkdir -p $(OUT)
	$(BIN)/pddecont run configs/fig4_6.yaml -o $(OUT)/fig4_6.h5 --overwrite
	$(BIN)/pddecont export $(OUT)/fig4_6.h5 --table special
	$(BIN)/pddecont plot $(OUT)/fig4_6.h5 -o $(OUT)/fig4_6.png
	$(BIN)/pddecont report $(OUT)/fig4_6.h5 -o $(OUT)/fig4_6.html
	@echo "The picture is $(OUT)/fig4_6.png; the page with every number, for a browser, is $(OUT)/fig4_6.html"

test: setup          ## all but the slow tests, which `make reliability` runs too
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

browser: setup
	$(BIN)/python -m pip install --quiet -e ".[browser]"
	command -v chromium > /dev/null || { test "$$(id -u)" = 0 && apt-get update -qq && apt-get install -qq -y chromium; } || \
	  { echo "Chromium is missing; with Debian's packages: sudo apt install chromium" >&2; exit 1; }

browser-tests: browser ## the page of a report in Chromium, which is the system's
	PDDECONT_BROWSER=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest tests/browser

page-times: browser  ## size of pages, and how long a browser takes to load and to move in them
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.page

page-pictures: browser ## docs/images/page_*.png: the page on five runs
	mkdir -p $(OUT)/page
	OPENBLAS_NUM_THREADS=1 PYTHONPATH=. $(BIN)/python docs/page_pictures.py $(OUT)/page

reliability: setup   ## docs/reliability.md, from the suite itself
	mkdir -p $(OUT)
	PDDECONT_KILLS=200 PDDECONT_ACCURACIES=200 PDDECONT_MODELS=$(MODELS) OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile --reliability $(OUT)/reliability.json
	$(BIN)/python -m tests.reliability $(OUT)/reliability.json docs/reliability.md $(wildcard $(OUT)/random_models/trials.jsonl)

random-models: setup ## MODELS random models from seed FIRST on; `make reliability` counts them too
	mkdir -p $(OUT)/random_models
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.random_models $(FIRST) $(MODELS) $(OUT)/random_models

random-delays: setup ## 200 random models with delays that vary, rates and integrals of the past, from seed FIRST on
	mkdir -p $(OUT)/random_delays
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.random_delays $(FIRST) 200 $(OUT)/random_delays

stress: setup        ## a million random events against exact solutions; minutes
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest tests/simulate/test_random_events.py

packages: setup      ## source archive and wheels for the oldest and newest Python, each tried in an environment of its own
	$(BIN)/cffconvert --validate -i CITATION.cff
	$(BIN)/python .ci/packages.py $(OUT)/packages

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

bench: setup         ## ratios, each measured in one process
	$(BIN)/python -m pip install --quiet -e ".[bench]"
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.run
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.continuation
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.equilibria
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.delays
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.simulator
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.effects
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.explore
	$(MAKE) estimates
	$(MAKE) versions

estimates: setup     ## recorded error estimates against true errors, of every orbit of every shipped run
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.estimates

versions: setup      ## branches of this version and of BEFORE in turns; LARGE=--large adds 100 and 200 states
	rm -rf $(OUT)/before
	mkdir -p $(OUT)/before/source
	git archive $(BEFORE) | tar -x -C $(OUT)/before/source
	$(PYTHON) -m venv $(OUT)/before/env
	$(OUT)/before/env/bin/python -m pip install --quiet $(OUT)/before/source
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.versions $(OUT)/before/env/bin/python $(LARGE)

cost: setup          ## what accuracy costs: every method, degree and mesh; a picture in out/
	mkdir -p $(OUT)
	OPENBLAS_NUM_THREADS=1 $(BIN)/pddecont run configs/cost_of_accuracy.yaml -o $(OUT)/cost.h5 --overwrite
	$(BIN)/pddecont info $(OUT)/cost.h5
	$(BIN)/pddecont plot $(OUT)/cost.h5 --step orbits -o $(OUT)/cost_of_accuracy.png
	$(BIN)/pddecont plot $(OUT)/cost.h5 --step runs -o $(OUT)/cost_of_simulations.png

tracking: setup      ## error with and without tracked breaking points: table, and a picture in out/
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.tracking $(OUT)

chain-order: setup   ## grazing by chains of several orders against the delay equation
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.chain_order

reference: setup     ## pages of docs/reference from the schemas and the commands
	$(BIN)/python docs/generate.py

layers: setup        ## the picture in docs/architecture.md of which folder imports which
	$(BIN)/python docs/layers.py

images: figures cost  ## the pictures in docs/images that commands draw
	$(BIN)/python docs/draw_images.py $(FIGURES) $(OUT)

SECONDS := 60
atlas: setup         ## every shipped model explored, SECONDS each; results in out/atlas, the gallery in docs/atlas.md
	$(BIN)/python docs/atlas.py $(OUT)/atlas --seconds $(SECONDS) --docs

docs: setup          ## the pages of docs/ as a site in out/site; warnings are errors
	$(BIN)/python -m pip install --quiet -e ".[docs]"
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet --site-dir $(OUT)/site

include docs/figures.mk

schema: setup        ## JSON Schemas of both file formats, for editors
	$(BIN)/python -m pddecont.steps.json_schema pddecont/data

clean:               ## all that was computed, and caches; the environment stays
	rm -rf $(OUT) .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -path ./$(ENV) -prune -o -type d -name __pycache__ -prune -exec rm -rf {} +

distclean: clean     ## the environment too
	rm -rf $(ENV)
