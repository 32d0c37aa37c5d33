/* Writes and parses lines of the manifest. */
#include "store/manifest_line.h"

#include "base/base.h"
#include "base/hash.h"
#include "store/sample_h5.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUM_DIGITS = 16 };

/* ---- writing --------------------------------------------------------------------------------------------------- */

void sp_manifest_head(sp_text *out) {
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    sp_text_add(out, "name\tfile\tbytes\tmodified\tcontent\tparts");
    for (int k = 0; k < results; k++)
        sp_text_add(out, "\t%s", result[k].field->name.path + strlen("/results/"));
    sp_text_add(out, "\tsignal\tplanes\treason\tchecksum\n");
}

static void put_number(sp_text *out, const sp_sample *s, const sp_result *r) {
    const char *place = (const char *)s + r->offset;
    double real;
    int32_t narrow;
    uint64_t wide;
    switch (r->field->type) {
    case SP_H5_F64:
        memcpy(&real, place, sizeof real);
        sp_text_number(out, real);
        break;
    case SP_H5_I32:
        memcpy(&narrow, place, sizeof narrow);
        sp_text_add(out, "%d", narrow);
        break;
    default:
        memcpy(&wide, place, sizeof wide);
        sp_text_add(out, "%llu", (unsigned long long)wide);
        break;
    }
}

static void put_signal(sp_text *out, const sp_sample *s) {
    const sp_signal_made *m = &s->signal;
    if (!(s->have & SP_WANT_SIGNAL)) {
        sp_text_add(out, "\t-");
        return;
    }
    sp_text_add(out, "\t%d %d ", m->points, (int)m->method);
    sp_text_number(out, m->until);
    sp_text_add(out, " ");
    sp_text_number(out, m->tolerance);
}

static void put_planes(sp_text *out, const sp_sample *s) {
    sp_text_add(out, s->have & SP_WANT_PLANES ? "\t%d" : "\t-", s->planes);
    for (int32_t k = 0; s->have & SP_WANT_PLANES && k < s->planes; k++) {
        const sp_front *f = &s->plane_front[k];
        const double number[] = {s->plane[k], f->t10, f->t_peak, f->t_zero, f->amplitude, f->width};
        for (size_t i = 0; i < sizeof number / sizeof *number; i++) {
            sp_text_add(out, " ");
            sp_text_number(out, number[i]);
        }
    }
}

