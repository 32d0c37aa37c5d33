#ifndef SP_BASE_H
#define SP_BASE_H
/* Error reports, checked allocation, number text and clocks. Every other part of the library uses this header. */

#include <sonopack/status.h>
#include <stddef.h>
#include <stdint.h>

/* Stores the reason in err (may be NULL) and returns status: `return sp_fail(err, SP_EINVAL, "...", ...)`. */
SP_SHARED sp_status sp_fail(sp_error *err, sp_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* The same for a wrong value of a key. Sets err->key and begins the text with the key:
 * `sp_fail_key(err, SP_EINVAL, "packing.width", " = %g: must be ...", ...)`. */
SP_SHARED sp_status sp_fail_key(sp_error *err, sp_status status, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* Prepends "prefix: " to the reason in err, for example the file name that only the caller knows. Returns err's
 * status. */
SP_SHARED sp_status sp_fail_prefix(sp_error *err, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Prepends "key: " and sets err->key, for a wrong value that the user gave through this key. */
SP_SHARED sp_status sp_fail_prefix_key(sp_error *err, const char *key);

/* Allocates zeroed memory for count elements of size bytes, aligned to 64 bytes. A count of 0 gives one element.
 * Returns NULL if memory is short or the size overflows. Free it with sp_free. */
SP_SHARED void *sp_alloc(size_t count, size_t size);
/* Makes sure that a growing array has at least `need` elements. Returns `array` itself if *capacity is large enough.
 * Otherwise copies it to a new array of at least twice the capacity, with the new elements zeroed, frees the old one
 * and updates *capacity. `array` may be NULL with *capacity = 0. Returns NULL if memory is short; `array` and *capacity
 * are then unchanged. */
SP_SHARED void *sp_grow(void *array, size_t need, size_t *capacity, size_t size);
SP_SHARED char *sp_strdup(const char *text); /* free with sp_free */
/* For tests: lets `count` more allocations succeed and then fails one. A negative count disables this. */
void sp_alloc_fail_after(int64_t count);
/* Control characters, of names and of hostile files, become blanks, but those of `but`: no terminal obeys the text. */
SP_SHARED void sp_text_tame(char *text, const char *but);
SP_SHARED sp_status sp_fail_memory(sp_error *err, size_t bytes);
/* Memory available to this process in bytes: the machine's memory or a lower limit set by ulimit -v. An allocation
 * beyond it usually succeeds at first; the process then swaps or is killed. */
SP_SHARED double sp_memory_limit(void);

/* Writes the fewest digits (15 to 17) that read back as the same double; or "nan", "inf", "-inf". Returns text. */
enum { SP_NUMBER_TEXT = 32 };
SP_SHARED char *sp_number_text(double value, char text[SP_NUMBER_TEXT]);
/* The same as people write it: 1e-6 where printf writes 1e-06. For messages and help. */
SP_SHARED char *sp_number_plain(double value, char text[SP_NUMBER_TEXT]);

SP_SHARED double sp_clock_cpu(void);  /* CPU time of this thread [s] */
SP_SHARED double sp_clock_wall(void); /* monotonic clock [s] */

#endif
