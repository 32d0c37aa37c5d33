/* The wave after a pulse at the bottom wall, for the page: frames of the displacements, and the signal beside them. */
#include "view/parts.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/front.h>

/* Of the frames: 16-bit numbers, and for each frame the displacement (rotation) that the largest of them stands for. */
typedef struct wave {
    int32_t frames;
    double until, error;
    double *t, *length, *turn; /* [frames] */
    int16_t *u;                /* [frames][dofs] */
} wave;

enum { LEVELS = 32767, FRAMES_LEAST = 12, FRAMES_USUAL = 200 };

int32_t view_frames(int64_t dofs) {
    const double fit = 9e6 / (2 * (double)dofs); /* bytes; a third more as base64 */
    return (int32_t)fmin(FRAMES_USUAL, fmax(FRAMES_LEAST, floor(fit)));
}

static void free_wave(wave *w) {
    sp_free(w->t);
    sp_free(w->u);
}

static sp_status make_wave(const view_part *part, wave *w, sp_error *err) {
    const view_options *o = part->options;
    const int64_t dofs = sp_network_dofs(part->net);
    w->frames = o->frames > 0 ? o->frames : view_frames(dofs);
    w->until = o->signal.until > 0 ? o->signal.until
                                   : sp_signal_window(sp_packing_height(part->packing), part->packing->pressure);
    const size_t frames = (size_t)w->frames;
    w->t = sp_alloc(frames, 3 * sizeof *w->t);
    w->u = sp_alloc(frames * (size_t)dofs, sizeof *w->u);
    if (!w->t || !w->u)
        return sp_fail_memory(err, frames * (24 + 2 * (size_t)dofs));
    w->length = w->t + frames;
    w->turn = w->length + frames;
    for (int32_t l = 0; l < w->frames; l++)
        w->t[l] = w->until * l / (w->frames - 1);
    return SP_OK;
}

/* Rounds one frame. Lengths and turns have scales of their own, since their units differ. */
static void round_frame(const sp_network *net, const double *u, double *length, double *turn, int16_t *out) {
    const int64_t dofs = sp_network_dofs(net);
    *length = *turn = 0;
    for (int64_t q = 0; q < dofs; q++) {
        double *scale = q % net->dof < net->dim ? length : turn;
        *scale = fmax(*scale, fabs(u[q]));
    }
    for (int64_t q = 0; q < dofs; q++) {
        const double scale = q % net->dof < net->dim ? *length : *turn;
        out[q] = (int16_t)(scale > 0 ? lround(u[q] / scale * LEVELS) : 0);
    }
}

static sp_status find_frames(const view_part *part, wave *w, sp_error *err) {
    const int64_t dofs = sp_network_dofs(part->net);
    const sp_signal_options *signal = &part->options->signal;
    const sp_field_options spec = {.source = signal->source, .times = w->frames, .t = w->t, .threads = signal->threads};
    double *u = sp_alloc((size_t)w->frames * (size_t)dofs, sizeof *u);
    double *errors = sp_alloc((size_t)w->frames, sizeof *errors);
    sp_status status = u && errors ? sp_signal_field(part->net, &spec, u, errors, err)
                                   : sp_fail_memory(err, (size_t)w->frames * (size_t)dofs * sizeof *u);
    for (int32_t l = 0; l < w->frames && status == SP_OK; l++) {
        round_frame(part->net, u + l * dofs, &w->length[l], &w->turn[l], w->u + l * dofs);
        w->error = fmax(w->error, errors[l]);
    }
    sp_free(u);
    sp_free(errors);
    return status;
}

/* ---- the signal ------------------------------------------------------------------------------------------------- */

