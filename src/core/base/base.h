#ifndef SP_BASE_H
#define SP_BASE_H
/* Error reports, checked allocation, number text, hashes and clocks. Every other part of the library uses this header.
 */

#include <locale.h>
#include <sonopack/status.h>
#include <sonopack/visibility.h>
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
/* The same without zeroing, for large arrays that are written before they are read: what is never touched takes no
 * memory. */
SP_SHARED void *sp_alloc_bare(size_t count, size_t size);
/* Makes sure that a growing array has at least `need` elements. Returns `array` itself if *capacity is large enough.
 * Otherwise copies it to a new array of at least twice the capacity, with the new elements zeroed, frees the old one
 * and updates *capacity. `array` may be NULL with *capacity = 0. Returns NULL if memory is short; `array` and *capacity
 * are then unchanged. */
SP_SHARED void *sp_grow(void *array, size_t need, size_t *capacity, size_t size);
/* The same for an array that grows by one element at a time and does not store its capacity: makes sure that there is
 * room for one more than `count`, by doubling at 0 and at powers of two. The array must have grown by this function
 * only. */
static inline void *sp_array_reserve(void *array, size_t count, size_t size) {
    size_t capacity = count;
    return (count & (count - 1)) != 0 ? array : sp_grow(array, count + 1, &capacity, size);
}
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

/* Numbers always have a decimal point, whatever locale the program has set: between enter and leave this thread uses
 * the "C" locale. */
typedef struct sp_locale {
    locale_t plain, before;
} sp_locale;
SP_SHARED sp_locale sp_locale_enter(void);
SP_SHARED void sp_locale_leave(sp_locale *l);

SP_SHARED double sp_clock_cpu(void);  /* CPU time of this thread [s] */
SP_SHARED double sp_clock_wall(void); /* monotonic clock [s] */

/* Hashes that detect accidental changes of data (64-bit FNV-1a; Fowler, Noll, Vo, Eastlake). */

/* initial value of a hash */
#define SP_HASH64_BEGIN 0xcbf29ce484222325u

/* Continues `hash` over `size` bytes. */
SP_SHARED uint64_t sp_hash64(uint64_t hash, const void *data, size_t size);

/* Continues `hash` eight bytes at a time. This is faster than sp_hash64 and gives another value. The last word is
 * padded with zeros, so the result depends on how the data are split over calls. */
uint64_t sp_hash64_words(uint64_t hash, const void *data, size_t size);

#endif
