/* Random packings seen in a mirror, along other axes, from another origin, with other numbers and in other units: what
 * is measured in them changes as vectors and tensors do, within the errors that are reported. */
#include "properties/changes.h"
#include "properties/scenes.h"

#include <float.h>
#include <sonopack/elastic.h>
#include <sonopack/modes.h>
#include <sonopack/signal.h>

enum { GRAINS = 12, POINTS = 7 };

#ifndef SCENES
#define SCENES 150
#endif

/* What is measured in a packing. */
typedef struct measured {
    sp_network net;
    sp_modes modes;
    sp_signal down, up; /* from the bottom to the top wall, and with shear */
    sp_elasticity tensor;
    sp_statics statics;
    sp_audit audit;
    bool has_net, has_modes, has_down, has_up, has_tensor;
    sp_status refused[5];
} measured;

static bool signal_of(const sp_network *net, double until, bool shear, sp_signal *out, sp_status *status) {
    sp_signal_options o = sp_signal_options_default();
    sp_place from = sp_place_wall(), to = sp_place_wall();
    from.shear = to.shear = shear;
    o.from = &from;
    o.to = &to;
    o.sources = o.detectors = 1;
    o.points = POINTS;
    o.until = until;
    o.method = SP_SIGNAL_CHEBYSHEV;
    *status = sp_signal_make(net, &o, out, NULL);
    return *status == SP_OK;
}

/* unit: of length, see scaled(). */
static measured measure(const sp_packing *p, const sp_network_options *how, double until, double unit) {
    measured m = {.modes = sp_modes_none(), .net = sp_network_none()};
    sp_network_options o = *how;
    sp_modes_options free_of_vectors = sp_modes_options_default();
    free_of_vectors.vectors = false;
    o.threshold = how->threshold * unit * unit;
    assert_ok(sp_statics_make(p, o.threshold, 0, &m.statics, &err));
    assert_ok(sp_packing_audit(p, o.threshold, &m.audit, &err));
    m.has_net = (m.refused[0] = sp_network_make(p, &o, &m.net, NULL)) == SP_OK;
    if (!m.has_net)
        return m;
    m.has_modes = (m.refused[1] = sp_modes_dense(&m.net, &free_of_vectors, &m.modes, NULL)) == SP_OK;
    m.has_down = signal_of(&m.net, until * unit, false, &m.down, &m.refused[2]);
    m.has_up = signal_of(&m.net, until * unit, p->dim > 1, &m.up, &m.refused[3]);
    m.has_tensor = (m.refused[4] = sp_elasticity_make(&m.net, NAN, NULL, &m.tensor, NULL)) == SP_OK;
    return m;
}

static void measured_free(measured *m) {
    sp_signal_free(&m->down);
    sp_signal_free(&m->up);
    sp_modes_free(&m->modes);
    sp_network_free(&m->net);
}

/* ---- comparisons ------------------------------------------------------------------------------------------------ */

/* How a change acts: axis `of[a]` of the changed packing is axis a of the first, times sign[a]. */
typedef struct view {
    const char *name;
    int of[3];
    double sign[3], unit;
    bool upside_down, turned; /* turned: other axes, and other walls */
} view;

static void compare_modes(claims *c, const measured *a, const measured *b, const view *v) {
    const sp_zero_modes *x = &a->modes.zero, *y = &b->modes.zero;
    claims_true(c, "zero modes of every kind",
                x->rattlers == y->rattlers && x->spins == y->spins && x->rigid == y->rigid &&
                    x->mechanisms == y->mechanisms);
    claims_true(c, "as many modes", a->modes.n == b->modes.n);
    for (int64_t k = 0; k < a->modes.n && k < b->modes.n; k++)
        claims_check(c, "frequencies", fabs(a->modes.omega[k] - b->modes.omega[k] * v->unit),
                     a->modes.error[k] + b->modes.error[k] * v->unit);
}

