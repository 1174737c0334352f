# Everything Habilis does from a clone: `make test`, `make paper`. The first call sets up .venv.
PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/installed
APART := .venv-integration
OLDEST := .venv-oldest

.PHONY: test test-slow test-long test-all test-studio test-studies test-integration test-oldest paper quick multiverse studies check format docs calibrate pace reconstruct readings tools survey \
	bench bench-sb3 performance pushing page protocol studio-picture clean sbom

# The whole product, on all processors, the tests of a file together: four minutes on two cores.
test: $(INSTALLED)
	$(BIN)/python -m pytest -n auto --dist loadfile -m "not slow and not long"

# What takes longer: packages built and installed, pages, a browser, a cluster, kills, studies.
test-slow: $(INSTALLED)
	$(BIN)/python -m pytest -n auto --dist loadfile -m slow

# Further variants of what the slow tests prove, before a release. Half an hour.
test-long: $(INSTALLED)
	$(BIN)/python -m pytest -n auto --dist loadfile -m long

test-all: test test-slow test-long test-integration test-oldest

# The studio alone, its page in Debian's Chromium (apt-get install chromium), and that its build is
# up to date.
test-studio: $(INSTALLED) studio/node_modules
	$(BIN)/python -m pytest tests/studio

# The three studies of `habilis study` from end to end, with next to no training: a minute.
test-studies: $(INSTALLED)
	$(BIN)/python -m pytest tests/studies/bonuses/test_studies.py

# With torch, Stable-Baselines3, gymnax and Storm, in an environment of their own.
test-integration: $(APART)/installed
	$(APART)/bin/python -m pytest tests/integration tests/envs/test_functional.py

# With the oldest version of each dependency that pyproject.toml admits, in an environment of their
# own. What they deprecate has been replaced since: warnings are no errors here.
test-oldest: $(OLDEST)/installed
	$(OLDEST)/bin/python -m pytest -n auto --dist loadfile -W default -m "not slow and not long" $(UNDER_TEST)
UNDER_TEST := tests/test_mdp.py tests/test_interpreted.py tests/test_from_gymnasium.py tests/analysis tests/bridges \
	tests/channels tests/cli tests/empowerment tests/envs tests/learning tests/models tests/sweeps tests/tasks tests/worlds \
	tests/studio/test_messages.py tests/studio/test_security.py

paper: $(INSTALLED)
	$(BIN)/habilis reproduce --out paper

quick: $(INSTALLED)
	$(BIN)/habilis reproduce --out paper-quick --quick

# The second part of the report: docs/multiverse. Under an hour; goes on where it was stopped.
multiverse: $(INSTALLED)
	$(BIN)/python -m research.multiverse --out docs/multiverse --work multiverse

