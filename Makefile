# Each target sets up what it needs from nothing, into .venv of this checkout; a second call does
# not set up again. Prebuilt wheels only, no compiler, no root: the one source that is built is
# antlr4-python3-runtime, which has no wheel and is pure Python.

export PATH := $(CURDIR)/.venv/bin:$(PATH)
PYTHONS = python3.12 python3 python "$$(uv python find --no-python-downloads 3.12 2>&1)"
IS_3_12 = -c 'import sys; sys.exit(sys.version_info[:2] != (3, 12))'
WHEELS = --only-binary :all: --no-binary antlr4-python3-runtime

.PHONY: repro demo experiment test lint bench

repro: .venv/.ready
	dvc repro runs && dvc repro

# A lap by the safe strategy, with the policies in git: a film of the supervised pair beside that of
# the last iteration, and a file for Rerun of the former.
SUPERVISED = examples/demo/primary_0 examples/demo/safety_0
LAST = examples/demo/primary_3 examples/demo/safety_3
LAP = --tracks yew --traffic 12 --laps 1 --seconds 120 --strategy safe --seed 1
demo: .venv/.ready
	@rm -f demo.gif demo.rrd
	safedagger film $(SUPERVISED) --beside $(LAST) $(LAP) --show-every 4 --output demo.gif
	safedagger watch $(SUPERVISED) $(LAP) --save demo.rrd

# The comparison on one seed, e.g. `make experiment SEED=1`: all strategies beside each other.
SEED = 0
SCALE = experiment
experiment: .venv/.ready
	@scales/run '$(SCALE)' '$(SEED)'

test: .venv/.metaworld
	pytest -n logical --maxprocesses 4 --dist loadfile

lint: .venv/.metaworld
	ruff format --check .
	ruff check .
	mypy

# How fast each part is beside its floor, into docs/benchmarks.md.
bench: .venv/.bench
	python -m benchmarks

.venv/.ready: requirements.lock pyproject.toml plugin/pyproject.toml | .venv/bin/uv
	@echo "Installing into .venv: about a minute, and 7 GB"
	@uv pip install --quiet --python .venv/bin/python --compile-bytecode $(WHEELS) -r requirements.lock
	@uv pip install --quiet --python .venv/bin/python --no-deps --editable . --editable plugin
	@touch $@

# What only tests need, and whoever drives the robot arm.
.venv/.metaworld: requirements-metaworld.lock .venv/.ready
	@uv pip install --quiet --python .venv/bin/python --compile-bytecode $(WHEELS) -r $<
	@touch $@

# What only benchmarks need, to compare with.
.venv/.bench: pyproject.toml .venv/.ready
	@uv pip install --quiet --python .venv/bin/python --compile-bytecode $(WHEELS) \
	    --constraint requirements.lock --requirements pyproject.toml --extra bench
	@touch $@

# Any python that really is a 3.12: a pyenv shim may be on the path and yet fail.
.venv/bin/uv:
	@for python in $(PYTHONS); do \
	    if "$$python" $(IS_3_12) 2> /dev/null; then found="$$python"; break; fi; done; \
	if [ -z "$$found" ]; then \
	    echo "Python 3.12 is missing: install python3.12 and python3.12-venv" >&2; exit 1; fi; \
	"$$found" -m venv --clear .venv > /dev/null 2>&1 || { \
	    echo "$$found cannot make an environment: install python3.12-venv" >&2; exit 1; }
	@.venv/bin/python -m pip install --quiet --disable-pip-version-check --only-binary :all: \
	    --constraint requirements.lock uv
