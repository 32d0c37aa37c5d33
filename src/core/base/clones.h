#ifndef SP_CLONES_H
#define SP_CLONES_H
/* One binary that uses the vector units of the machine it runs on: functions marked CLONES are compiled for several and
 * chosen when the program starts. The bits do not depend on it, as nothing is contracted or reassociated. Sanitizers
 * and clang cannot resolve the clones. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&     \
    defined(__x86_64__)
#define CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define CLONES
#endif

/* What a clone calls: a function that is not inlined would be there for the plainest machine only. */
#define ALWAYS_INLINE inline __attribute__((always_inline))

#endif
