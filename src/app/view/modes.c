/* The softest modes of a packing, for the page. */
#include "view/parts.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/modes.h>

enum { ALL_MAX = 6000 }; /* degrees of freedom of a network whose modes are all computed if it has too few to choose */

/* Rows of `modes' that are shown, from the softest that is no zero mode. */
typedef struct chosen {
    sp_modes modes;
    int64_t row, count;
} chosen;

static sp_status too_many(const view_options *o, int64_t count, sp_error *err) {
    return sp_fail(err, count > 0 ? SP_EINVAL : SP_EREFUSED,
                   "modes %lld to %lld: there are only %lld modes that are no zero modes", (long long)o->first,
                   (long long)o->last, (long long)count);
}

/* All modes of a small network, which has fewer than are asked for. */
static sp_status choose_of_all(const view_part *part, const sp_modes_options *options, chosen *c, sp_error *err) {
    const view_options *o = part->options;
    const sp_modes_range all = sp_modes_range_all();
    sp_status status = sp_modes_make(part->net, options, &all, &c->modes, err);
    if (status != SP_OK)
        return status;
    const int64_t count = c->modes.n - c->modes.n_zero;
    if (count == 0 || (part->options->need_modes && o->last >= count) || o->first >= count)
        return too_many(o, count, err);
    c->row = c->modes.n_zero + o->first;
    c->count = (o->last < count ? o->last + 1 : count) - o->first;
    return SP_OK;
}

static sp_status choose(const view_part *part, chosen *c, sp_error *err) {
    sp_modes_options options = sp_modes_options_default();
    const view_options *o = part->options;
    const sp_modes_range lowest = sp_modes_range_lowest(o->last + 1);
    options.threads = o->signal.threads;
    options.source = o->signal.source;
    sp_status status =
        o->last < sp_network_dofs(part->net) ? sp_modes_make(part->net, &options, &lowest, &c->modes, err) : SP_EINVAL;
    if (status == SP_EINVAL && sp_network_dofs(part->net) <= ALL_MAX)
        return choose_of_all(part, &options, c, err);
    if (status == SP_EINVAL)
        return sp_fail(err, SP_EINVAL, "modes %lld to %lld: %lld degrees of freedom have fewer modes",
                       (long long)o->first, (long long)o->last, (long long)sp_network_dofs(part->net));
    c->row = o->first;
    c->count = o->last + 1 - o->first;
    return status;
}

/* u = M^(-1/2) e, as in tables of `sonopack modes --vectors'. */
static void find_displacements(const sp_network *net, const chosen *c, float *u) {
    const int64_t dofs = sp_network_dofs(net);
    for (int64_t k = 0; k < c->count; k++) {
        const double *e = c->modes.vectors + (c->row + k - c->modes.n_rattler) * dofs;
        for (int64_t q = 0; q < dofs; q++)
            u[k * dofs + q] = (float)(e[q] / sqrt(net->mass[q]));
    }
}

static void write_rows(view_json *j, const sp_network *net, const chosen *c) {
    view_open(j, "rows", '[');
    for (int64_t k = 0; k < c->count; k++) {
        const int64_t row = c->row + k;
        view_open(j, NULL, '{');
        view_integer(j, "number", c->modes.first + row);
        view_number(j, "omega", c->modes.omega[row]);
        view_number(j, "omega_error", c->modes.error[row]);
        view_number(j, "participation", c->modes.participation[row]);
        view_number(j, "vector_error", sp_modes_vector_error(&c->modes, net, row));
        view_close(j, '}');
    }
    view_close(j, ']');
}

static sp_status write_modes(view_json *j, const view_part *part, const chosen *c, sp_error *err) {
    const sp_network *net = part->net;
    const int64_t dofs = sp_network_dofs(net);
    float *u = sp_alloc((size_t)(c->count * dofs), sizeof *u);
    if (!u)
        return sp_fail_memory(err, (size_t)(c->count * dofs) * sizeof *u);
    find_displacements(net, c, u);
    view_open(j, "modes", '{');
    view_integer(j, "first", part->options->first);
    view_integer(j, "zero_modes", c->modes.zero.total);
    write_rows(j, net, c);
    view_array(j, "u", VIEW_FLOAT32, (int64_t[4]){c->count, net->n, net->dof}, u);
    view_close(j, '}');
    sp_free(u);
    return SP_OK;
}

sp_status view_add_modes(view_json *j, const view_part *part, sp_error *err) {
    const view_options *o = part->options;
    chosen c = {.modes = sp_modes_none()};
    sp_error reason = {0};
    if (!o->modes) {
        view_text(j, "modes", NULL);
        return SP_OK;
    }
    if (!part->net)
        return view_leave_out(j, "modes", part, o->need_modes, part->reason, err);
    sp_status status = choose(part, &c, &reason);
    if (status == SP_OK)
        status = write_modes(j, part, &c, err);
    else
        status = view_leave_out(j, "modes", part, o->need_modes, &reason, err);
    sp_modes_free(&c.modes);
    return status;
}
