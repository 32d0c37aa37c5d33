/* Reads places, pulses and dashpots from the command line. */
#include "cli/excitation.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>

/* ---- places ------------------------------------------------------------------------------------------------------ */

const char *const cli_component_names[] = {"normal", "shear", NULL};

static sp_status add(cli_places *p, sp_place at, bool named, sp_error *err) {
    if (p->n == CLI_PLACES_MAX)
        return sp_fail(err, SP_EINVAL, "more than %d %s", CLI_PLACES_MAX, p->sources ? "sources" : "detectors");
    p->at[p->n] = at;
    p->named[p->n++] = named;
    return SP_OK;
}

sp_status cli_places_add(void *places, const char *word, sp_error *err) {
    cli_places *p = places;
    sp_place at;
    bool named;
    const sp_status status = sp_place_read(word, p->sources, &at, &named, err);
    return status == SP_OK ? add(p, at, named, err) : sp_fail_prefix(err, p->sources ? "--from" : "--detector");
}

sp_status cli_places_add_planes(cli_places *p, int64_t count, double height, sp_error *err) {
    sp_status status = SP_OK;
    for (int64_t k = 1; k <= count && status == SP_OK; k++) {
        const sp_place plane = {.kind = SP_PLACE_PLANE, .height = height * (double)k / (double)(count + 1)};
        status = add(p, plane, false, err);
    }
    return status;
}

void cli_places_set_component(cli_places *p, bool shear) {
    if (p->n == 0)
        p->at[p->n++] = sp_place_wall();
    for (int32_t k = 0; k < p->n; k++)
        p->at[k].shear = p->named[k] ? p->at[k].shear : shear;
}

/* ---- pulses ------------------------------------------------------------------------------------------------------ */

static const struct {
    const char *name;
    sp_pulse_kind kind;
    int numbers;
} kinds[] = {{"delta", SP_PULSE_DELTA, 0},
             {"gauss", SP_PULSE_GAUSS, 1},
             {"ricker", SP_PULSE_RICKER, 1},
             {"sine", SP_PULSE_SINE, 2},
             {"square", SP_PULSE_SQUARE, 1}};

static sp_status wrong_pulse(const char *word, sp_error *err) {
    return sp_fail(
        err, SP_EINVAL,
        "--pulse %.60s: must be delta, gauss:WIDTH, ricker:OMEGA, sine:OMEGA:CYCLES, square:WIDTH or file:PATH", word);
}

/* Reads `count` numbers, each after a colon. */
static sp_status numbers(const char *word, const char *at, int count, double *value, sp_error *err) {
    for (int k = 0; k < count; k++) {
        char text[64];
        const size_t length = *at == ':' ? strcspn(++at, ":") : 0;
        if (length == 0 || length >= sizeof text)
            return wrong_pulse(word, err);
        snprintf(text, sizeof text, "%.*s", (int)length, at);
        if (cli_number("--pulse", text, 1e-9, 1e9, &value[k], err) != SP_OK)
            return err->status;
        at += length;
    }
    return *at ? wrong_pulse(word, err) : SP_OK;
}

sp_status cli_pulse_parse(void *pulse, const char *word, sp_error *err) {
    cli_pulse *out = pulse;
    const size_t length = strcspn(word, ":");
    double value[2] = {0, 0};
    if (strncmp(word, "file:", 5) == 0 && word[5]) {
        *out = (cli_pulse){.word = word, .pulse = {.kind = SP_PULSE_TABLE}};
        return SP_OK;
    }
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        if (strlen(kinds[k].name) != length || strncmp(word, kinds[k].name, length) != 0)
            continue;
        const sp_status status = numbers(word, word + length, kinds[k].numbers, value, err);
        const bool wide = kinds[k].kind == SP_PULSE_GAUSS || kinds[k].kind == SP_PULSE_SQUARE;
        *out = (cli_pulse){.word = word, .pulse = {.kind = kinds[k].kind, .cycles = value[1]}};
        *(wide ? &out->pulse.width : &out->pulse.omega) = value[0];
        return status;
    }
    return wrong_pulse(word, err);
}

static sp_status take_points(cli_pulse *p, const char *path, const sp_table *t, sp_error *err) {
    if (t->columns < 2 || t->column[0].kind == SP_COLUMN_TEXT || t->column[1].kind == SP_COLUMN_TEXT)
        return sp_fail(err, SP_EFORMAT, "%s: is no pulse: must be a table with columns of times and strengths", path);
    p->points = sp_alloc(2 * (size_t)t->rows, sizeof *p->points);
    if (!p->points)
        return sp_fail_memory(err, 2 * (size_t)t->rows * sizeof *p->points);
    for (int64_t k = 0; k < 2 * t->rows; k++)
        p->points[k] = sp_table_number(t, k % t->rows, k >= t->rows);
    p->pulse.n = t->rows;
    p->pulse.t = p->points;
    p->pulse.s = p->points + t->rows;
    if (sp_pulse_check(&p->pulse, err) == SP_OK)
        return SP_OK;
    sp_fail_prefix(err, "%s", path);
    return err->status = SP_EFORMAT;
}

sp_status cli_pulse_open(cli_pulse *p, sp_error *err) {
    const char *path = p->word ? p->word + strlen("file:") : NULL;
    sp_table t = sp_table_none();
    if (p->pulse.kind != SP_PULSE_TABLE || p->points)
        return SP_OK;
    sp_status status = sp_table_read(path, &t, err);
    CLI_THEN(status, take_points(p, path, &t, err));
    sp_table_free(&t);
    return status;
}

void cli_pulse_free(cli_pulse *p) {
    sp_free(p->points);
    p->points = NULL;
}

/* ---- dashpots ---------------------------------------------------------------------------------------------------- */

sp_status cli_damping_read(const char *text, double low, double high, sp_damping *out, sp_error *err) {
    sp_damping law = {.ratio = 1};
    sp_status status = SP_OK;
    if (!strchr(text, ':'))
        status = cli_number("--damping", text, low, high, &law.value, err);
    else if (sp_damping_read(text, &law, err) != SP_OK)
        status = sp_fail(err, SP_EINVAL, "--damping %.60s: must be " CLI_DAMPING ", with numbers of 0 or more", text);
    if (status == SP_OK && law.value < low)
        status = sp_fail(err, SP_EINVAL, "--damping %.60s: the coefficient must be above 0", text);
    if (status == SP_OK)
        *out = law;
    return status;
}

void cli_damping_comment(cli_writer *w, const sp_damping *law) {
    char normal[SP_NUMBER_TEXT], tangential[SP_NUMBER_TEXT];
    if (law->kind == SP_DAMPING_ZETA)
        cli_value(w, "damping", law->value);
    else
        cli_comment(w, "damping = %s:%s:%s", law->kind == SP_DAMPING_MASS ? "mass" : "gamma",
                    sp_number_text(law->value, normal), sp_number_text(law->ratio * law->value, tangential));
}
