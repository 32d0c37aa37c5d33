/* Columns of particles and comments of the tables of a column: its parameters, its results, and warnings. */
#include "base/base.h"
#include "tapped/column.h"
#include "tapped/tapped_table.h"

#include <stdio.h>
#include <string.h>

sp_status sp_tapped_add_particles(const sp_tapped_spec *c, const char *letter, int32_t first, const char *unit,
                                  sp_table *t, sp_error *err) {
    sp_status status = SP_OK;
    char name[32];
    for (int32_t i = first; i <= c->particles && status == SP_OK; i++) {
        snprintf(name, sizeof name, "%s%d", letter, i);
        status = sp_table_add_column(t, name, unit, SP_COLUMN_NUMBER, err);
    }
    return status;
}

/* ---- parameters ------------------------------------------------------------------------------------------------- */

/* One comment "key = value": a word, or else a number. */
typedef struct setting {
    bool shown;
    const char *key, *word;
    double value;
} setting;

static sp_status add_setting(sp_table *t, const char *key, const char *word, sp_error *err) {
    return sp_table_get_text(t, key) ? SP_OK : sp_table_set_text(t, key, word, err);
}

static sp_status add_settings(sp_table *t, size_t n, const setting *of, sp_error *err) {
    char number[SP_NUMBER_TEXT];
    sp_status status = SP_OK;
    for (size_t k = 0; k < n && status == SP_OK; k++)
        if (of[k].shown)
            status = add_setting(t, of[k].key, of[k].word ? of[k].word : sp_number_text(of[k].value, number), err);
    return status;
}

/* Writes one number, or a list in parentheses that is cut after SHOWN values. */
static sp_status add_list(sp_table *t, const char *key, int32_t n, const double *list, sp_error *err) {
    enum { SHOWN = 16 };
    char text[SHOWN * (SP_NUMBER_TEXT + 2) + 64], number[SP_NUMBER_TEXT];
    if (n == 1)
        return add_setting(t, key, sp_number_text(list[0], number), err);
    int used = snprintf(text, sizeof text, "(");
    for (int32_t i = 0; i < n && i < SHOWN; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, "%s%s", i > 0 ? ", " : "",
                         sp_number_text(list[i], number));
    if (n > SHOWN)
        used += snprintf(text + used, sizeof text - (size_t)used, ", ... %d values", n);
    snprintf(text + used, sizeof text - (size_t)used, ")");
    return add_setting(t, key, text, err);
}

static sp_status add_solver(const sp_tapped_spec *c, sp_table *t, sp_error *err) {
    static const char *const models[] = {[SP_TAPPED_LATTICE] = "lattice",
                                         [SP_TAPPED_LONGWAVE] = "longwave",
                                         [SP_TAPPED_BSR] = "bsr",
                                         [SP_TAPPED_EQ35] = "eq35",
                                         [SP_TAPPED_EQ37] = "eq37"};
    static const char *const methods[] = {
        [SP_TAPPED_EVENT] = "event", [SP_TAPPED_SMOOTH] = "smooth", [SP_TAPPED_RK4] = "rk4"};
    static const char *const bsrs[] = {[SP_TAPPED_BSR_CONSERVATIVE] = "conservative",
                                       [SP_TAPPED_BSR_LITERAL] = "literal",
                                       [SP_TAPPED_BSR_SIGNED] = "signed"};
    const bool all = c->output == SP_TAPPED_COMPARE, lattice = all || c->model == SP_TAPPED_LATTICE,
               smooth = lattice && c->method == SP_TAPPED_SMOOTH, continuum = all || c->model != SP_TAPPED_LATTICE;
    const setting settings[] = {
        {true, "model", all ? "lattice, longwave, bsr" : models[c->model], 0},
        {lattice, "method", methods[c->method], 0},
        {all || c->model == SP_TAPPED_BSR, "bsr", bsrs[all ? SP_TAPPED_BSR_CONSERVATIVE : c->bsr], 0},
        {smooth || continuum, "alpha_v", NULL, c->alpha_v},
        {smooth, "alpha_x", NULL, c->alpha_x},
        {smooth, "tolerance", NULL, c->tolerance},
        {continuum, "cells", NULL, c->cells}};
    return add_settings(t, sizeof settings / sizeof *settings, settings, err);
}

const char *sp_tapped_parameter_name(sp_tapped_parameter parameter) {
    static const char *const names[] = {[SP_TAPPED_BY_AMPLITUDE] = "amplitude",
                                        [SP_TAPPED_BY_PERIOD] = "period",
                                        [SP_TAPPED_BY_FREQUENCY] = "frequency",
                                        [SP_TAPPED_BY_RESTITUTION] = "e"};
    return names[parameter];
}

