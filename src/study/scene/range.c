/* Reads a range of a sweep: from one number to another in equal steps or equal ratios. */
#include "base/base.h"
#include "scene/reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_VALUES = 10000 };

typedef struct range {
    const char *key;
    double from, to;
    int count;
    bool log;
} range;

static const char *const members[] = {"from", "to", "count", "step", "spacing"};
enum { FROM, TO, COUNT, STEP, SPACING, MEMBERS };

/* Finds the members of a range; NULL for missing ones. An entry of study.sweep has a key as well. */
static sp_status find_members(sp_reader *r, const range *g, const config_setting_t *group,
                              const config_setting_t *found[MEMBERS]) {
    for (int k = 0; k < config_setting_length(group); k++) {
        const config_setting_t *member = config_setting_get_elem(group, (unsigned)k);
        const char *name = config_setting_name(member);
        int which = 0;
        while (which < MEMBERS && strcmp(name, members[which]) != 0)
            which++;
        if (which < MEMBERS) {
            found[which] = member;
            continue;
        }
        if (strcmp(name, "key") == 0 && !config_setting_name(group)) /* an entry of study.sweep */
            continue;
        const char *near = sp_nearest_word(name, MEMBERS, members);
        r->line = config_setting_source_line(member);
        return sp_fail_key(r->err, SP_EINVAL, g->key,
                           ": a range has no \"%.60s\": must be from, to, count or step, spacing%s%s%s", name,
                           near ? " (did you mean " : "", near ? near : "", near ? "?)" : "");
    }
    return SP_OK;
}

static sp_status read_spacing(sp_reader *r, range *g, const config_setting_t *setting) {
    const char *word = setting && config_setting_type(setting) == CONFIG_TYPE_STRING
                           ? config_setting_get_string(setting)
                       : setting ? ""
                                 : "linear";
    g->log = strcmp(word, "log") == 0;
    if (g->log || strcmp(word, "linear") == 0)
        return SP_OK;
    r->line = config_setting_source_line(setting);
    return sp_fail_key(r->err, SP_EINVAL, g->key, ": spacing of a range must be \"linear\" or \"log\"");
}

static sp_status read_count(sp_reader *r, range *g, const config_setting_t *setting) {
    sp_number number;
    r->line = config_setting_source_line(setting);
    if (!sp_reader_number(setting, &number) ||
        !(number.real >= 2 && number.real <= MOST_VALUES && number.real == floor(number.real)))
        return sp_fail_key(r->err, SP_EINVAL, g->key, ": count of a range must be an integer 2 .. %d", MOST_VALUES);
    g->count = (int)number.real;
    return SP_OK;
}

static sp_status read_step(sp_reader *r, const sp_field *f, range *g, const config_setting_t *setting) {
    sp_number number;
    r->line = config_setting_source_line(setting);
    const bool text = config_setting_type(setting) == CONFIG_TYPE_STRING;
    sp_status status = text ? sp_reader_quantity(r, f, setting, &number) : SP_OK;
    if (status != SP_OK)
        return status;
    if ((!text && !sp_reader_number(setting, &number)) || !isfinite(number.real) || !(fabs(number.real) > 0))
        return sp_fail_key(r->err, SP_EINVAL, g->key, ": step of a range must be a number other than 0");
    if (g->log)
        return sp_fail_key(r->err, SP_EINVAL, g->key, ": a range with spacing = \"log\" must have a count, not a step");
    const double steps = (g->to - g->from) / number.real;
    if (!(steps > 0))
        return sp_fail_key(r->err, SP_EINVAL, g->key, ": step = %g of a range must lead from %g to %g", number.real,
                           g->from, g->to);
    if (steps > MOST_VALUES - 0.5)
        return sp_fail_key(r->err, SP_EINVAL, g->key,
                           ": step = %g of a range makes %.6g values: must be %d at the most", number.real,
                           floor(steps) + 1, MOST_VALUES);
    if (floor(steps + 0.5) < 1 || fabs(steps - floor(steps + 0.5)) > 1e-9 * steps)
        return sp_fail_key(r->err, SP_EINVAL, g->key,
                           ": step = %g of a range must divide its length %g, not %.6g times", number.real,
                           fabs(g->to - g->from), steps);
    g->count = (int)floor(steps + 0.5) + 1;
    return SP_OK;
}

