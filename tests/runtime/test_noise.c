/* Philox4x32-10 against the known answers of its authors, and that normal numbers are functions of
 * seed, member, step and index. */
#include <pk/noise.h>

#include "fixture.h"

TEST("Philox4x32-10 has its known answers")
{
    static const struct {
        uint32_t counter[4], key[2], answer[4];
    } known[] = {
        {{0}, {0}, {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
        {{~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}, {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
        {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
         {0xa4093822, 0x299f31d0},
         {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        uint32_t x[4];
        memcpy(x, known[k].counter, sizeof x);
        pk_philox(x, known[k].key[0], known[k].key[1]);
        CU_ASSERT(memcmp(x, known[k].answer, sizeof x) == 0);
    }
}

TEST("each seed, member, step and index has a normal number of its own")
{
    double z[7], other[7];
    pk_normal(1, 2, 3, 7, z);
    pk_normal(1, 2, 3, 4, other);
    CU_ASSERT(memcmp(z, other, 4 * sizeof *z) == 0);
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < i; j++)
            CU_ASSERT(z[i] < z[j] || z[i] > z[j]);
    const uint64_t big = (uint64_t)1 << 40;
    const uint64_t each[][3] = {{2, 2, 3},       {1, 3, 3},       {1, 2, 4},
                                {1, 2 + big, 3}, {1, 2, 3 + big}, {1 + big, 2, 3}};
    for (size_t k = 0; k < sizeof each / sizeof *each; k++) {
        pk_normal(each[k][0], each[k][1], each[k][2], 7, other);
        CU_ASSERT(other[0] < z[0] || other[0] > z[0]);
    }
}
