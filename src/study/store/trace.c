/* Signals as seismologists' programs read them: SAC, and SLIST as text. */
#include "base/base.h"
#include "base/text.h"

#include <float.h>
#include <math.h>
#include <sonopack/study/export_file.h>
#include <string.h>

/* ---- SAC -------------------------------------------------------------------------------------------------------- */

/* The header: numbers, integers and flags, names; words of the same 4 bytes. -12345 stands for "not known". */
typedef struct sac_header {
    float number[70];
    int32_t integer[40];
    char name[24][8]; /* the second name has 16 letters */
} sac_header;
enum { DELTA = 0, LOWEST, HIGHEST, FIRST = 5, LAST, USER = 40, MEAN = 56 };                        /* numbers */
enum { VERSION = 6, POINTS = 9, FILE_TYPE = 15, QUANTITY, EVEN = 35, WRITABLE = 37, UNUSED = 39 }; /* integers */
enum { STATION = 0, EVENT = 1, UNIT = 17, TIME_UNIT, PROGRAM, COMPONENT = 20 };                    /* names */
enum { TIME_SERIES = 1, UNKNOWN_QUANTITY = 5 };

static void set_name(char *to, size_t size, const char *text) {
    for (size_t k = 0; k < size; k++) {
        to[k] = *text ? *text : ' ';
        text += *text != '\0';
    }
}

static void clear_header(sac_header *h) {
    for (size_t k = 0; k < sizeof h->number / sizeof *h->number; k++)
        h->number[k] = -12345;
    for (size_t k = 0; k < sizeof h->integer / sizeof *h->integer; k++)
        h->integer[k] = k < EVEN ? -12345 : 0;
    for (size_t k = 0; k < sizeof h->name / sizeof *h->name; k++)
        set_name(h->name[k], 8, "-12345");
}

static void fill_header(const sp_trace *trace, sac_header *h) {
    double low = INFINITY, high = -INFINITY, sum = 0;
    clear_header(h);
    for (int64_t k = 0; k < trace->n; k++) {
        low = fmin(low, trace->value[k]);
        high = fmax(high, trace->value[k]);
        sum += trace->value[k];
    }
    h->number[DELTA] = (float)trace->step;
    h->number[LOWEST] = (float)low;
    h->number[HIGHEST] = (float)high;
    h->number[MEAN] = (float)(sum / (double)trace->n);
    h->number[FIRST] = (float)trace->begin;
    h->number[LAST] = (float)(trace->begin + trace->step * (double)(trace->n - 1));
    if (!isnan(trace->pressure))
        h->number[USER] = (float)trace->pressure;
    if (!isnan(trace->height))
        h->number[USER + 1] = (float)trace->height;
    h->integer[VERSION] = 6;
    h->integer[POINTS] = (int32_t)trace->n;
    h->integer[FILE_TYPE] = TIME_SERIES;
    h->integer[QUANTITY] = UNKNOWN_QUANTITY; /* SAC knows no forces */
    h->integer[EVEN] = h->integer[WRITABLE] = 1;
    set_name(h->name[STATION], 8, trace->station);
    set_name(h->name[EVENT], 16, trace->event);
    set_name(h->name[COMPONENT], 8, trace->component);
    set_name(h->name[UNIT], 8, trace->unit);
    set_name(h->name[TIME_UNIT], 8, trace->time_unit);
    set_name(h->name[PROGRAM], 8, "sonopack");
}

static sp_status check_trace(const sp_trace *trace, double limit, const char *path, sp_error *err) {
    if (trace->n < 2 || trace->n > INT32_MAX / 4 || !(trace->step > 0) || !isfinite(trace->begin))
        return sp_fail(err, SP_EINVAL, "%s: %lld values at intervals of %g; must be 2 or more, at a positive interval",
                       path, (long long)trace->n, trace->step);
    for (int64_t k = 0; k < trace->n; k++)
        if (!(fabs(trace->value[k]) <= limit))
            return sp_fail(err, SP_EINVAL, "%s: value %lld is %g; must be a finite number of up to %.3g", path,
                           (long long)k, trace->value[k], limit);
    return SP_OK;
}

/* Writes the words of memory as little-endian ones. */
static void add_words(sp_text *t, const void *words, size_t count) {
    const uint16_t one = 1;
    const bool little = *(const unsigned char *)&one == 1;
    const char *from = words;
    for (size_t k = 0; k < count; k++) {
        char word[4];
        for (size_t b = 0; b < 4; b++)
            word[b] = from[4 * k + (little ? b : 3 - b)];
        sp_text_bytes(t, word, 4);
    }
}

sp_status sp_trace_save_sac(const sp_trace *trace, const char *path, sp_error *err) {
    sp_status status = check_trace(trace, 3.4e38, path, err);
    if (status != SP_OK)
        return status;
    sp_text t = {0};
    sac_header h;
    float *value = sp_alloc((size_t)trace->n, sizeof *value);
    if (!value)
        return sp_fail_memory(err, (size_t)trace->n * sizeof *value);
    for (int64_t k = 0; k < trace->n; k++)
        value[k] = (float)trace->value[k];
    fill_header(trace, &h);
    add_words(&t, h.number, 70);
    add_words(&t, h.integer, 40);
    sp_text_bytes(&t, h.name[0], sizeof h.name);
    add_words(&t, value, (size_t)trace->n);
    status = t.failed ? sp_fail_memory(err, t.capacity) : sp_text_save(path, t.data, t.size, err);
    sp_free(value);
    sp_text_free(&t);
    return status;
}

/* ---- SLIST ------------------------------------------------------------------------------------------------------ */

/* Network, station, location, channel and quality, of which the first, third and last are empty; then values in six
 * columns. The time is counted from the pulse, which has the date 1970-01-01. */
static void add_trace(sp_text *t, const sp_trace *trace) {
    sp_text_add(t, "TIMESERIES SP_%s__%s_, %lld samples, ", trace->station, trace->component, (long long)trace->n);
    sp_text_number(t, 1 / trace->step);
    sp_text_add(t, " sps, 1970-01-01T00:00:%09.6f, SLIST, FLOAT, %s\n", trace->begin, trace->unit);
    for (int64_t k = 0; k < trace->n; k++) {
        sp_text_number(t, trace->value[k]);
        sp_text_add(t, k % 6 == 5 || k == trace->n - 1 ? "\n" : "\t");
    }
}

sp_status sp_traces_save_slist(int count, const sp_trace *trace, const char *path, sp_error *err) {
    sp_text t = {0};
    sp_status status = SP_OK;
    for (int k = 0; k < count && status == SP_OK; k++) {
        status = check_trace(&trace[k], DBL_MAX, path, err);
        if (status == SP_OK && !(trace[k].begin >= 0 && trace[k].begin < 60))
            status = sp_fail(err, SP_EINVAL, "%s: the first time is %g; must be 0 .. 60", path, trace[k].begin);
    }
    sp_locale locale = sp_locale_enter();
    for (int k = 0; k < count && status == SP_OK; k++)
        add_trace(&t, &trace[k]);
    sp_locale_leave(&locale);
    if (status == SP_OK)
        status = t.failed ? sp_fail_memory(err, t.capacity) : sp_text_save(path, t.data, t.size, err);
    sp_text_free(&t);
    return status;
}