sp_status sp_tapped_comment_spec(const sp_tapped_spec *c, sp_table *t, sp_error *err) {
    const bool diagram = c->output == SP_TAPPED_LYAPUNOV || c->output == SP_TAPPED_BIFURCATION;
    const char *parameter = sp_tapped_parameter_name(c->parameter);
    setting settings[] = {{true, "particles", NULL, c->particles},
                          {true, "frequency", NULL, c->frequency},
                          {true, "period", NULL, c->period},
                          {true, "taps", NULL, c->taps},
                          {true, "amplitude", NULL, c->amplitude},
                          {true, "e", NULL, c->e},
                          {true, "stiffness", NULL, sp_tapped_stiffness(c)},
                          {true, "stiffness_bound", NULL, sp_tapped_stiffness_bound(c)},
                          {true, "gravity", NULL, c->gravity},
                          {true, "drop", NULL, c->drop}};
    const setting range[] = {{diagram, "parameter", parameter, 0},
                             {diagram, "from", NULL, c->from},
                             {diagram, "to", NULL, c->to},
                             {diagram, "points", NULL, c->points},
                             {diagram, "transient", NULL, c->transient}};
    for (size_t k = 0; k < sizeof settings / sizeof *settings && diagram; k++)
        settings[k].shown = strcmp(settings[k].key, parameter) != 0; /* its values are in the rows */
    sp_status status = sp_table_add_comment(t, err, "tapped column, units cm, g, s; contact 0 is that with the floor");
    if (status == SP_OK)
        status = add_settings(t, sizeof settings / sizeof *settings, settings, err);
    if (status == SP_OK)
        status = add_list(t, "mass", c->masses, c->mass, err);
    if (status == SP_OK)
        status = add_list(t, "radius", c->radii, c->radius, err);
    if (status == SP_OK)
        status = add_solver(c, t, err);
    return status == SP_OK ? add_settings(t, sizeof range / sizeof *range, range, err) : status;
}

/* ---- results and warnings --------------------------------------------------------------------------------------- */

static sp_status warn_violation(const sp_tapped_report *r, sp_table *t, sp_error *err) {
    char pair[64], time[SP_NUMBER_TEXT];
    if (isnan(r->violated_at))
        return SP_OK;
    if (r->violated > 0)
        snprintf(pair, sizeof pair, "particles %d and %d", r->violated, r->violated + 1);
    else
        snprintf(pair, sizeof pair, "the floor and particle 1");
    return sp_table_add_comment(t, err,
                                "warning: ordering (1) violated at t = %s s between %s: their centres passed each "
                                "other, beyond which no contact law holds; a larger column.stiffness prevents it",
                                sp_number_text(r->violated_at, time), pair);
}

sp_status sp_tapped_comment_report(const sp_tapped_spec *c, const sp_tapped_report *r, sp_table *t, sp_error *err) {
    static const sp_tapped_tap none = {0};
    const sp_tapped_tap *least = &none;
    for (int32_t k = 0; k < r->taps; k++)
        if (isfinite(r->tap[k].separation) && (least == &none || r->tap[k].separation < least->separation))
            least = &r->tap[k];
    const char *error = c->model == SP_TAPPED_BSR      ? "mass_error"
                        : c->method == SP_TAPPED_EVENT ? "truncation"
                                                       : "error";
    const setting settings[] = {{least != &none, "separation", NULL, least->separation},
                                {least != &none, "separation_time", NULL, least->at},
                                {least != &none, "separation_contact", NULL, least->contact},
                                {r->events > 0, "events", NULL, (double)r->events},
                                {r->steps > 0, "steps", NULL, (double)r->steps},
                                {r->time_step > 0, "time_step", NULL, r->time_step},
                                {r->error > 0, error, NULL, r->error}};
    const sp_status status = add_settings(t, sizeof settings / sizeof *settings, settings, err);
    return status == SP_OK ? warn_violation(r, t, err) : status;
}

sp_status sp_tapped_comment_model(const sp_tapped_spec *c, sp_table *t, sp_error *err) {
    const bool all = c->output == SP_TAPPED_COMPARE;
    if ((all || c->model == SP_TAPPED_LATTICE) && c->method == SP_TAPPED_RK4)
        return sp_table_add_comment(t, err,
                                    "warning: method rk4 is of first order, since the force jumps where contacts turn, "
                                    "and creeps where they should stick: method event is exact");
    if (all || c->model != SP_TAPPED_BSR || c->bsr == SP_TAPPED_BSR_CONSERVATIVE)
        return SP_OK;
    const double force = sp_tapped_bsr_force(c, c->bsr);
    if (c->bsr == SP_TAPPED_BSR_LITERAL)
        return sp_table_add_comment(
            t, err,
            "warning: bsr = literal: the force of (45) as it was printed points downwards, and is "
            "%.5g m g at the most: the collapse of the column is its result",
            force);
    return sp_table_add_comment(t, err,
                                "warning: bsr = signed: the force of (45) with its signs put right is %.5g m g at the "
                                "most, however the column is compressed: where that is below 1, the collapse of the "
                                "column is its result",
                                force);
}
