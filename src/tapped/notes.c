/* Comments in the tables of a column: its parameters, its results and warnings. */
#include "base/base.h"
#include "tapped/column.h"
#include "tapped/table.h"

#include <stdio.h>
#include <string.h>

/* ---- what was asked for ----------------------------------------------------------------------------------------- */

static sp_status note(sp_table *t, const char *key, double value, sp_error *err) {
    char number[SP_NUMBER_TEXT];
    if (sp_table_comment_value(t, key))
        return SP_OK;
    return sp_table_add_comment(t, err, "%s = %s", key, sp_number_text(value, number));
}

static sp_status note_word(sp_table *t, const char *key, const char *word, sp_error *err) {
    return sp_table_comment_value(t, key) ? SP_OK : sp_table_add_comment(t, err, "%s = %s", key, word);
}

/* Writes one number, or a list in parentheses that is cut after SHOWN values. */
static sp_status note_list(sp_table *t, const char *key, int32_t n, const double *list, sp_error *err) {
    enum { SHOWN = 16 };
    char text[SHOWN * (SP_NUMBER_TEXT + 2) + 64], number[SP_NUMBER_TEXT];
    if (n == 1)
        return note(t, key, list[0], err);
    int used = 0;
    for (int32_t i = 0; i < n && i < SHOWN; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, "%s%s", i > 0 ? ", " : "",
                         sp_number_text(list[i], number));
    if (n > SHOWN)
        snprintf(text + used, sizeof text - (size_t)used, ", ... %d values", n);
    return sp_table_comment_value(t, key) ? SP_OK : sp_table_add_comment(t, err, "%s = (%s)", key, text);
}

static const char *model_word(const sp_tapped_spec *c) {
    static const char *const words[] = {[SP_TAPPED_LATTICE] = "lattice",
                                        [SP_TAPPED_LONGWAVE] = "longwave",
                                        [SP_TAPPED_BSR] = "bsr",
                                        [SP_TAPPED_EQ35] = "eq35",
                                        [SP_TAPPED_EQ37] = "eq37"};
    return c->output == SP_TAPPED_COMPARE ? "lattice, longwave, bsr" : words[c->model];
}

static sp_status note_solver(const sp_tapped_spec *c, sp_table *t, sp_error *err) {
    static const char *const methods[] = {
        [SP_TAPPED_EVENT] = "event", [SP_TAPPED_SMOOTH] = "smooth", [SP_TAPPED_RK4] = "rk4"};
    static const char *const bsrs[] = {[SP_TAPPED_BSR_CONSERVATIVE] = "conservative",
                                       [SP_TAPPED_BSR_LITERAL] = "literal",
                                       [SP_TAPPED_BSR_SIGNED] = "signed"};
    const bool all = c->output == SP_TAPPED_COMPARE, lattice = all || c->model == SP_TAPPED_LATTICE,
               smooth = lattice && c->method == SP_TAPPED_SMOOTH, continuum = all || c->model != SP_TAPPED_LATTICE;
    sp_status status = note_word(t, "model", model_word(c), err);
    if (status == SP_OK && lattice)
        status = note_word(t, "method", methods[c->method], err);
    if (status == SP_OK && (all || c->model == SP_TAPPED_BSR))
        status = note_word(t, "bsr", bsrs[all ? SP_TAPPED_BSR_CONSERVATIVE : c->bsr], err);
    if (status == SP_OK && (smooth || continuum))
        status = note(t, "alpha_v", c->alpha_v, err);
    if (status == SP_OK && smooth)
        status = note(t, "alpha_x", c->alpha_x, err);
    if (status == SP_OK && smooth)
        status = note(t, "tolerance", c->tolerance, err);
    return status == SP_OK && continuum ? note(t, "cells", c->cells, err) : status;
}

