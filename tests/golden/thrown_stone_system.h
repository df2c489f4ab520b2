/* thrown_stone_system.h
 *
 * The model as pkgen's runtime takes it: thrown_stone.h includes this with -DPK_RUNTIME.
 *
 * SPDX-License-Identifier: MIT-0
 */
#ifndef thrown_stone_SYSTEM_H
#define thrown_stone_SYSTEM_H

#include <pk/system.h>

#ifdef __cplusplus
extern "C" {
#endif

extern const struct pk_system thrown_stone_system;

#ifdef __cplusplus
}
#endif

#endif
