# make demo    generate, compile and run the models; print the drift table
# make test    every test, under eight minutes (both set the machine up first)
# make chart   accuracy against cost, all methods on all models
# make bench   accuracy against cost, beside the peers

VENV   := .venv
PYTHON := $(VENV)/bin/python
PREFIX ?= /usr/local
ifeq ($(origin CC),default)
CC := gcc
endif

.PHONY: help setup demo fuzz asan durations test test-long test-each-addon test-licence test-python test-debian systems bodies published chart stability pictures bench site lint format golden install install-runtime install-shell wheel deb clean
.DEFAULT_GOAL := help

help:
	@echo 'make demo       generate, compile and run the models; print the drift table'
	@echo 'make test       every test, under eight minutes'
	@echo 'make test-long  what takes longer (SHARD=1/12: a twelfth of it)'
	@echo 'make test-debian  the generator on the python3 of Debian, half a minute'
	@echo 'make fuzz       an hour of mutated models and of libFuzzer (FUZZ_SECONDS=N)'
	@echo 'make systems    every scene of every model, what it expects and what was found (DOCS=1: into docs)'
	@echo 'make bodies     residuals and drifts of rotations, constraints, rolling (STEPS=N; DOCS=1: into docs)'
	@echo 'make published  problems that others publish, beside their references, two minutes (DOCS=1: into docs)'
	@echo 'make chart      accuracy against cost of all methods, five minutes'
	@echo 'make stability  where each method fails, three minutes'
	@echo 'make pictures   every picture of docs/, ten minutes (ONLY="kepler.png ...": some)'
	@echo 'make bench      speed beside the peers, 20 minutes (QUICK=1: a few; DOCS=1: into docs)'
	@echo 'make site       docs and models as pages, each model live: build/site/index.html'
	@echo 'make wheel      build/dist: the wheel, the same bytes each time, and what it holds and needs'
	@echo 'make deb        build/dist: the Debian package'
	@echo 'make setup lint format golden asan clean, make install PREFIX=DIR'

# What running needs; and what tests, pages, exports and checks need besides.
STAMP := $(VENV)/.setup-done
TESTS := $(VENV)/.tests-done
setup: $(STAMP)
$(STAMP): pyproject.toml tools/setup.sh
	@sh tools/setup.sh
	@touch $@
$(TESTS): $(STAMP)
	@sh tools/setup.sh tests
	@touch $@

include tests/runtime/runtime.mk

demo: $(STAMP)
	$(PYTHON) tools/demo.py

test: $(TESTS)
	@$(MAKE) -s -j 2 -O test-runtime
	@$(MAKE) -s test-licence test-python

test-licence: runtime
	@sh tools/check_licence.sh

# The core's tests run in a copy of the tree without addons/; the rest run here.
test-python: $(TESTS)
	$(PYTHON) tools/without_addons.py -- -q -n 2 --dist worksteal -m 'not long and not needs_addon' tests
	$(PYTHON) -m pytest -q -n 2 --dist worksteal -m 'not long and needs_addon' addons $$(grep -rl needs_addon tests)

# SHARD=K/N: the Kth of N parts that take as long; the C tests in quad precision belong to the first shard.
test-long: $(TESTS)
	@$(if $(filter-out 1/%,$(SHARD)),:,$(MAKE) -s check-runtime-inlined check-runtime-quad-inlined test-each-addon)
	$(PYTHON) -m pytest -q -n 2 --dist loadgroup -m long $(if $(SHARD),--shard $(SHARD))

# Hours: measures every test, whose times say which are quick and which shard has them.
durations: $(TESTS)
	rm -f tests/durations.json
	$(PYTHON) -m pytest -q -n 2 --dist loadgroup --junitxml=build/durations.xml
	$(PYTHON) tests/durations.py build/durations.xml
# Each add-on alone is deleted, and the rest passes.
test-each-addon: $(TESTS)
	$(PYTHON) tools/without_addons.py --each -- -q -m 'not long and needs_addon'

# The generator's tests on Debian's own python3, half a minute.
test-debian:
	@sh tools/test_debian.sh

systems: $(STAMP)
	$(PYTHON) -m bench systems $(if $(DOCS),--docs)

bodies: $(STAMP)
	$(PYTHON) -m bench bodies $(if $(STEPS),--steps $(STEPS)) $(if $(DOCS),--docs)

published: $(STAMP)
	$(PYTHON) -m bench published $(if $(DOCS),--docs)

