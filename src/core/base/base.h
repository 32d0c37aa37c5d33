#ifndef SP_BASE_H
#define SP_BASE_H
/* Status and error text, checked allocation, clocks: the ground floor of every room. */

#include <sonopack/status.h>
#include <stddef.h>
#include <stdint.h>

/* Writes the reason into err (may be NULL) and returns status: `return sp_fail(err, SP_EINVAL, "...", ...)`. */
SP_SHARED sp_status sp_fail(sp_error *err, sp_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The same for a wrong value of a key: err->key is the key, and the text begins with it:
 * `sp_fail_key(err, SP_EINVAL, "packing.width", " = %g: must be ...", ...)`. */
SP_SHARED sp_status sp_fail_key(sp_error *err, sp_status status, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* Puts "prefix: " in front of a reason (where an outer function knows the file, say). */
SP_SHARED sp_status sp_fail_prefix(sp_error *err, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Puts "key: " in front, and makes it the key at fault: the user gave the wrong value through this key. */
SP_SHARED sp_status sp_fail_prefix_key(sp_error *err, const char *key);

/* Zeroed memory for count elements, aligned to 64 bytes; NULL on overflow or lack (count 0 gives one element). */
SP_SHARED void *sp_alloc(size_t count, size_t size);
SP_SHARED char *sp_strdup(const char *text); /* free with sp_free */
/* Test seam: the allocation after `count` more successful ones fails, once; < 0 switches it off. */
void sp_alloc_fail_after(int64_t count);
SP_SHARED sp_status sp_fail_memory(sp_error *err, size_t bytes);
/* Bytes that this process may hope for: the machine's memory, or a lower limit that is set (ulimit -v). What is asked
 * beyond it is not refused by malloc as a rule, but ends in swapping, or in being killed. */
SP_SHARED double sp_memory_limit(void);

/* The fewest digits (15 to 17) that read back as the same double; "nan", "inf", "-inf". */
enum { SP_NUMBER_TEXT = 32 };
SP_SHARED char *sp_number_text(double value, char text[SP_NUMBER_TEXT]);

SP_SHARED double sp_clock_cpu(void);  /* seconds of CPU time of this thread */
SP_SHARED double sp_clock_wall(void); /* seconds of a monotonic clock */

#endif
