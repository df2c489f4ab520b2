# The runtime: libraries, tests. Included from the top Makefile, or alone from the repository's
# root: make -f tests/runtime/runtime.mk test-runtime
CC ?= cc
BUILD ?= build
RT_WARN = -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
RT_CFLAGS = -fPIC -fvisibility=hidden -std=c11 -O2 -ffp-contract=off $(RT_WARN) -Iruntime/include $(RT_EXTRA)
# Of what is compiled for tests alone, whose results are compared.
RT_TEST_CFLAGS = $(subst -O2,-O1,$(RT_CFLAGS))
RT_DIR = $(BUILD)/runtime$(RT_SUFFIX)
RT_TESTS = $(BUILD)/tests$(RT_SUFFIX)

RT_HEADERS = $(wildcard runtime/include/pk/*.h runtime/include/pk/step/*.h \
             runtime/src/*/*.h runtime/gsl/*.h runtime/run/*.h runtime/run/*/*.h tests/runtime/*.h)
RT_CORE = $(patsubst runtime/src/%.c,$(RT_DIR)/src/%.o,$(sort $(wildcard runtime/src/*.c runtime/src/*/*.c)))
RT_GSL = $(patsubst runtime/gsl/%.c,$(RT_DIR)/gsl/%.o,$(sort $(wildcard runtime/gsl/*.c)))
# The one part with OpenMP, where the compiler has it.
RT_OPENMP := $(shell echo 'int main(void) { return 0; }' | \
               $(CC) -fopenmp -x c - -o /dev/null 2>/dev/null && echo -fopenmp)
RT_OMP = $(RT_DIR)/libpk_omp.a
RT_TEST_C = $(sort $(wildcard tests/runtime/*.c))
RT_TEST_O = $(patsubst tests/runtime/%.c,$(RT_TESTS)/%.o,$(RT_TEST_C))
RT_SYSTEMS_C = $(sort $(wildcard tests/runtime/systems_*.c))
RT_INLINE = -DPK_INLINE_ERK -DPK_INLINE_EMBEDDED -DPK_INLINE_SPLITTING -DPK_INLINE_GAUSS \
            -DPK_INLINE_ENSEMBLE
RT_SYSTEMS_INLINED = $(patsubst tests/runtime/%.c,$(RT_TESTS)/inlined/%.o,$(RT_SYSTEMS_C))
RT_SYSTEMS = $(patsubst tests/runtime/%.c,$(RT_TESTS)/%.o,$(RT_SYSTEMS_C))

.PHONY: runtime test-runtime-programs test-runtime asan-runtime

runtime: $(RT_DIR)/libpk.a $(RT_DIR)/libpk_gsl.a $(RT_OMP) $(RT_DIR)/libpk.so $(RT_DIR)/libpk_gsl.so

$(RT_DIR)/libpk.a: $(RT_CORE)
	rm -f $@ && ar rcsD $@ $^
$(RT_DIR)/libpk_gsl.a: $(RT_GSL)
	rm -f $@ && ar rcsD $@ $^
# The same as shared libraries, the core without GSL.
$(RT_DIR)/libpk.so: $(RT_CORE)
	$(CC) $(RT_EXTRA) -shared -Wl,-soname,libpk.so $^ -lm -o $@
$(RT_DIR)/libpk_gsl.so: $(RT_GSL) $(RT_DIR)/libpk.so
	$(CC) $(RT_EXTRA) -shared -Wl,-soname,libpk_gsl.so -Wl,-z,defs $^ -lgsl -lgslcblas -lm -o $@
$(RT_DIR)/libpk_omp.a: runtime/omp/threads.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) $(RT_OPENMP) -c $< -o $(RT_DIR)/threads.o
	rm -f $@ && ar rcsD $@ $(RT_DIR)/threads.o
$(RT_DIR)/%.o: runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) -c $< -o $@
$(RT_TESTS)/%.o: tests/runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_TEST_CFLAGS) -Iruntime/src -c $< -o $@

$(RT_TESTS)/runtime: $(RT_TEST_O) $(RT_TESTS)/librun.a $(RT_OMP) $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a
	$(CC) $(RT_EXTRA) $(RT_OPENMP) $^ -lcunit -lgsl -lgslcblas -lm -o $@

# The same tests over steps that are compiled together with their systems.
$(RT_TESTS)/inlined/%.o: tests/runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_TEST_CFLAGS) $(RT_INLINE) -c $< -o $@
$(RT_TESTS)/runtime_inlined: $(filter-out $(RT_SYSTEMS),$(RT_TEST_O)) $(RT_SYSTEMS_INLINED) \
                             $(RT_TESTS)/librun.a $(RT_OMP) $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a
	$(CC) $(RT_EXTRA) $(RT_OPENMP) $^ -lcunit -lgsl -lgslcblas -lm -o $@

# The layer of runs around a hand-written system, for its own tests.
RT_RUN_CFLAGS = $(RT_TEST_CFLAGS) -DPK_WITH_GSL -DRUN_BATCH_BYTES=4096 -Itests/runtime
RT_RUN = $(patsubst runtime/run/%.c,$(RT_TESTS)/run/%.o,$(sort $(wildcard runtime/run/*.c runtime/run/*/*.c)))
RT_PYTHON ?= .venv/bin/python
comma = ,
.SECONDARY: $(RT_RUN)
$(RT_TESTS)/run/%.o: runtime/run/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_RUN_CFLAGS) -c $< -o $@
$(RT_TESTS)/librun.a: $(RT_RUN)
	rm -f $@ && ar rcsD $@ $^
