/* Hand-written systems with a kernel `linear`, written out from their equations of motion. */
#ifndef TEST_LINEAR_SYSTEMS_H
#define TEST_LINEAR_SYSTEMS_H

#include "systems.h"

struct pk_system linear_double_pendulum(void);
struct pk_system linear_pendulum(void);
struct pk_system linear_oscillator(void);
struct pk_system linear_relativistic(void);

#endif
