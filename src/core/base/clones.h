#ifndef SP_CLONES_H
#define SP_CLONES_H
/* Lets one binary use the vector units of the machine it runs on: a function marked CLONES is compiled for several
 * machines, and the right version is chosen at program start. All versions give the same bits because nothing is
 * contracted or reassociated. Sanitizers and clang do not support this. A build for one machine with AVX
 * (-march=native) needs no clones, and could not inline its functions into those for lesser machines. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&     \
    defined(__x86_64__) && !defined(__AVX__)
#define CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define CLONES
#endif

/* For functions that a clone calls: without inlining they would be compiled for the baseline machine only. */
#define ALWAYS_INLINE inline __attribute__((always_inline))

#endif