# Learning to choose: docs/studies. A quarter of an hour; goes on where it was stopped.
studies: $(INSTALLED)
	$(BIN)/habilis study --out studies --resume
	mkdir -p docs/studies
	cp studies/report.html studies/*.svg studies/*.csv docs/studies/

# Formatting, lint and types.
check: $(INSTALLED)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/basedpyright

format: $(INSTALLED)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# The documentation: site/index.html. No network is asked for anything, here or when it is read.
docs: $(INSTALLED)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

# Chooses the A2C settings of the paper's tables anew, on the vanilla rows alone. Half an hour.
calibrate: $(INSTALLED)
	$(BIN)/python -m research.calibration

# The calibration at the paper's pace, its first stage: research/README.md has the others. Many hours
# on two processors; goes on where it was stopped.
pace: $(INSTALLED)
	$(BIN)/python -m research.pace.runs screen --out src/habilis/studies/data/pace/screen.csv

# Searches for the other maps in src/habilis/studies/data/maps anew: 12 of each kind, the later ones by
# lists that have more of what the paper states. An hour.
reconstruct: $(INSTALLED)
	$(BIN)/habilis reconstruct yard-apart --count 6 --out maps
	$(BIN)/habilis reconstruct yard --count 6 --after maps --out maps
	$(BIN)/habilis reconstruct corridor --count 8 --from corridor --hot 0.3 --out maps
	$(BIN)/habilis reconstruct corridor-all --count 4 --from corridor --hot 0.3 --after maps --out maps

# A search under each reading of the rules: research/results/readings.csv. Half an hour; goes on where it
# was stopped.
readings: $(INSTALLED)
	$(BIN)/python -m research.readings

# Whether object empowerment finds the tools of PushWorld's puzzles: research/tools_in_pushworld/results and
# docs/explanation/tools-in-pushworld.md. The puzzles are not ours: PUZZLES is a folder with puzzles/ and solutions/ of them.
# Half an hour; goes on where it was stopped.
PUZZLES ?= ../shared/pushworld
tools: $(INSTALLED)
	$(BIN)/python -m research.tools_in_pushworld --puzzles $(PUZZLES)

# Every small environment of Minigrid and toy-text, by ours and by a search of its own: the table in
# docs/explanation/is-it-right.md. An hour; goes on where it was stopped.
survey: $(INSTALLED)
	$(BIN)/python tests/support/survey.py docs/explanation/environments.csv

# The studio's page, built into the package from studio/. Needs Node; using it does not.
page: studio/node_modules
	npm --prefix studio run build

# The page's types of all messages, and their JSON Schema, from src/habilis/studio/protocol.
protocol: $(INSTALLED)
	PYTHONPATH=tests/support $(BIN)/python -m studio_protocol

studio/node_modules: studio/package-lock.json
	npm --prefix studio ci --silent
	touch $@

# The picture of the studio in README.md, taken in Debian's Chromium.
studio-picture: $(INSTALLED)
	PYTHONPATH=tests/support $(BIN)/python tests/support/studio_picture.py docs/studio.png

bench: $(INSTALLED)
	$(BIN)/habilis bench

# Every benchmark, for the page docs/explanation/performance.md. Half an hour.
performance: $(INSTALLED) $(APART)/installed
	$(BIN)/python -m research.performance

# Beside Stable-Baselines3, in the environment of the integration tests.
bench-sb3: $(APART)/installed
	$(APART)/bin/habilis bench sb3

# How a robot learns to push, with Stable-Baselines3: a quarter of an hour; goes on where it stopped.
pushing: $(APART)/installed
	$(APART)/bin/python -m research.pushing
	$(APART)/bin/python -m research.pushing figures

# torch, Stable-Baselines3 and gymnax are no dependencies of ours, and heavy; so is Storm.
$(APART)/installed: pyproject.toml constraints-integration.txt
	$(PYTHON) -m venv $(APART)
	$(APART)/bin/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints-integration.txt torch==2.13.0
	$(APART)/bin/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints-integration.txt \
		stable-baselines3==2.9.2 gymnax==1.0.1 six pytest beartype --editable ".[learn,gymnasium,robots,storm]"
	touch $@

# uv resolves to the oldest versions; the tools of the tests are those of constraints.txt.
$(OLDEST)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(OLDEST)
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check uv
	grep -E '^(beartype|hypothesis|minigrid|pytest|pytest-xdist)==' constraints.txt > $(OLDEST)/tools.txt
	$(OLDEST)/bin/uv pip install --quiet --python $(OLDEST)/bin/python --resolution lowest-direct \
		--requirement $(OLDEST)/tools.txt --editable ".[learn,gymnasium,robots,sweep,studio,video]"
	touch $@

$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11))" || \
		{ echo "Habilis needs Python 3.11 or newer; call make PYTHON=python3.12, say"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints.txt --editable ".[learn,gymnasium,robots,sweep,studio,video,docs,dev]"
	touch $@

# Every package that Habilis and its extras install, with its licence: sbom.cdx.json, a part of the wheel.
# Two minutes.
RUNTIME := learn,gymnasium,robots,sweep,studio,storm,video
sbom: $(INSTALLED)
	rm -rf .venv-sbom
	$(PYTHON) -m venv .venv-sbom/runtime
	$(PYTHON) -m venv .venv-sbom/tool
	.venv-sbom/runtime/bin/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints.txt ".[$(RUNTIME)]"
	.venv-sbom/tool/bin/python -m pip install --quiet --disable-pip-version-check cyclonedx-bom==7.5.0
	.venv-sbom/tool/bin/cyclonedx-py environment --output-reproducible --pyproject pyproject.toml \
		--mc-type library .venv-sbom/runtime/bin/python | $(BIN)/python tests/support/sbom.py
	rm -rf .venv-sbom

clean:
	rm -rf .venv .venv-sbom $(APART) paper paper-quick site
