/* Grains of several materials: the law of their contacts (Johnson, Contact Mechanics, 1985, sections 4.2 and 7.2),
 * their masses, and which grain has which. */
#include "packing/types.h"

#include "base/base.h"
#include "packing/contact.h"

#include <math.h>
#include <string.h>

/* Specs are resolved before they are checked: lists may be too short. */
static double of_type(const double *list, int32_t count, int type, double usual) {
    return list && type < count ? list[type] : usual;
}

/* The place of a pair in packing.types.friction: the rows of the upper triangle. */
static int pair_place(int types, int s, int t) {
    const int low = s < t ? s : t, high = s < t ? t : s;
    return low * types - low * (low - 1) / 2 + high - low;
}

static double friction_of(const sp_pack_spec *spec, int s, int t) {
    return spec->types.friction ? spec->types.friction[pair_place(sp_types_count(spec), s, t)] : spec->friction;
}

bool sp_types_mixed(const sp_pack_spec *s) {
    return s->types.moduli > 0 || s->types.poissons > 0 || s->types.frictions > 0;
}

/* ---- check ------------------------------------------------------------------------------------------------------- */

sp_status sp_types_check_counts(const sp_pack_spec *s, sp_error *err) {
    const sp_types *t = &s->types;
    const int n = t->fractions;
    if (n < 0 || n > SP_TYPES_MAX || (n > 0 && !t->fraction))
        return sp_fail_key(err, SP_EINVAL, "packing.types.fraction", " = (%d numbers): must be at most %d", n,
                           SP_TYPES_MAX);
    const struct {
        const char *key;
        int32_t count, right;
        const double *list;
    } lists[] = {{"packing.types.diameter", t->diameters, n, t->diameter},
                 {"packing.types.modulus", t->moduli, n, t->modulus},
                 {"packing.types.poisson", t->poissons, n, t->poisson},
                 {"packing.types.density", t->densities, n, t->density},
                 {"packing.types.friction", t->frictions, n * (n + 1) / 2, t->friction}};
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++)
        if ((lists[k].count != 0 && (lists[k].count != lists[k].right || !lists[k].list)) ||
            (lists[k].count == 0 && lists[k].list))
            return sp_fail_key(err, SP_EINVAL, lists[k].key,
                               " = (%d numbers): must be none, or %d for the %d materials of packing.types.fraction%s",
                               lists[k].count, lists[k].right, n, n > 0 ? "" : ", which must be given");
    return SP_OK;
}

static sp_status check_fractions(const sp_pack_spec *s, sp_error *err) {
    double sum = 0;
    for (int t = 0; t < s->types.fractions; t++)
        sum += s->types.fraction[t];
    if (s->types.fractions > 0 && !(fabs(sum - 1) < 1e-9))
        return sp_fail_key(err, SP_EINVAL, "packing.types.fraction", ": its sum is %.10g, must be 1", sum);
    if ((s->sizes == SP_SIZES_TYPES) != (s->types.diameters > 0))
        return sp_fail_key(err, SP_EINVAL, s->types.diameters > 0 ? "packing.sizes" : "packing.types.diameter",
                           s->types.diameters > 0 ? ": must be \"types\" where packing.types.diameter is given"
                                                  : ": must be given with packing.sizes = \"types\"");
    return SP_OK;
}

sp_status sp_types_check(const sp_pack_spec *s, sp_error *err) {
    sp_status status = check_fractions(s, err);
    if (status != SP_OK)
        return status;
    const bool some = s->types.fractions > 0;
    const char *key = some ? "packing.types.fraction" : "packing.shape";
    if ((some || s->shape != SP_SHAPE_SPHERE) && s->kind != SP_PACK_PISTON && s->kind != SP_PACK_MINIMUM)
        return sp_fail_key(err, SP_EINVAL, key,
                           ": must not be given except for packing.kind = \"piston\" and \"minimum\"");
    if (s->shape == SP_SHAPE_DISK && s->dim != 2)
        return sp_fail_key(err, SP_EINVAL, key, " = \"disk\": must be \"sphere\" in packing.dimension = %d", s->dim);
    if (some && s->tangential != SP_TANGENTIAL_CONSTANT)
        return sp_fail_key(err, SP_EINVAL, "packing.tangential",
                           " = \"history\": must be \"constant\" with packing.types");
    if (some && s->content)
        return sp_fail_key(err, SP_EINVAL, key, ": must not be given with packing.file");
    double most = 0;
    for (int k = 0; k < s->types.frictions; k++)
        most = fmax(most, s->types.friction[k]);
    if (s->types.frictions > 0 && s->friction != most)
        return sp_fail_key(err, SP_EINVAL, "packing.friction",
                           " = %.10g: must be the largest of packing.types.friction, %.10g", s->friction, most);
    return SP_OK;
}

/* ---- law --------------------------------------------------------------------------------------------------------- */

