# Everything a newcomer needs; .ci/run calls the same targets.
PYTHON ?= python3
ENV := .venv
BIN := $(ENV)/bin
OUT := out

.PHONY: setup demo test reliability check bench tracking chain-order schema clean
setup: $(ENV)/ready

$(ENV)/ready: pyproject.toml
	$(PYTHON) -m venv $(ENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -e ".[dev]"
	touch $@

demo: setup          ## figure 4.6 of the paper, from its YAML file to a picture
	mkdir -p $(OUT)
	$(BIN)/pddecont run configs/fig4_6.yaml -o $(OUT)/fig4_6.h5 --overwrite
	$(BIN)/pddecont export $(OUT)/fig4_6.h5 --table special
	$(BIN)/pddecont plot $(OUT)/fig4_6.h5 -o $(OUT)/fig4_6.png

test: setup
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile

reliability: setup   ## what CI does of faults and hostile input in part, whole: 200 kills of each kind of run
	PDDECONT_KILLS=200 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 tests/faults tests/hostile tests/batch

check: setup
	$(BIN)/ruff check .
	$(BIN)/mypy

bench: setup         ## ratios, each measured in one process
	$(BIN)/python -m pip install --quiet -e ".[bench]"
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.run
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.simulator

tracking: setup      ## error with and without tracked breaking points: table, and a picture in out/
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.tracking $(OUT)

chain-order: setup   ## grazing by chains of several orders against the delay equation
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks.chain_order

schema: setup        ## JSON Schemas of both file formats, for editors
	$(BIN)/python -m pddecont.shipped.schemas

clean:
	rm -rf $(ENV) $(OUT)
