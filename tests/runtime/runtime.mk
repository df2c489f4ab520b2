# The runtime: libraries, tests. Included from the top Makefile, or alone from the repository's
# root: make -f tests/runtime/runtime.mk test-runtime
CC ?= cc
BUILD ?= build
RT_WARN = -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
RT_CFLAGS = -std=c11 -O2 -ffp-contract=off $(RT_WARN) -Iruntime/include $(RT_EXTRA)
RT_DIR = $(BUILD)/runtime$(RT_SUFFIX)
RT_TESTS = $(BUILD)/tests$(RT_SUFFIX)

RT_HEADERS = $(wildcard runtime/include/pk/*.h runtime/include/pk/step/*.h \
             runtime/src/*.h runtime/run/*.h tests/runtime/*.h)
RT_CORE = $(patsubst runtime/src/%.c,$(RT_DIR)/src/%.o,$(sort $(wildcard runtime/src/*.c)))
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

.PHONY: runtime test-runtime-programs test-runtime asan-runtime check-runtime-symbols test-runtime-scalars

runtime: $(RT_DIR)/libpk.a $(RT_DIR)/libpk_gsl.a $(RT_OMP)

$(RT_DIR)/libpk.a: $(RT_CORE)
	rm -f $@ && ar rcsD $@ $^
$(RT_DIR)/libpk_gsl.a: $(RT_GSL)
	rm -f $@ && ar rcsD $@ $^
$(RT_DIR)/libpk_omp.a: runtime/omp/threads.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) $(RT_OPENMP) -c $< -o $(RT_DIR)/threads.o
	rm -f $@ && ar rcsD $@ $(RT_DIR)/threads.o
$(RT_DIR)/%.o: runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) -c $< -o $@
$(RT_TESTS)/%.o: tests/runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) -Iruntime/src -c $< -o $@

$(RT_TESTS)/runtime: $(RT_TEST_O) $(RT_OMP) $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a
	$(CC) $(RT_EXTRA) $(RT_OPENMP) $^ -lcunit -lgsl -lgslcblas -lm -o $@

# The same tests over steps that are compiled together with their systems.
$(RT_TESTS)/inlined/%.o: tests/runtime/%.c $(RT_HEADERS)
	@mkdir -p $(@D)
	$(CC) $(RT_CFLAGS) $(RT_INLINE) -c $< -o $@
$(RT_TESTS)/runtime_inlined: $(filter-out $(RT_SYSTEMS),$(RT_TEST_O)) $(RT_SYSTEMS_INLINED) \
                             $(RT_OMP) $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a
	$(CC) $(RT_EXTRA) $(RT_OPENMP) $^ -lcunit -lgsl -lgslcblas -lm -o $@

# The driver around a hand-written system, for its own tests.
$(RT_TESTS)/run_%: $(RT_SYSTEMS) $(RT_OMP) $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a \
                   $(wildcard runtime/run/*.c) $(RT_HEADERS)
	printf '#include "settings.h"\n#include "systems.h"\n%s\n' \
	    'const struct pk_system *const run_system = &$*_system;' >$@.c
	$(CC) $(RT_CFLAGS) -DPK_WITH_GSL -DRUN_BATCH_BYTES=4096 -Iruntime/run -Itests/runtime runtime/run/*.c $@.c \
	    $(RT_SYSTEMS) $(RT_OMP) $(RT_OPENMP) \
	    $(RT_DIR)/libpk_gsl.a $(RT_DIR)/libpk.a -lgsl -lgslcblas -lm -o $@

# The program in runtime/README.md, on the hand-written double pendulum in the model's place.
$(RT_TESTS)/example: runtime/README.md $(RT_SYSTEMS) $(RT_DIR)/libpk.a
	@mkdir -p $(RT_TESTS)/example.d
	sed -n '/^```c/,/^```$$/p' $< | sed '/^```/d' >$(RT_TESTS)/example.d/example.c
	printf '#include "systems.h"\n#define double_pendulum_params test_params\n' \
	    >$(RT_TESTS)/example.d/double_pendulum.h
	$(CC) $(RT_CFLAGS) -Itests/runtime -I$(RT_TESTS)/example.d $(RT_TESTS)/example.d/example.c \
	    $(RT_SYSTEMS) $(RT_DIR)/libpk.a -lm -o $@

# Order of the methods of order 6 and more in __float128, where round-off is far away.
$(RT_TESTS)/quad_inlined: RT_INSTANCE = $(RT_INLINE)
$(RT_TESTS)/quad $(RT_TESTS)/quad_inlined: $(wildcard runtime/src/*.c) $(RT_HEADERS) tests/runtime/quad/order.c \
                  $(RT_SYSTEMS_C)
	@mkdir -p $(@D)
	gcc -std=gnu11 -O2 -Wall -Wextra -Wshadow -Werror -DPK_FLOAT128 -Iruntime/include \
	    -Itests/runtime $(RT_EXTRA) $(RT_INSTANCE) runtime/src/*.c $(RT_SYSTEMS_C) \
	    tests/runtime/quad/order.c -lquadmath -lm -o $@

RT_PROGRAMS = $(addprefix $(RT_TESTS)/,example quad quad_inlined runtime runtime_inlined run_pendulum run_broken)
test-runtime-programs: $(RT_PROGRAMS)
test-runtime: $(RT_PROGRAMS) check-runtime-symbols test-runtime-scalars
	$(RT_TESTS)/runtime
	$(RT_TESTS)/runtime_inlined inlined
	$(RT_TESTS)/quad
	$(RT_TESTS)/quad_inlined
	$(RT_TESTS)/example | grep -q '^t = 10: 1.018731427'
	sh tests/runtime/driver.sh $(RT_TESTS)

asan-runtime:
	$(MAKE) -f tests/runtime/runtime.mk RT_SUFFIX=-asan \
	    RT_EXTRA="-g -fsanitize=address,undefined -fno-sanitize-recover=all" \
	    BUILD=$(BUILD) run-asan-runtime
.PHONY: run-asan-runtime
run-asan-runtime: $(RT_TESTS)/runtime $(RT_TESTS)/runtime_inlined $(RT_TESTS)/run_pendulum \
                  $(RT_TESTS)/run_broken
	$(RT_TESTS)/runtime
	$(RT_TESTS)/runtime_inlined inlined
	sh tests/runtime/driver.sh $(RT_TESTS)

# Every symbol that the core exports is pk_*; it neither allocates nor knows GSL, prints or exits.
check-runtime-symbols: $(RT_DIR)/libpk.a $(RT_DIR)/libpk_gsl.a
	sh tests/runtime/symbols.sh $(RT_DIR)/libpk.a $(RT_DIR)/libpk_gsl.a

# The same source in every scalar type, and headers as C99 and C++.
test-runtime-scalars:
	@mkdir -p $(RT_DIR)
	@for t in FLOAT LONG_DOUBLE; do for f in runtime/src/*.c; do \
	    $(CC) $(RT_CFLAGS) -DPK_$$t -c $$f -o $(RT_DIR)/scalar.o || exit 1; done; done
	@for f in runtime/src/*.c; do gcc -std=gnu11 -O2 -Wall -Wextra -Wshadow -Werror -DPK_FLOAT128 \
	    -Iruntime/include -c $$f -o $(RT_DIR)/scalar.o || exit 1; done
	@echo '#include <pk/pk.h>' >$(RT_DIR)/header.c
	@echo '#include <pk/gsl.h>' >>$(RT_DIR)/header.c
	$(CC) -std=c99 $(RT_WARN) -Iruntime/include -c $(RT_DIR)/header.c -o $(RT_DIR)/scalar.o
	c++ -std=c++11 -Wall -Wextra -Wpedantic -Werror -Iruntime/include -x c++ -c \
	    $(RT_DIR)/header.c -o $(RT_DIR)/scalar.o