contact_rule sp_types_rule(const sp_pack_spec *spec, int s, int t) {
    const sp_types *all = &spec->types;
    const int other = t < 0 ? s : t;
    const double e1 = of_type(all->modulus, all->moduli, s, 1), e2 = of_type(all->modulus, all->moduli, other, 1);
    const double nu1 = of_type(all->poisson, all->poissons, s, spec->poisson),
                 nu2 = of_type(all->poisson, all->poissons, other, spec->poisson);
    const double g = 2 / ((2 - nu1) / (e1 * (1 - nu1)) + (2 - nu2) / (e2 * (1 - nu2))); /* 4 G12, G = E* (1 - nu)/2 */
    contact_rule r = {.stiffness = e1 == e2 ? e1 : 2 / (1 / e1 + 1 / e2),               /* 2 E12 */
                      .eta = e1 == e2 && nu1 == nu2 ? contact_eta(nu1) : g * (1 / e1 + 1 / e2),
                      .friction = friction_of(spec, s, other)};
    if (!(r.friction > 0))
        r.eta = 0;
    r.sqrt_eta = sqrt(r.eta);
    return r;
}

sp_types_range sp_types_limits(const sp_pack_spec *spec) {
    sp_types_range all = {.lightest = INFINITY, .softest = INFINITY};
    for (int t = 0; t < sp_types_count(spec); t++) {
        const double density = of_type(spec->types.density, spec->types.densities, t, 1);
        const double modulus = of_type(spec->types.modulus, spec->types.moduli, t, 1);
        all.densest = fmax(all.densest, density);
        all.lightest = fmin(all.lightest, density);
        all.stiffest = fmax(all.stiffest, modulus);
        all.softest = fmin(all.softest, modulus);
    }
    return all;
}

double sp_types_mass(const sp_pack_spec *spec, int type, double r) {
    const double m = spec->shape == SP_SHAPE_DISK ? 3.14159265358979323846 * r * r : grain_mass(r);
    return of_type(spec->types.density, spec->types.densities, type, 1) * m;
}

/* ---- grains ------------------------------------------------------------------------------------------------------ */

sp_type_draw sp_types_begin(const sp_pack_spec *spec) {
    sp_type_draw draw = {.stream = sp_random_make(spec->seed, SP_STREAM_TYPES), .grains = spec->grains};
    int32_t before = 0;
    double sum = 0;
    for (int t = 0; t < spec->types.fractions; t++) {
        sum += spec->types.fraction[t];
        const bool last = t == spec->types.fractions - 1;
        const int32_t upto = last ? spec->grains : (int32_t)floor(fmin(1, sum) * spec->grains + 0.5);
        draw.left[t] = upto - before;
        before = upto;
    }
    return draw;
}

int sp_types_next(sp_type_draw *draw) {
    int64_t place = (int64_t)sp_random_below(&draw->stream, (uint64_t)draw->grains--);
    int t = 0;
    while (place >= draw->left[t])
        place -= draw->left[t++];
    draw->left[t]--;
    return t;
}

int32_t *sp_types_draw(const sp_pack_spec *spec) {
    int32_t *type = sp_alloc((size_t)spec->grains, sizeof *type);
    sp_type_draw draw = sp_types_begin(spec);
    for (int32_t i = 0; type && spec->types.fractions > 0 && i < spec->grains; i++)
        type[i] = sp_types_next(&draw);
    return type;
}

/* F = c n^a has the stiffness a F/n. */
static void own_stiffness(const sp_pack_spec *spec, const int32_t *type, sp_contact *c) {
    const contact_rule rule = sp_types_rule(spec, type[c->i], c->j < 0 ? -1 : type[c->j]);
    const double a = c->j < 0 ? 1.5 : spec->law_exponent;
    c->kn = a * c->fn / c->overlap;
    c->kt = rule.eta * c->kn;
    c->mu = spec->types.frictions > 0 ? rule.friction : 0;
}

sp_status sp_types_finish(const sp_pack_spec *spec, const int32_t *type, sp_packing *p, sp_error *err) {
    if (sp_types_mixed(spec) || spec->law_exponent != 1.5)
        for (int32_t c = 0; c < p->n_contacts; c++)
            own_stiffness(spec, type, &p->contacts[c]);
    const bool balls = spec->shape == SP_SHAPE_SPHERE && spec->types.densities == 0;
    sp_status status = balls ? SP_OK : sp_packing_alloc_masses(p, err);
    for (int32_t i = 0; i < p->n && status == SP_OK && !balls; i++) {
        p->mass[i] = sp_types_mass(spec, type[i], p->r[i]);
        p->inertia[i] = sp_types_inertia(spec) * p->mass[i] * (p->r[i] * p->r[i]);
    }
    if (status == SP_OK && spec->types.fractions > 0)
        status = sp_packing_alloc_species(p, err);
    if (status == SP_OK && p->species)
        memcpy(p->species, type, (size_t)p->n * sizeof *type);
    return status;
}
