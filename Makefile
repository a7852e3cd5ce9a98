PYTHON ?= python3
BIN := .venv/bin
export OMP_NUM_THREADS ?= 1

.PHONY: help setup demo test check search lint validation gallery bench clean distclean

help:
	@echo "make demo    set up all that is missing, simulate the damaged wheel, show picture and table"
	@echo "make test    set up all that is missing, run all tests"
	@echo "make check   lint, types and the fast tests"
	@echo "make search  the property tests alone, with many random examples"
	@echo "make validation  recompute docs/validation.md: half an hour the first time"
	@echo "make gallery     draw all shipped scenarios and what they do for docs/gallery.md: ten minutes"
	@echo "make bench   measure speed and memory, print tables, rewrite docs/performance.md: a quarter of an hour"
	@echo "make setup   set up only: .venv with ROS 2 Jazzy, messages and package"
	@echo "make clean   remove build products; make distclean removes .venv too"

setup:
	@$(PYTHON) tools/setup_env.py

demo: setup
	@$(BIN)/wheelset-track-sim demo

test:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m pytest -n 2 --dist worksteal

check: lint
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not slow and not ros" --hypothesis-profile quick

search:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "hypothesis" --hypothesis-profile search

validation:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m tools.validation

gallery:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m tools.gallery

bench:
	@$(PYTHON) tools/setup_env.py test bench
	@mkdir -p results
	$(BIN)/python -m pytest benchmarks -o python_files='bench_*.py' --benchmark-columns=min,median,rounds --benchmark-disable-gc \
		--benchmark-json=results/benchmarks.json -q $(ARGS)
	$(BIN)/python -m benchmarks.page

lint:
	@$(PYTHON) tools/setup_env.py test dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

clean:
	rm -rf build install log dist demo results *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find wheelset_track_sim tests tools -name __pycache__ -prune -exec rm -rf {} +

distclean: clean
	rm -rf .venv