static sp_status read_members(sp_reader *r, const sp_field *f, const config_setting_t *group, range *g) {
    const config_setting_t *member[MEMBERS] = {NULL};
    const unsigned line = r->line;
    sp_status status = find_members(r, g, group, member);
    if (status != SP_OK)
        return status;
    if (!member[FROM] || !member[TO] || !member[COUNT] == !member[STEP])
        return sp_fail_key(
            r->err, SP_EINVAL, g->key,
            ": a range %s: must be { from = 1e-7; to = 1e-4; count = 4; spacing = \"log\"; } or { from = "
            "0; to = 0.5; step = 0.1; }",
            !member[FROM]   ? "without from"
            : !member[TO]   ? "without to"
            : member[COUNT] ? "with both count and step"
                            : "without count and step");
    status = sp_reader_swept_number(r, f, member[FROM], &g->from);
    if (status == SP_OK)
        status = sp_reader_swept_number(r, f, member[TO], &g->to);
    if (status == SP_OK)
        status = read_spacing(r, g, member[SPACING]);
    if (status != SP_OK)
        return status;
    r->line = line;
    if (!(g->from < g->to || g->from > g->to))
        return sp_fail_key(r->err, SP_EINVAL, g->key, ": a range from %g to %g: must have two ends", g->from, g->to);
    if (g->log && !(g->from > 0 && g->to > 0))
        return sp_fail_key(r->err, SP_EINVAL, g->key, ": a range from %g to %g with spacing = \"log\": must be above 0",
                           g->from, g->to);
    return member[COUNT] ? read_count(r, g, member[COUNT]) : read_step(r, f, g, member[STEP]);
}

/* Removes rounding errors: a value within 1e-14 of a number of 12 digits becomes that number, so that decades are
 * exact. */
static double rounded(double value) {
    char text[SP_NUMBER_TEXT];
    snprintf(text, sizeof text, "%.12g", value);
    const double few = strtod(text, NULL);
    return fabs(few - value) <= 1e-14 * fabs(value) ? few + 0.0 : value;
}

/* Value k of a range. Long doubles make the last bit independent of the library's pow. */
static long double value_at(const range *g, int k) {
    const int last = g->count - 1;
    const long double from = g->from, to = g->to;
    if (k == 0 || k == last)
        return k == 0 ? from : to;
    return g->log ? from * powl(to / from, (long double)k / last) : (from * (last - k) + to * k) / last;
}

static sp_status make_integers(const sp_reader *r, const range *g, double *values) {
    const int last = g->count - 1;
    for (int k = 0; k < g->count; k++) {
        const __int128 sum = (__int128)g->from * (last - k) + (__int128)g->to * k; /* last times value k */
        if (!g->log && sum % last != 0)
            return sp_fail_key(r->err, SP_EINVAL, g->key,
                               ": the range from %.17g to %.17g has %.6Lg as value %d of %d: must be integers", g->from,
                               g->to, value_at(g, k), k + 1, g->count);
        values[k] = g->log ? (double)floorl(value_at(g, k) + 0.5L) : (double)(sum / last);
        if (k > 0 && !(values[k] < values[k - 1] || values[k] > values[k - 1]))
            return sp_fail_key(r->err, SP_EINVAL, g->key,
                               ": a range of %d integers from %.17g to %.17g has %.17g twice: must be fewer", g->count,
                               g->from, g->to, values[k]);
    }
    return SP_OK;
}

sp_status sp_read_range(sp_reader *r, const sp_field *f, const config_setting_t *group, sp_sweep *sweep) {
    range g = {.key = sweep->key};
    if (!sp_field_is_number(f))
        return sp_fail_key(r->err, SP_EINVAL, sweep->key, ": a range has numbers only: other values must be a list");
    const unsigned line = r->line;
    sp_status status = read_members(r, f, group, &g);
    if (status != SP_OK)
        return status;
    r->line = line;
    sweep->values = sp_alloc((size_t)g.count, sizeof *sweep->values);
    sweep->count = g.count;
    if (!sweep->values)
        return sp_fail_memory(r->err, (size_t)g.count * sizeof *sweep->values);
    if (f->type != SP_FIELD_REAL)
        return make_integers(r, &g, sweep->values);
    for (int k = 0; k < g.count; k++) {
        const bool end = k == 0 || k == g.count - 1;
        const double value = (double)value_at(&g, k);
        sweep->values[k] = end ? value : rounded(value);
    }
    return SP_OK;
}