/* Momentum k_n, displacement k_n t/m, force k_n^2 t/m: the same in all units of length. */
static void compare_signals(claims *c, const char *name, const sp_signal *a, const sp_signal *b) {
    for (int q = 0; q < a->n; q++)
        claims_check(c, name, fabs(a->f[q] - b->f[q]), a->errors[0] + b->errors[0]);
}

static int voigt(int dim, int i, int j) { return i == j ? i : dim == 2 ? 2 : 6 - i - j; }

/* C_ijkl of the first is C of the changed one with other indices and signs. Shear strains are du_1/dx_2: along other
 * axes they differ by a turn of the whole, which springs across contacts feel by the overlap, and prestress too. In two
 * dimensions a stress is a force over a length times the unit of length. */
static void compare_tensors(claims *c, const measured *a, const measured *b, const view *v, int dim) {
    for (int q = 0; q < dim * dim * dim * dim; q++) {
        int of[4], to[4];
        double sign = 1;
        for (int k = 0, rest = q; k < 4; k++, rest /= dim) {
            of[k] = rest % dim;
            to[k] = v->of[of[k]];
            sign *= v->sign[of[k]];
        }
        const int r = voigt(dim, of[0], of[1]), s = voigt(dim, of[2], of[3]), x = voigt(dim, to[0], to[1]),
                  y = voigt(dim, to[2], to[3]);
        const bool known = !isnan(a->tensor.c[r][s]), shear = of[0] != of[1] || of[2] != of[3];
        const double factor = sign / pow(v->unit, 3 - dim);
        if (v->turned && shear && (a->net.dof > a->net.dim || a->net.prestress))
            continue;
        claims_true(c, "the same moduli exist", known == !isnan(b->tensor.c[x][y]));
        if (known)
            claims_check(c, "moduli as a tensor", fabs(a->tensor.c[r][s] - factor * b->tensor.c[x][y]),
                         a->tensor.error[r][s] + fabs(factor) * b->tensor.error[x][y]);
    }
}

static double stress_of(const sp_statics *s, int dim, int i, int j) {
    const double all[3][3] = {{s->s_xx, s->s_xy, s->s_xz}, {s->s_xy, s->s_yy, s->s_yz}, {s->s_xz, s->s_yz, s->s_zz}};
    return i < dim && j < dim ? all[i][j] : 0;
}

static void compare_statics(claims *c, const measured *a, const measured *b, const view *v, const sp_packing *p) {
    const double small = 100 * DBL_EPSILON * (1 + p->n_contacts);
    double size = 0;
    for (int i = 0; i < p->dim; i++)
        size = fmax(size, fabs(stress_of(&a->statics, p->dim, i, i)));
    for (int i = 0; i < p->dim; i++)
        for (int j = 0; j < p->dim; j++)
            claims_check(
                c, "stress as a tensor",
                fabs(stress_of(&a->statics, p->dim, i, j) - v->sign[i] * v->sign[j] / pow(v->unit, 3 - p->dim) *
                                                                stress_of(&b->statics, p->dim, v->of[i], v->of[j])),
                small * size);
    claims_true(c, "rattlers", a->audit.rattlers == b->audit.rattlers && a->audit.carrying == b->audit.carrying);
    if (!isnan(a->statics.zs) || !isnan(b->statics.zs))
        claims_check(c, "coordination", fabs(a->statics.zs - b->statics.zs), small);
    claims_check(c, "residual of forces", fabs(a->audit.force_residual - b->audit.force_residual),
                 small * (1 + a->audit.force_residual));
}

