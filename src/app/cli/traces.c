/* Writes tables as MAT-files, and signals as SAC and SLIST. */
#include "cli/traces.h"

#include "base/base.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *ending_of(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot && !strchr(dot, '/') ? dot : "";
}

static bool has_ending(const char *path, const char *ending) { return strcasecmp(ending_of(path), ending) == 0; }

bool cli_is_foreign_table(const char *path) {
    return has_ending(path, ".mat") || has_ending(path, ".sac") || has_ending(path, ".slist");
}

/* ---- the files --------------------------------------------------------------------------------------------------- */

/* Signals need equal intervals, within rounding. */
static sp_status check_times(const sp_table *t, const char *path, sp_error *err) {
    if (t->columns < 2 || strcmp(t->column[0].name, "t") != 0 || t->rows < 2)
        return sp_fail(err, SP_EINVAL,
                       "%s: only tables of signals, whose first column is t, can be written in this form", path);
    const double first = sp_table_number(t, 0, 0), last = sp_table_number(t, t->rows - 1, 0);
    for (int64_t k = 0; k < t->rows; k++) {
        const double even = first + (last - first) * (double)k / (double)(t->rows - 1);
        if (!(fabs(sp_table_number(t, k, 0) - even) <= 1e-9 * fabs(last)))
            return sp_fail(err, SP_EINVAL, "%s: t = %g in row %lld; must be at equal intervals", path,
                           sp_table_number(t, k, 0), (long long)k + 1);
    }
    return SP_OK;
}

sp_status cli_foreign_files(const sp_table *t, const char *path, int *files, sp_error *err) {
    *files = has_ending(path, ".sac") ? t->columns - 1 : 1;
    return has_ending(path, ".mat") ? SP_OK : check_times(t, path, err);
}

sp_status cli_foreign_name(const sp_table *t, const char *path, int k, char name[SP_PATH_MAX], sp_error *err) {
    const char *ending = ending_of(path);
    const int stem = (int)(ending - path);
    const bool several = has_ending(path, ".sac") && t->columns > 2;
    const int length = several ? snprintf(name, SP_PATH_MAX, "%.*s-%s%s", stem, path, t->column[k + 1].name, ending)
                               : snprintf(name, SP_PATH_MAX, "%s", path);
    return length < SP_PATH_MAX ? SP_OK : sp_fail(err, SP_EINVAL, "%.100s: the name is too long", path);
}

/* ---- signals ----------------------------------------------------------------------------------------------------- */

/* Units of time in seconds. */
static double seconds(const char *unit) {
    static const struct {
        const char *unit;
        double seconds;
    } units[] = {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}};
    for (size_t k = 0; k < sizeof units / sizeof *units; k++)
        if (strcmp(unit, units[k].unit) == 0)
            return units[k].seconds;
    return 0;
}

/* The texts of a trace, and its values. */
typedef struct signal_text {
    char station[9], component[9], event[17], unit[9];
    double *value;
} signal_text;

/* Copies up to size - 1 characters that are not blank. */
static void copy_word(char *to, size_t size, const char *from, const char *stop) {
    size_t n = 0;
    for (; *from && !strchr(stop, *from) && n + 1 < size; from++)
        if (!isspace((unsigned char)*from) && *from != ':' && *from != '_')
            to[n++] = *from;
    to[n] = '\0';
}

/* "F1 = from bottom:normal to plane:25:normal, error ..." gives the station h25. */
static void name_trace(const sp_table *t, int column, signal_text *s) {
    const char *name = t->column[column].name, *how = sp_table_get_text(t, name);
    const char *to = how ? strstr(how, " to ") : NULL, *source = sp_table_get_text(t, "source");
    char place[64] = "top";
    if (to) {
        snprintf(place, sizeof place, "%s", to + 4);
        place[strcspn(place, ",")] = '\0';
        char *last = strrchr(place, ':'); /* the component */
        if (last)
            *last = '\0';
    }
    if (strncmp(place, "plane:", 6) == 0) { /* a height in few digits: a name has 8 letters */
        const double height = strtod(place + 6, NULL);
        snprintf(place, sizeof place, "h%.5g", height);
    }
    copy_word(s->station, sizeof s->station, place, "");
    copy_word(s->component, sizeof s->component, name, "");
    copy_word(s->event, sizeof s->event, source ? source : "unknown", ";");
    copy_word(s->unit, sizeof s->unit, t->column[column].unit[0] ? t->column[column].unit : "1", "");
}

static sp_status make_trace(const sp_table *t, int column, signal_text *s, sp_trace *trace, sp_error *err) {
    const double factor = seconds(t->column[0].unit), scale = factor > 0 ? factor : 1;
    const double first = sp_table_number(t, 0, 0), last = sp_table_number(t, t->rows - 1, 0);
    s->value = sp_alloc((size_t)t->rows, sizeof *s->value);
    if (!s->value)
        return sp_fail_memory(err, (size_t)t->rows * sizeof *s->value);
    for (int64_t k = 0; k < t->rows; k++)
        s->value[k] = sp_table_number(t, k, column);
    name_trace(t, column, s);
    *trace = (sp_trace){.station = s->station,
                        .component = s->component,
                        .event = s->event,
                        .unit = s->unit,
                        .time_unit = factor > 0 ? "s" : "tau",
                        .step = scale * (last - first) / (double)(t->rows - 1),
                        .begin = scale * first,
                        .n = t->rows,
                        .value = s->value,
                        .pressure = NAN,
                        .height = NAN};
    sp_table_get_number(t, "pressure", &trace->pressure);
    sp_table_get_number(t, "height", &trace->height);
    return SP_OK;
}

static sp_status write_sac(const sp_table *t, int count, const sp_trace *trace, const char *path, sp_error *err) {
    char name[SP_PATH_MAX];
    sp_status status = SP_OK;
    for (int k = 0; k < count && status == SP_OK; k++) {
        status = cli_foreign_name(t, path, k, name, err);
        CLI_THEN(status, sp_trace_save_sac(&trace[k], name, err));
    }
    return status;
}

sp_status cli_foreign_write(const sp_table *t, const char *path, sp_error *err) {
    if (has_ending(path, ".mat"))
        return sp_table_save_mat(t, path, err);
    const int count = t->columns - 1;
    signal_text *text = sp_alloc((size_t)count, sizeof *text);
    sp_trace *trace = sp_alloc((size_t)count, sizeof *trace);
    sp_status status = text && trace ? SP_OK : sp_fail_memory(err, (size_t)count * (sizeof *text + sizeof *trace));
    for (int k = 0; k < count && status == SP_OK; k++)
        status = make_trace(t, k + 1, &text[k], &trace[k], err);
    CLI_THEN(status, has_ending(path, ".sac") ? write_sac(t, count, trace, path, err)
                                              : sp_traces_save_slist(count, trace, path, err));
    for (int k = 0; text && k < count; k++)
        sp_free(text[k].value);
    sp_free(text);
    sp_free(trace);
    return status;
}