static void write_front(view_json *j, const sp_signal *s) {
    const sp_front_options rule = sp_front_options_default();
    sp_front front = {0};
    sp_error reason = {0};
    if (sp_front_find(s->n, s->t, s->f, &rule, &front, &reason) != SP_OK) {
        view_text(j, "front", NULL);
        return;
    }
    view_open(j, "front", '{');
    view_number(j, "t10", front.t10);
    view_number(j, "t_peak", front.t_peak);
    view_number(j, "t_zero", front.t_zero);
    view_number(j, "amplitude", front.amplitude);
    view_close(j, '}');
}

static sp_status write_signal(view_json *j, const sp_signal *s, double until, sp_error *err) {
    float *f = sp_alloc((size_t)s->n, sizeof *f);
    if (!f)
        return sp_fail_memory(err, (size_t)s->n * sizeof *f);
    for (int32_t l = 0; l < s->n; l++)
        f[l] = (float)s->f[l];
    view_open(j, "signal", '{');
    view_number(j, "until", until);
    view_text(j, "method", sp_signal_method_name(s->method));
    view_number(j, "error", s->error);
    write_front(j, s);
    view_array(j, "F", VIEW_FLOAT32, (int64_t[4]){s->n}, f);
    view_close(j, '}');
    sp_free(f);
    return SP_OK;
}

/* A packing that does not touch the top wall has a wave, but no signal. */
static sp_status add_signal(view_json *j, const view_part *part, double until, sp_error *err) {
    sp_signal_options options = part->options->signal;
    sp_signal s = sp_signal_none();
    sp_error reason = {0};
    options.until = until;
    sp_status status = SP_EREFUSED;
    if (sp_network_touches(part->net, SP_TOP))
        status = sp_signal_make(part->net, &options, &s, &reason);
    else
        sp_fail(&reason, SP_EREFUSED, "the packing touches no top wall, where the signal would be measured");
    if (status == SP_OK)
        status = write_signal(j, &s, until, err);
    else
        status = view_leave_out(j, "signal", part, false, &reason, err);
    sp_signal_free(&s);
    return status;
}

/* ---- the part --------------------------------------------------------------------------------------------------- */

static sp_status write_wave(view_json *j, const view_part *part, const wave *w, sp_error *err) {
    static const char *const sources[] = {
        [SP_SOURCE_IMPULSE] = "impulse", [SP_SOURCE_VELOCITY] = "velocity", [SP_SOURCE_DISPLACEMENT] = "displacement"};
    view_open(j, "wave", '{');
    view_text(j, "source", sources[part->options->signal.source]);
    view_number(j, "until", w->until);
    view_number(j, "error", w->error);
    view_numbers(j, "t", w->frames, w->t);
    view_numbers(j, "length", w->frames, w->length);
    view_numbers(j, "turn", w->frames, w->turn);
    view_integer(j, "levels", LEVELS);
    view_array(j, "u", VIEW_INT16, (int64_t[4]){w->frames, part->net->n, part->net->dof}, w->u);
    sp_status status = add_signal(j, part, w->until, err);
    view_close(j, '}');
    return status;
}

static sp_status compute(const view_part *part, wave *w, sp_error *reason) {
    if (!sp_network_touches(part->net, SP_BOTTOM))
        return sp_fail(reason, SP_EREFUSED, "the packing touches no bottom wall, so that no pulse can enter it there");
    sp_status status = make_wave(part, w, reason);
    return status == SP_OK ? find_frames(part, w, reason) : status;
}

sp_status view_add_wave(view_json *j, const view_part *part, sp_error *err) {
    const view_options *o = part->options;
    wave w = {0};
    sp_error reason = {0};
    if (!o->wave) {
        view_text(j, "wave", NULL);
        return SP_OK;
    }
    if (!part->net)
        return view_leave_out(j, "wave", part, o->need_wave, part->reason, err);
    sp_status status = compute(part, &w, &reason);
    if (status == SP_OK)
        status = write_wave(j, part, &w, err);
    else
        status = view_leave_out(j, "wave", part, o->need_wave, &reason, err);
    free_wave(&w);
    return status;
}