void sp_manifest_put(sp_text *out, const sp_manifest_line *line) {
    const sp_sample *s = &line->sample;
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    const size_t begin = out->size;
    char reason[sizeof s->reason];
    snprintf(reason, sizeof reason, "%s", s->reason[0] ? s->reason : "-");
    for (char *c = reason; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    sp_locale locale = sp_locale_enter();
    sp_text_add(out, "%s\t%s\t%lld\t%lld\t%016llx\t%u", s->name, s->failed ? "failed" : "h5", (long long)line->bytes,
                (long long)line->modified, (unsigned long long)line->content, s->have);
    for (int k = 0; k < results; k++) {
        sp_text_add(out, "\t");
        if (result[k].want && !(s->have & result[k].want))
            sp_text_add(out, "-");
        else
            put_number(out, s, &result[k]);
    }
    put_signal(out, s);
    put_planes(out, s);
    sp_text_add(out, "\t%s\t", reason);
    sp_locale_leave(&locale);
    if (!out->failed)
        sp_text_add(out, "%016llx\n",
                    (unsigned long long)sp_hash64(SP_HASH64_BEGIN, out->data + begin, out->size - begin));
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

bool sp_manifest_sound(const char *line, size_t length) {
    if (length <= SUM_DIGITS || line[length - SUM_DIGITS - 1] != '\t')
        return false;
    char sum[SUM_DIGITS + 1];
    snprintf(sum, sizeof sum, "%016llx", (unsigned long long)sp_hash64(SP_HASH64_BEGIN, line, length - SUM_DIGITS));
    return memcmp(sum, line + length - SUM_DIGITS, SUM_DIGITS) == 0;
}

/* Cuts off the next cell; NULL at the end. */
static char *next_cell(char **rest) {
    char *cell = *rest;
    if (!cell)
        return NULL;
    char *tab = strchr(cell, '\t');
    *rest = tab ? tab + 1 : NULL;
    if (tab)
        *tab = '\0';
    return cell;
}

static bool get_number(const char *cell, const sp_result *r, sp_sample *s) {
    char *place = (char *)s + r->offset;
    double real;
    int64_t integer;
    uint64_t wide;
    bool good;
    switch (r->field->type) {
    case SP_H5_F64:
        good = sp_word_number(cell, &real);
        if (good)
            memcpy(place, &real, sizeof real);
        return good;
    case SP_H5_I32:
        good = sp_word_integer(cell, &integer) && integer >= INT32_MIN && integer <= INT32_MAX;
        if (good)
            memcpy(place, &(int32_t){(int32_t)integer}, sizeof(int32_t));
        return good;
    default:
        good = sp_word_unsigned(cell, &wide);
        if (good)
            memcpy(place, &wide, sizeof wide);
        return good;
    }
}

static bool get_numbers(char *cell, int count, double *number) {
    char *word[6 * SP_PLANES_MAX + 1];
    if (count > 6 * SP_PLANES_MAX + 1 || sp_line_words(cell, word, count) != count)
        return false;
    for (int k = 0; k < count; k++)
        if (!sp_word_number(word[k], &number[k]))
            return false;
    return true;
}

static bool get_signal(char *cell, sp_sample *s) {
    double number[4];
    if (strcmp(cell, "-") == 0)
        return !(s->have & SP_WANT_SIGNAL);
    if (!get_numbers(cell, 4, number) || !(number[0] >= 0 && number[0] <= INT32_MAX && number[1] >= 0 &&
                                           number[1] < 99 && sp_signal_method_name((sp_signal_method)(int)number[1])))
        return false;
    s->signal = (sp_signal_made){.points = (int32_t)number[0],
                                 .method = (sp_signal_method)(int)number[1],
                                 .until = number[2],
                                 .tolerance = number[3]};
    return true;
}

static bool get_planes(char *cell, sp_sample *s) {
    double number[6 * SP_PLANES_MAX + 1];
    if (strcmp(cell, "-") == 0)
        return !(s->have & SP_WANT_PLANES);
    const long planes = strtol(cell, NULL, 10);
    if (planes < 0 || planes > SP_PLANES_MAX || !get_numbers(cell, 6 * (int)planes + 1, number))
        return false;
    s->planes = (int32_t)planes;
    for (int32_t k = 0; k < s->planes; k++) {
        const double *n = number + 1 + 6 * k;
        s->plane[k] = n[0];
        s->plane_front[k] = (sp_front){.t10 = n[1], .t_peak = n[2], .t_zero = n[3], .amplitude = n[4], .width = n[5]};
    }
    return true;
}

/* Parses the cells before the results. */
static bool get_file(char **rest, sp_manifest_line *l) {
    int64_t have;
    const char *name = next_cell(rest), *file = next_cell(rest), *bytes = next_cell(rest), *modified = next_cell(rest),
               *content = next_cell(rest), *parts = next_cell(rest);
    if (!parts || strlen(content) != SUM_DIGITS || strspn(content, "0123456789abcdef") != SUM_DIGITS ||
        strlen(name) >= SP_NAME_MAX || !sp_word_integer(bytes, &l->bytes) || !sp_word_integer(modified, &l->modified) ||
        !sp_word_integer(parts, &have) || have < 0 || have > INT32_MAX)
        return false;
    snprintf(l->sample.name, sizeof l->sample.name, "%s", name);
    l->content = strtoull(content, NULL, 16);
    l->sample.failed = strcmp(file, "failed") == 0;
    l->sample.have = (unsigned)have;
    return l->sample.failed || strcmp(file, "h5") == 0;
}

static bool get_line(char *line, sp_manifest_line *l) {
    sp_result result[SP_RESULTS_MAX];
    const int results = sp_results(result);
    char *rest = line;
    l->sample = sp_sample_blank();
    if (!get_file(&rest, l))
        return false;
    for (int k = 0; k < results; k++) {
        const char *cell = next_cell(&rest);
        const bool here = !result[k].want || l->sample.have & result[k].want;
        if (!cell || (here ? !get_number(cell, &result[k], &l->sample) : strcmp(cell, "-") != 0))
            return false;
    }
    char *signal = next_cell(&rest), *planes = next_cell(&rest), *reason = next_cell(&rest);
    if (!reason || !get_signal(signal, &l->sample) || !get_planes(planes, &l->sample))
        return false;
    if (strcmp(reason, "-") != 0)
        snprintf(l->sample.reason, sizeof l->sample.reason, "%s", reason);
    return true;
}

/* What tables count with. All other numbers are those of the file, which was checked. */
static bool possible(const sp_sample *s) {
    return s->dim >= 1 && s->dim <= 3 && s->kind >= SP_PACK_PISTON && s->kind <= SP_PACK_FILE && s->grains >= 1;
}

bool sp_manifest_get(char *line, sp_manifest_line *out) {
    sp_manifest_line l = {0};
    sp_locale locale = sp_locale_enter();
    const bool good = get_line(line, &l) && possible(&l.sample);
    sp_locale_leave(&locale);
    if (good)
        *out = l;
    return good;
}