/* In a diagram the varied parameter itself is in the rows. */
static sp_status note_diagram(const sp_tapped_spec *c, const char *parameter, sp_table *t, sp_error *err) {
    sp_status status = note_word(t, "parameter", parameter, err);
    if (status == SP_OK)
        status = note(t, "from", c->from, err);
    if (status == SP_OK)
        status = note(t, "to", c->to, err);
    if (status == SP_OK)
        status = note(t, "points", c->points, err);
    return status == SP_OK ? note(t, "transient", c->transient, err) : status;
}

const char *sp_tapped_parameter_name(sp_tapped_parameter parameter) {
    static const char *const names[] = {[SP_TAPPED_BY_AMPLITUDE] = "amplitude",
                                        [SP_TAPPED_BY_PERIOD] = "period",
                                        [SP_TAPPED_BY_FREQUENCY] = "frequency",
                                        [SP_TAPPED_BY_RESTITUTION] = "e"};
    return names[parameter];
}

sp_status sp_tapped_note_spec(const sp_tapped_spec *c, sp_table *t, sp_error *err) {
    const bool diagram = c->output == SP_TAPPED_LYAPUNOV || c->output == SP_TAPPED_BIFURCATION;
    const char *parameter = diagram ? sp_tapped_parameter_name(c->parameter) : "";
    const struct {
        const char *key;
        double value;
    } values[] = {{"particles", c->particles},
                  {"frequency", c->frequency},
                  {"period", c->period},
                  {"taps", c->taps},
                  {"amplitude", c->amplitude},
                  {"e", c->e},
                  {"stiffness", sp_tapped_stiffness(c)},
                  {"stiffness_bound", sp_tapped_stiffness_bound(c)},
                  {"gravity", c->gravity},
                  {"drop", c->drop}};
    sp_status status = sp_table_add_comment(t, err, "tapped column, units cm, g, s; contact 0 is that with the floor");
    for (size_t k = 0; k < sizeof values / sizeof *values && status == SP_OK; k++)
        if (strcmp(values[k].key, parameter) != 0)
            status = note(t, values[k].key, values[k].value, err);
    if (status == SP_OK)
        status = note_list(t, "mass", c->masses, c->mass, err);
    if (status == SP_OK)
        status = note_list(t, "radius", c->radii, c->radius, err);
    if (status == SP_OK)
        status = note_solver(c, t, err);
    return status == SP_OK && diagram ? note_diagram(c, parameter, t, err) : status;
}

/* ---- what came of it -------------------------------------------------------------------------------------------- */

static sp_status note_violation(const sp_tapped_report *r, sp_table *t, sp_error *err) {
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

/* Name of sp_tapped_report.error in the comments. */
static const char *error_of(const sp_tapped_spec *c) {
    return c->model == SP_TAPPED_BSR ? "mass_error" : c->method == SP_TAPPED_EVENT ? "truncation" : "error";
}

sp_status sp_tapped_note_report(const sp_tapped_spec *c, const sp_tapped_report *r, sp_table *t, sp_error *err) {
    const sp_tapped_tap *least = NULL;
    for (int32_t k = 0; k < r->taps; k++)
        if (isfinite(r->tap[k].separation) && (!least || r->tap[k].separation < least->separation))
            least = &r->tap[k];
    sp_status status = SP_OK;
    if (least) {
        status = note(t, "separation", least->separation, err);
        if (status == SP_OK)
            status = note(t, "separation_time", least->at, err);
        if (status == SP_OK)
            status = note(t, "separation_contact", least->contact, err);
    }
    if (status == SP_OK && r->events > 0)
        status = note(t, "events", (double)r->events, err);
    if (status == SP_OK && r->steps > 0)
        status = note(t, "steps", (double)r->steps, err);
    if (status == SP_OK && r->time_step > 0)
        status = note(t, "time_step", r->time_step, err);
    if (status == SP_OK && r->error > 0)
        status = note(t, error_of(c), r->error, err);
    return status == SP_OK ? note_violation(r, t, err) : status;
}

sp_status sp_tapped_note_model(const sp_tapped_spec *c, sp_table *t, sp_error *err) {
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
