/* Includes the whole runtime: systems, methods, integrators, drifts. */
#ifndef PK_PK_H
#define PK_PK_H

#include <pk/subsystems.h>
#include <pk/condition.h>
#include <pk/constraint.h>
#include <pk/diagnostics.h>
#include <pk/ensemble.h>
#include <pk/events.h>
#include <pk/integrator.h>
#include <pk/keep.h>
#include <pk/linear.h>
#include <pk/limits.h>
#include <pk/method.h>
#include <pk/methods.h>
#include <pk/real.h>
#include <pk/act.h>
#include <pk/sample.h>
#include <pk/status.h>
#include <pk/system.h>

#endif