stability chart: $(STAMP)
	@for model in models/*.lag; do $(PYTHON) -m pkgen $@ $$model -o build/$@ || exit 1; done

# Every picture of docs/, which tools/pictures has a table of; ONLY="kepler.png show.png" for some.
pictures: $(TESTS)
	@$(PYTHON) tools/pictures $(ONLY)

# The peers have a Python environment of their own, build/bench/venv.
BENCH_OPTIONS = $(if $(QUICK),--quick) $(if $(DOCS),--docs) $(if $(MODELS),--models $(MODELS))
bench: $(TESTS)
	@$(PYTHON) bench/environment.py
	@build/bench/venv/bin/python -m bench $(BENCH_OPTIONS)
	@build/bench/venv/bin/python -m bench arms $(if $(QUICK),--quick) $(if $(DOCS),--docs)

# docs/ and models/ as a site in build/site, which needs no server (docs/dev/site.md); three minutes.
site: $(TESTS)
	@$(PYTHON) -c 'import material' 2>/dev/null || $(PYTHON) -m pip install -q -e '.[site]'
	@$(PYTHON) tools/site/pages.py
	@NO_MKDOCS_2_WARNING=1 $(PYTHON) -m mkdocs build -q --strict -f build/site.yml
	@echo 'site: open build/site/index.html'

golden: $(TESTS)
	PKGEN_UPDATE=1 $(PYTHON) -m pytest -q tests/cli/test_method_names.py tests/generator/test_golden.py tests/generator/test_wrong_models.py tests/messages
	$(PYTHON) tools/errors_page.py
	$(PYTHON) tools/features.py > tests/features.txt
	$(PYTHON) tools/editors
	@git --no-pager diff --stat

# These are not among Debian's packages: where pkgen was installed from those, lint needs a registry.
PYTHON_CODE := generator tests tools bench
C_CODE = $(shell find runtime generator/pkgen/back/host addons/fmu/pkgen_fmu/c addons/web/pkgen_web tests/runtime tests/fuzz -name '*.[ch]')
CLANG_FORMAT = $(VENV)/bin/clang-format
lint: $(TESTS) runtime
	@$(PYTHON) -m ruff --version || { echo 'lint: no ruff here; pip install ruff'; exit 1; }
	$(PYTHON) -m ruff check $(PYTHON_CODE)
	$(PYTHON) -m ruff format --check $(PYTHON_CODE)
	$(CLANG_FORMAT) --dry-run -Werror $(C_CODE)
	$(PYTHON) -m mypy
	@sh tools/check_licence.sh

format: $(TESTS)
	$(PYTHON) -m ruff format $(PYTHON_CODE)
	$(PYTHON) -m ruff check --fix $(PYTHON_CODE)
	$(CLANG_FORMAT) -i $(C_CODE)

# Sanitizers: gcc's and clang's over the runtime, clang's over emitted C.
asan: $(TESTS) asan-runtime msan-runtime
	$(PYTHON) -m pytest -q -m '' tests/generator/test_sanitized.py

# An hour in all: the compiler by mutated models, the runtime by libFuzzer. See docs/dev/fuzzing.md.
FUZZ_SECONDS ?= 3600
fuzz: $(TESTS)
	$(PYTHON) tests/fuzz/models.py $$(($(FUZZ_SECONDS) / 2)) $(SEED)
	@$(MAKE) fuzz-runtime FUZZ_SECONDS=$$(($(FUZZ_SECONDS) / 2))

# PREFIX/bin/pkgen with a Python environment of its own, the runtime's headers and libraries, and
# what finds them: pkg-config's pk.pc, CMake's find_package(pk). What is built elsewhere: BUILT=DIR.
VERSION = $(shell sed -n 's/^__version__ = "\(.*\)"/\1/p' generator/pkgen/version.py)
BUILT ?= build/runtime
install: runtime install-runtime
	PKGEN_PREFIX=$(abspath $(PREFIX)) sh tools/setup.sh
	install -d $(PREFIX)/bin
	ln -sf ../lib/pkgen/bin/pkgen $(PREFIX)/bin/pkgen
	@$(MAKE) -s install-shell PREFIX=$(abspath $(PREFIX))

# Pages for man, and what shells complete, which needs shtab; where that is too old or missing, less.
PKGEN = $(PREFIX)/bin/pkgen
COMPLETIONS = bash:bash-completion/completions/pkgen zsh:zsh/site-functions/_pkgen fish:fish/vendor_completions.d/pkgen.fish
install-shell:
	$(PKGEN) manual -o $(PREFIX)/share/man/man1
	@for pair in $(COMPLETIONS); do \
	    file=$(PREFIX)/share/$${pair#*:}; mkdir -p "$${file%/*}"; \
	    $(PKGEN) completion $${pair%%:*} > "$$file" || rm -f "$$file"; \
	done
install-runtime:
	install -d $(PREFIX)/lib/pkgconfig $(PREFIX)/lib/cmake/pk $(PREFIX)/include/pk/step
	install -m 644 runtime/include/pk/*.h $(PREFIX)/include/pk/
	install -m 644 runtime/include/pk/step/*.h $(PREFIX)/include/pk/step/
	install -m 644 $(BUILT)/*.a $(PREFIX)/lib/
	sed 's|@VERSION@|$(VERSION)|' tools/install/pk.pc.in > $(PREFIX)/lib/pkgconfig/pk.pc
	install -m 644 tools/install/pkConfig.cmake $(PREFIX)/lib/cmake/pk/
	sed 's|@VERSION@|$(VERSION)|' tools/install/pkConfigVersion.cmake.in > $(PREFIX)/lib/cmake/pk/pkConfigVersion.cmake

wheel: $(TESTS)
	@$(PYTHON) tools/release

deb:
	@sh tools/release/deb.sh

clean:
	rm -rf build/* $(VENV) generator/*.egg-info *.egg-info
