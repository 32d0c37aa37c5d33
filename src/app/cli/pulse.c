/* Reads pulses from the command line and from files. */
#include "cli/pulse.h"

#include "base/base.h"
#include "cli/plot_input.h"

#include <string.h>

static const struct {
    const char *name;
    sp_pulse_kind kind;
    int numbers;
} kinds[] = {{"delta", SP_PULSE_DELTA, 0},
             {"gauss", SP_PULSE_GAUSS, 1},
             {"ricker", SP_PULSE_RICKER, 1},
             {"sine", SP_PULSE_SINE, 2},
             {"square", SP_PULSE_SQUARE, 1}};
enum { KINDS = sizeof kinds / sizeof *kinds };

static sp_status wrong_pulse(const char *word, sp_error *err) {
    return sp_fail(err, SP_EINVAL, "--pulse %.60s: must be " CLI_PULSES, word);
}

/* Reads `count` numbers, each after a colon. */
static sp_status numbers(const char *word, const char *at, int count, double *value, sp_error *err) {
    for (int k = 0; k < count; k++) {
        char text[64];
        if (*at != ':')
            return wrong_pulse(word, err);
        const size_t length = strcspn(++at, ":");
        if (length == 0 || length >= sizeof text)
            return wrong_pulse(word, err);
        memcpy(text, at, length);
        text[length] = '\0';
        if (cli_number("--pulse", text, 1e-9, 1e9, &value[k], err) != SP_OK)
            return err->status;
        at += length;
    }
    return *at ? wrong_pulse(word, err) : SP_OK;
}

sp_status cli_pulse_parse(const char *word, cli_pulse *out, sp_error *err) {
    const size_t length = strcspn(word, ":");
    double value[2] = {0, 0};
    if (length == 4 && strncmp(word, "file", 4) == 0 && word[length] == ':' && word[length + 1]) {
        *out = (cli_pulse){.word = word, .pulse = {.kind = SP_PULSE_TABLE}};
        return SP_OK;
    }
    for (int k = 0; k < KINDS; k++) {
        if (strlen(kinds[k].name) != length || strncmp(word, kinds[k].name, length) != 0)
            continue;
        const sp_status status = numbers(word, word + length, kinds[k].numbers, value, err);
        if (status != SP_OK)
            return status;
        const bool wide = kinds[k].kind == SP_PULSE_GAUSS || kinds[k].kind == SP_PULSE_SQUARE;
        *out = (cli_pulse){.word = word, .pulse = {.kind = kinds[k].kind}};
        out->pulse.width = wide ? value[0] : 0;
        out->pulse.omega = wide ? 0 : value[0];
        out->pulse.cycles = value[1];
        return SP_OK;
    }
    return wrong_pulse(word, err);
}

sp_status cli_pulse_open(cli_pulse *p, sp_error *err) {
    if (p->pulse.kind != SP_PULSE_TABLE || p->points)
        return SP_OK;
    const char *path = p->word + strlen("file:");
    sp_table t = sp_table_none();
    sp_status status = plot_read_table(path, &t, err);
    if (status != SP_OK)
        return status;
    if (t.columns < 2 || t.column[0].kind == SP_CELL_TEXT || t.column[1].kind == SP_CELL_TEXT) {
        status = sp_fail(err, SP_EFORMAT, "%s: is no pulse: must be a table with columns of times and strengths", path);
        goto out;
    }
    p->points = sp_alloc(2 * (size_t)t.rows, sizeof *p->points);
    if (!p->points) {
        status = sp_fail_memory(err, 2 * (size_t)t.rows * sizeof *p->points);
        goto out;
    }
    for (int64_t k = 0; k < t.rows; k++) {
        p->points[k] = sp_table_number(&t, k, 0);
        p->points[t.rows + k] = sp_table_number(&t, k, 1);
    }
    p->pulse.n = t.rows;
    p->pulse.t = p->points;
    p->pulse.s = p->points + t.rows;
    status = sp_pulse_check(&p->pulse, err);
    if (status != SP_OK) {
        sp_fail_prefix(err, "%s", path);
        status = err->status = SP_EFORMAT;
    }
out:
    sp_table_free(&t);
    return status;
}

void cli_pulse_free(cli_pulse *p) {
    sp_free(p->points);
    p->points = NULL;
}