static void compare(claims *c, const sp_packing *p, const measured *a, const measured *b, const view *v) {
    for (int k = 0; k < 5; k++)
        /* moduli are refused along the up axis; where prestress makes motions grow, rounding decides what is noticed;
         * the bounds of a signal's error that exceed the tolerance are not those of the way back */
        if (k < 2 || !(v->turned || v->upside_down || a->net.prestress))
            claims_true(c,
                        k == 0   ? "the same networks are refused"
                        : k == 1 ? "the same modes are refused"
                        : k == 4 ? "the same moduli are refused"
                                 : "the same signals are refused",
                        a->refused[k] == b->refused[k]);
    compare_statics(c, a, b, v, p);
    if (a->has_modes && b->has_modes)
        compare_modes(c, a, b, v);
    if (a->has_tensor && b->has_tensor)
        compare_tensors(c, a, b, v, p->dim);
    if (v->turned || (a->net.prestress && !a->net.carried && !a->has_modes))
        return; /* other axes; a motion that grows, and rounding errors with it */
    if (a->has_down && b->has_down)
        compare_signals(c, v->upside_down ? "reciprocity" : "signals", &a->down, &b->down);
    if (a->has_up && b->has_up)
        compare_signals(c, v->upside_down ? "reciprocity of shear" : "signals of shear", &a->up, &b->up);
}

/* ---- scenes ----------------------------------------------------------------------------------------------------- */

static void look(claims *c, const sp_packing *p, sp_packing q, const sp_network_options *how, double until,
                 const measured *a, view v) {
    char words[300];
    const char *kept = c->words;
    sp_error why = {0};
    snprintf(words, sizeof words, "%s: %s", v.name, kept);
    c->words = words;
    const sp_status status = sp_packing_check(&q, &why);
    claims_true(c, "the view is a packing", status == SP_OK);
    if (status == SP_OK) {
        measured b = measure(&q, how, until, v.unit);
        compare(c, p, a, &b, &v);
        measured_free(&b);
    }
    c->words = kept;
    sp_packing_free(&q);
}

static void views(claims *c, const sp_packing *p, const sp_network_options *how, sp_random *draw) {
    const view same = {"", {0, 1, 2}, {1, 1, 1}, 1, false, false};
    const double until = between(draw, 1, 60);
    const bool straight = p->tilt[0] == 0 && p->tilt[1] == 0 && p->tilt[2] == 0;
    RELEASED int32_t *to = calloc((size_t)p->n, sizeof *to);
    measured a = measure(p, how, until, 1);
    view v = same;
    for (int axis = 0; axis < p->dim; axis++) {
        v = same;
        v.name = axis == p->dim - 1 ? "upside down" : "mirrored";
        v.sign[axis] = -1;
        v.upside_down = axis == p->dim - 1;
        if (!v.upside_down || !a.net.carried)
            look(c, p, mirrored(p, axis), how, until, &a, v);
    }
    for (int k = 0; k < p->dim && straight; k++) {
        const int x = k == 2 ? 1 : 0, y = k == 0 ? 1 : 2;
        if (y >= p->dim || (p->cell == SP_CELL_PISTON && y == p->dim - 1))
            continue;
        v = same;
        v.name = "swapped";
        v.of[x] = y;
        v.of[y] = x;
        v.turned = true;
        look(c, p, swapped(p, x, y), how, until, &a, v);
    }
    v = same;
    v.name = "shifted";
    look(c, p, shifted(p, draw), how, until, &a, v);
    v.name = "renumbered";
    look(c, p, renumbered(p, draw, to), how, until, &a, v);
    v.name = "scaled";
    v.unit = 4;
    look(c, p, scaled(p, 4), how, until, &a, v);
    measured_free(&a);
}

static void run(claims *c, sp_random *draw) {
    scene s = scene_draw(draw, GRAINS);
    sp_error why = {0};
    c->words = s.words;
    if (sp_packing_check(&s.p, &why) == SP_OK)
        views(c, &s.p, &s.how, draw);
    sp_packing_free(&s.p);
}

TEST(test_views) {
    claims c = {0};
    claims_scenes(&c, SCENES, run);
    claims_close(&c);
}

RUN_TESTS(NULL, NULL)