$(RT_TESTS)/run_%.so: $(RT_RUN) $(RT_SYSTEMS) $(RT_OMP) $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a
	printf '#include "run_model.h"\n%s\n%s\n' \
	    'extern const struct pk_run_model pk_model; const struct pk_run_model pk_model =' \
	    'RUN_MODEL($*_system, $(if $(filter pair,$*),pair_parts$(comma) 2,NULL$(comma) 0));' >$@.c
	$(CC) $(RT_RUN_CFLAGS) -fvisibility=default -shared $@.c $^ $(RT_OPENMP) -lgsl -lgslcblas -lm -o $@

# The program in runtime/README.md, on the hand-written double pendulum in the model's place.
$(RT_TESTS)/example: runtime/README.md $(RT_SYSTEMS) $(RT_DIR)/libpk.a
	@mkdir -p $(RT_TESTS)/example.d
	sed -n '/^```c/,/^```$$/p' $< | sed '/^```/d' >$(RT_TESTS)/example.d/example.c
	printf '#include "systems.h"\n#define double_pendulum_params test_params\n' \
	    >$(RT_TESTS)/example.d/double_pendulum.h
	$(CC) $(RT_CFLAGS) -Itests/runtime -I$(RT_TESTS)/example.d $(RT_TESTS)/example.d/example.c \
	    $(RT_SYSTEMS) $(RT_DIR)/libpk.a -lm -o $@

# Order of the methods of order 6 and more in __float128, where round-off is far away. The systems
# alone are compiled twice: around function pointers, and with the steps inlined.
RT_QUAD_FLAGS = -std=gnu11 -O1 -Wall -Wextra -Wshadow -Werror -DPK_FLOAT128 -Iruntime/include \
                -Iruntime/src -Itests/runtime $(RT_EXTRA)
RT_QUAD = $(patsubst runtime/src/%.c,$(RT_TESTS)/quad.d/%.o,$(sort $(wildcard runtime/src/*.c runtime/src/*/*.c))) \
          $(RT_TESTS)/quad.d/order.o
RT_QUAD_SYSTEMS = $(patsubst tests/runtime/%.c,$(RT_TESTS)/quad.d/%.o,$(RT_SYSTEMS_C))
RT_QUAD_INLINED = $(patsubst tests/runtime/%.c,$(RT_TESTS)/quad.d/inlined/%.o,$(RT_SYSTEMS_C))
$(RT_TESTS)/quad.d/inlined/%.o: tests/runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	gcc $(RT_QUAD_FLAGS) $(RT_INLINE) -c $< -o $@
$(RT_TESTS)/quad.d/%.o: runtime/src/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	gcc $(RT_QUAD_FLAGS) -c $< -o $@
$(RT_TESTS)/quad.d/%.o: tests/runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	gcc $(RT_QUAD_FLAGS) -c $< -o $@
$(RT_TESTS)/quad.d/order.o: tests/runtime/quad/order.c $(RT_HEADERS)
	@mkdir -p $(@D)
	gcc $(RT_QUAD_FLAGS) -c $< -o $@
$(RT_TESTS)/quad: $(RT_QUAD) $(RT_QUAD_SYSTEMS)
	gcc $(RT_EXTRA) $^ -lquadmath -lm -o $@
$(RT_TESTS)/quad_inlined: $(RT_QUAD) $(RT_QUAD_INLINED)
	gcc $(RT_EXTRA) $^ -lquadmath -lm -o $@

RT_RUN_PROGRAMS = $(patsubst %,$(RT_TESTS)/run_%.so,pendulum broken oscillator turning pair)
RT_PROGRAMS = $(addprefix $(RT_TESTS)/,example quad runtime) \
              $(RT_RUN_PROGRAMS)
test-runtime-programs: $(RT_PROGRAMS)

# Each on its own, so that `make -j 2 -O` runs two at a time and prints each one's lines together.
RT_CHECKS = check-runtime check-runtime-quad check-runtime-example \
            check-runtime-driver check-runtime-symbols test-runtime-scalars
.PHONY: $(RT_CHECKS) check-runtime-inlined check-runtime-quad-inlined
test-runtime: $(RT_CHECKS)
check-runtime: $(RT_TESTS)/runtime
	@$< >$<.txt || { cat $<.txt; exit 1; }; tail -n 7 $<.txt
check-runtime-inlined: $(RT_TESTS)/runtime_inlined
	@$< inlined >$<.txt || { cat $<.txt; exit 1; }; tail -n 7 $<.txt
check-runtime-quad: $(RT_TESTS)/quad
	@$< >$<.txt || { grep -v ', measured' $<.txt; exit 1; }; tail -n 1 $<.txt
