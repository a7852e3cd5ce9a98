PYTHON ?= python3
BIN := .venv/bin
export OMP_NUM_THREADS ?= 1

.PHONY: help setup demo test check search fuzz endurance lint docs validation gallery bench clean distclean

help:
	@echo "make demo        set up if needed, simulate the damaged wheel, show a picture and a table"
	@echo "make setup       set up .venv: ROS 2 Jazzy, the messages and the package"
	@echo "make check       run lint, types and the fast tests: under a minute"
	@echo "make test        set up if needed, run all tests"
	@echo "make lint        set up if needed, run ruff and mypy"
	@echo "make search      run the property tests with thousands of random examples"
	@echo "make fuzz        read ten thousand mutants of every kind of input: an hour"
	@echo "make endurance   let three clients ask a running node for anything at random: ten minutes"
	@echo "make docs        build the documentation as a site with search: build/site/index.html"
	@echo "make validation  recompute docs/validation.md: half an hour the first time"
	@echo "make gallery     redraw docs/gallery.md with every shipped scenario: ten minutes"
	@echo "make bench       measure speed and memory, rewrite docs/performance.md: a quarter of an hour"
	@echo "make clean       remove build products and caches of tools"
	@echo "make distclean   remove .venv as well"

setup:
	@$(PYTHON) tools/setup_env.py

demo: setup
	@$(BIN)/wheelset-track-sim demo

test:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m pytest -n 2 --dist worksteal

check: lint
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not slow" --hypothesis-profile quick

search:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "hypothesis" --hypothesis-profile search

fuzz:
	@$(PYTHON) tools/setup_env.py test
	$(BIN)/python -m pytest -n 2 --dist worksteal tests/fuzz --hypothesis-profile fuzz $(ARGS)

endurance: SECONDS ?= 600
endurance:
	@$(PYTHON) tools/setup_env.py test
	WHEELSET_TRACK_SIM_ENDURANCE=$(SECONDS) $(BIN)/python -m pytest -s tests/ros/test_three_clients.py

docs:
	@$(PYTHON) tools/setup_env.py docs
	$(BIN)/python -m sphinx --builder html --fail-on-warning --keep-going --quiet --conf-dir docs . build/site

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
