/* PK_BEGIN and PK_END enclose the functions that a header declares. They set C linkage, and export
 * the functions from a shared library, which is compiled with -fvisibility=hidden. */
#ifndef PK_BEGIN_H
#define PK_BEGIN_H

#if defined __GNUC__
#define PK_SHOW _Pragma("GCC visibility push(default)")
#define PK_SHOW_END _Pragma("GCC visibility pop")
#else
#define PK_SHOW
#define PK_SHOW_END
#endif

#ifdef __cplusplus
#define PK_BEGIN       \
    PK_SHOW extern "C" \
    {
#define PK_END \
    }          \
    PK_SHOW_END
#else
#define PK_BEGIN PK_SHOW
#define PK_END PK_SHOW_END
#endif

#endif