check-runtime-quad-inlined: $(RT_TESTS)/quad_inlined
	@$< >$<.txt || { grep -v ', measured' $<.txt; exit 1; }; tail -n 1 $<.txt
check-runtime-example: $(RT_TESTS)/example
	$< | grep -q '^t = 10: 1.018731427'
check-runtime-driver: $(RT_RUN_PROGRAMS)
	PYTHON=$(RT_PYTHON) sh tests/runtime/driver.sh $(RT_TESTS)

asan-runtime:
	$(MAKE) -f tests/runtime/runtime.mk RT_SUFFIX=-asan \
	    RT_EXTRA="-g -DDEEP=12 -fsanitize=address,undefined -fno-sanitize-recover=all" \
	    BUILD=$(BUILD) run-asan-runtime
.PHONY: run-asan-runtime
run-asan-runtime: $(RT_TESTS)/runtime $(RT_TESTS)/runtime_inlined $(RT_RUN_PROGRAMS)
	$(RT_TESTS)/runtime
	$(RT_TESTS)/runtime_inlined inlined
	PYTHON=$(RT_PYTHON) PRELOAD="$$($(CC) -print-file-name=libasan.so) $$($(CC) -print-file-name=libubsan.so)" \
	    sh tests/runtime/driver.sh $(RT_TESTS)

# What is read before it is written, by clang; left out where it lacks that. See test_memory.c.
RT_MSAN = -w -O1 -g -fsanitize=memory -fno-sanitize-recover=all
.PHONY: msan-runtime
msan-runtime:
	@echo 'int main(void) { return 0; }' | clang -fsanitize=memory -x c - -o /dev/null 2>/dev/null || \
	    { echo 'msan-runtime: left out: libclang-rt-dev is missing'; exit 0; } && \
	    $(MAKE) -f tests/runtime/runtime.mk RT_SUFFIX=-msan CC=clang RT_EXTRA="$(RT_MSAN)" \
	        BUILD=$(BUILD) run-msan-runtime
.PHONY: run-msan-runtime
run-msan-runtime: $(RT_TESTS)/runtime
	$< "" test_memory test_memory_blocks test_dense

# libFuzzer over the runtime; emitted C is linked with the same library (tests/fuzz).
RT_FUZZ = -w -O1 -g -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=all
FUZZ_SECONDS ?= 3600
.PHONY: fuzz-library fuzz-runtime run-fuzz-library run-fuzz-runtime
fuzz-library fuzz-runtime:
	@echo 'int main(void) { return 0; }' | clang -fsanitize=address -x c - -o /dev/null 2>/dev/null || \
	    { echo '$@: left out: libclang-rt-dev is missing'; exit 0; } && \
	    $(MAKE) -f tests/runtime/runtime.mk RT_SUFFIX=-fuzz CC=clang RT_EXTRA="$(RT_FUZZ)" \
	        BUILD=$(BUILD) FUZZ_SECONDS=$(FUZZ_SECONDS) run-$@
$(RT_TESTS)/fuzz: tests/fuzz/runtime.c $(RT_SYSTEMS) $(RT_DIR)/libpk.a
	$(CC) $(RT_CFLAGS) -fsanitize=fuzzer -Itests/runtime $^ -lm -o $@
run-fuzz-library: $(RT_DIR)/libpk.a
run-fuzz-runtime: $(RT_TESTS)/fuzz
	@mkdir -p $(BUILD)/fuzz/corpus
	$< -max_total_time=$(FUZZ_SECONDS) -max_len=256 -timeout=300 -print_final_stats=1 \
	    -artifact_prefix=$(BUILD)/fuzz/ $(BUILD)/fuzz/corpus tests/fuzz/corpus

# Every symbol that the core exports is pk_*; it neither allocates nor knows GSL, prints or exits.
check-runtime-symbols: $(RT_DIR)/libpk.a $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.so $(RT_DIR)/libpk_gsl.so
	sh tests/runtime/symbols.sh $(RT_DIR)

# The same source in the other scalar types (the quad programs are the fourth), headers as C99 and C++.
RT_SCALARS = $(foreach t,FLOAT LONG_DOUBLE,$(patsubst runtime/src/%.c,$(RT_DIR)/$(t)/%.o,\
               $(sort $(wildcard runtime/src/*.c runtime/src/*/*.c))))
$(RT_DIR)/FLOAT/%.o: runtime/src/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) -DPK_FLOAT -fsyntax-only $< && touch $@
$(RT_DIR)/LONG_DOUBLE/%.o: runtime/src/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) -DPK_LONG_DOUBLE -fsyntax-only $< && touch $@
test-runtime-scalars: $(RT_SCALARS)
	@echo '#include <pk/pk.h>' >$(RT_DIR)/header.c
	@echo '#include <pk/gsl.h>' >>$(RT_DIR)/header.c
	$(CC) -std=c99 $(RT_WARN) -Iruntime/include -c $(RT_DIR)/header.c -o $(RT_DIR)/header.o
	c++ -std=c++11 -Wall -Wextra -Wpedantic -Werror -Iruntime/include -x c++ -c \
	    $(RT_DIR)/header.c -o $(RT_DIR)/header.o
