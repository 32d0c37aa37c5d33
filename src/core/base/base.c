/* Status and error text, allocation, memory limit, number text and clocks. */
#include "base/base.h"

#include <math.h>
#include <sonopack/version.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

const char *sp_version(void) { return SONOPACK_VERSION; }

const char *sp_status_name(sp_status status) {
    switch (status) {
    case SP_OK: return "ok";
    case SP_EINVAL: return "invalid";
    case SP_EIO: return "i/o";
    case SP_EFORMAT: return "format";
    case SP_ENOMEM: return "memory";
    case SP_EFAILED: return "failed";
    case SP_EREFUSED: return "refused";
    case SP_EINTERRUPTED: return "interrupted";
    }
    return "unknown";
}

void sp_text_tame(char *text, const char *but) {
    for (unsigned char *c = (unsigned char *)text; *c; c++)
        if ((*c < ' ' || *c == 127) && !strchr(but, *c))
            *c = ' ';
        else if (*c == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0) /* U+0080 .. U+009F */
            c[0] = c[1] = ' ';
}

/* vsnprintf with a decimal point in every locale: reasons get into files. */
static void print_plain(char *text, size_t size, const char *format, va_list args) {
    sp_locale locale = sp_locale_enter();
    vsnprintf(text, size, format, args);
    sp_locale_leave(&locale);
}

/* The key at fault, then the reason. */
static void set_reason(sp_error *err, sp_status status, const char *key, const char *format, va_list args) {
    char reason[SP_ERROR_TEXT];
    print_plain(reason, sizeof reason, format, args);
    err->status = status;
    snprintf(err->key, sizeof err->key, "%s", key);
    const size_t used = strnlen(key, sizeof err->key - 1), rest = strnlen(reason, sizeof reason - used - 1);
    memcpy(err->text, err->key, used);
    memcpy(err->text + used, reason, rest);
    err->text[used + rest] = '\0';
    sp_text_tame(err->text, "");
}

sp_status sp_fail(sp_error *err, sp_status status, const char *format, ...) {
    if (err) {
        va_list args;
        va_start(args, format);
        set_reason(err, status, "", format, args);
        va_end(args);
    }
    return status;
}

sp_status sp_fail_key(sp_error *err, sp_status status, const char *key, const char *format, ...) {
    if (err) {
        va_list args;
        va_start(args, format);
        set_reason(err, status, key, format, args);
        va_end(args);
    }
    return status;
}

sp_status sp_fail_prefix(sp_error *err, const char *format, ...) {
    if (!err)
        return SP_EFAILED;
    char old[SP_ERROR_TEXT], prefix[SP_ERROR_TEXT / 2];
    va_list args;
    va_start(args, format);
    print_plain(prefix, sizeof prefix, format, args);
    va_end(args);
    memcpy(old, err->text, sizeof old);
    int used = snprintf(err->text, sizeof err->text, "%s: ", prefix);
    size_t room = sizeof err->text - (size_t)used;
    size_t length = strnlen(old, room - 1);
    memcpy(err->text + used, old, length);
    err->text[(size_t)used + length] = '\0';
    sp_text_tame(err->text, "");
    return err->status;
}

sp_status sp_fail_prefix_key(sp_error *err, const char *key) {
    if (err)
        snprintf(err->key, sizeof err->key, "%s", key);
    return sp_fail_prefix(err, "%s", key);
}

static atomic_int_fast64_t fail_after = -1;

void sp_alloc_fail_after(int64_t count) { atomic_store(&fail_after, count); }

/* Blocks of HUGE_FROM bytes or more use pages of 2 MiB where the system offers them. */
enum { HUGE_PAGE = 2 << 20, HUGE_FROM = 16 << 20 };

static void *allocate(size_t count, size_t size, bool zeroed) {
    if (atomic_load(&fail_after) >= 0 && atomic_fetch_sub(&fail_after, 1) == 0)
        return NULL;
    if (count == 0)
        count = 1;
    if (size == 0 || count > (PTRDIFF_MAX - 63) / size)
        return NULL;
    const size_t wanted = count * size, align = wanted >= HUGE_FROM ? HUGE_PAGE : 64;
    if (wanted > PTRDIFF_MAX - align)
        return NULL;
    const size_t bytes = (wanted + align - 1) / align * align;
    void *memory = aligned_alloc(align, bytes);
#ifdef MADV_HUGEPAGE
    if (memory && align == HUGE_PAGE)
        madvise(memory, bytes, MADV_HUGEPAGE); /* only a hint; it saves most of the page faults and address lookups */
#endif
    if (memory && zeroed)
        memset(memory, 0, bytes);
    return memory;
}

void *sp_alloc(size_t count, size_t size) { return allocate(count, size, true); }
void *sp_alloc_bare(size_t count, size_t size) { return allocate(count, size, false); }

void sp_free(void *memory) { free(memory); }

void *sp_grow(void *array, size_t need, size_t *capacity, size_t size) {
    enum { PAGE = 4096, FEWEST = 8 };
    if (array && need <= *capacity)
        return array;
    size_t more = *capacity > 0 ? 2 * *capacity : size < PAGE / FEWEST ? PAGE / size : FEWEST;
    more = more > need ? more : need;
    void *larger = sp_alloc(more, size);
    if (!larger)
        return NULL;
    if (array)
        memcpy(larger, array, *capacity * size);
    sp_free(array);
    *capacity = more;
    return larger;
}

char *sp_strdup(const char *text) {
    size_t size = strlen(text) + 1;
    char *copy = sp_alloc(size, 1);
    if (copy)
        memcpy(copy, text, size);
    return copy;
}

sp_status sp_fail_memory(sp_error *err, size_t bytes) {
    if (bytes < 1000) /* or not known */
        return sp_fail(err, SP_ENOMEM, "no memory");
    return sp_fail(err, SP_ENOMEM, "no memory for %.3g MB", (double)bytes / 1e6);
}

double sp_memory_limit(void) {
    const double pages = (double)sysconf(_SC_PHYS_PAGES), size = (double)sysconf(_SC_PAGESIZE);
    double bytes = pages > 0 && size > 0 ? pages * size : INFINITY;
    struct rlimit limit;
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        bytes = fmin(bytes, (double)limit.rlim_cur);
    return bytes;
}

char *sp_number_text(double value, char text[SP_NUMBER_TEXT]) {
    if (value != value) {
        snprintf(text, SP_NUMBER_TEXT, "nan"); /* printf may print a sign */
        return text;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, SP_NUMBER_TEXT, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    for (char *c = text; *c; c++) /* the locale may use a decimal comma */
        if (*c == ',')
            *c = '.';
    return text;
}

char *sp_number_plain(double value, char text[SP_NUMBER_TEXT]) {
    char *e = strchr(sp_number_text(value, text), 'e');
    if (!e)
        return text;
    char *to = e + 1, *from = to;
    if (*from == '-')
        to++;
    from += strspn(from, "+-0");
    memmove(to, from, strlen(from) + 1);
    return text;
}

sp_locale sp_locale_enter(void) {
    sp_locale l = {.plain = newlocale(LC_ALL_MASK, "C", (locale_t)0)};
    if (l.plain != (locale_t)0)
        l.before = uselocale(l.plain);
    return l;
}

void sp_locale_leave(sp_locale *l) {
    if (l->plain != (locale_t)0) {
        uselocale(l->before);
        freelocale(l->plain);
    }
}

static double seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double sp_clock_cpu(void) { return seconds(CLOCK_THREAD_CPUTIME_ID); }
double sp_clock_wall(void) { return seconds(CLOCK_MONOTONIC); }

/* ---- hashes ------------------------------------------------------------------------------------------------------ */

#define FNV_PRIME 0x100000001b3u

uint64_t sp_hash64(uint64_t hash, const void *data, size_t size) {
    const unsigned char *byte = data;
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ byte[k]) * FNV_PRIME;
    return hash;
}

uint64_t sp_hash64_words(uint64_t hash, const void *data, size_t size) {
    const unsigned char *byte = data;
    while (size > 0) {
        const size_t part = size < 8 ? size : 8;
        uint64_t word = 0;
        memcpy(&word, byte, part);
        hash = (hash ^ word) * FNV_PRIME;
        hash ^= hash >> 29; /* multiplication carries upwards only, so fold the high bits down */
        byte += part;
        size -= part;
    }
    return hash;
}
