/* The dashpots of the contacts as a network whose K is the damping matrix C. */
#include "base/base.h"
#include "base/text.h"
#include "network/bound.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void *copy(const void *from, size_t count, size_t size) {
    void *to = sp_alloc(count, size);
    if (to)
        memcpy(to, from, count * size);
    return to;
}

/* Copies what the networks do not share. */
static sp_status copy_network(const sp_network *net, sp_network *c, sp_error *err) {
    const size_t n = (size_t)net->n, springs = (size_t)net->n_springs;
    *c = *net;
    c->grain = copy(net->grain, n, sizeof *c->grain);
    c->mass = copy(net->mass, n * (size_t)net->dof, sizeof *c->mass);
    c->x = copy(net->x, 3 * n, sizeof *c->x);
    c->r = copy(net->r, n, sizeof *c->r);
    c->springs = copy(net->springs, springs, sizeof *c->springs);
    c->length = copy(net->length, springs, sizeof *c->length);
    c->carried = NULL;
    c->prestress = false;
    if (!c->grain || !c->mass || !c->x || !c->r || !c->springs || !c->length)
        return sp_fail_memory(err, n * (size_t)(net->dof + 5) * sizeof(double) + springs * sizeof *c->springs);
    return SP_OK;
}

static double reduced_mass(const sp_network *net, const sp_spring *s) {
    const double mi = net->mass[(int64_t)s->i * net->dof];
    const double mj = s->j >= 0 ? net->mass[(int64_t)s->j * net->dof] : HUGE_VAL;
    return s->j >= 0 ? mi / (mi + mj) * mj : mi;
}

/* Replaces stiffnesses by the coefficients of dashpots. Without rotations a tangential dashpot acts on the transverse
 * velocity of the centres, which is the place of the prestress's stiffness. */
static void set_dashpot(const sp_damping *law, double reduced, bool rotations, int dim, sp_spring *s) {
    s->kp = 0;
    if (law->kind == SP_DAMPING_ZETA) {
        s->kn = 2 * law->value * sqrt(reduced * s->kn);
        s->kt = 2 * law->value * sqrt(reduced * s->kt);
        return;
    }
    const double c = law->kind == SP_DAMPING_MASS ? law->value * reduced : law->value;
    s->kn = c;
    s->kt = rotations ? law->ratio * c : 0;
    s->kp = rotations || dim < 2 ? 0 : law->ratio * c;
}

static sp_status check_law(const sp_damping *law, sp_error *err) {
    if (law->kind != SP_DAMPING_ZETA && law->kind != SP_DAMPING_GAMMA && law->kind != SP_DAMPING_MASS)
        return sp_fail(err, SP_EINVAL, "kind of damping %d, must be zeta, gamma or mass", (int)law->kind);
    if (!(law->value > 0 && isfinite(law->value)))
        return sp_fail(err, SP_EINVAL, "damping = %g, must be %s above 0", law->value,
                       law->kind == SP_DAMPING_ZETA ? "a fraction of critical damping" : "a coefficient");
    if (law->kind != SP_DAMPING_ZETA && !(law->ratio >= 0 && isfinite(law->ratio)))
        return sp_fail(err, SP_EINVAL, "damping: tangential over normal coefficient = %g, must be 0 or more",
                       law->ratio);
    return SP_OK;
}

sp_status sp_network_dashpots(const sp_network *net, const sp_damping *law, sp_network *out, sp_error *err) {
    sp_network c = sp_network_none();
    sp_status status = check_law(law, err);
    if (status != SP_OK)
        return status;
    status = copy_network(net, &c, err);
    for (int32_t k = 0; k < net->n_springs && status == SP_OK; k++) {
        sp_spring *s = &c.springs[k];
        set_dashpot(law, reduced_mass(net, s), net->dof > net->dim, net->dim, s);
        c.prestress = c.prestress || s->kp != 0;
    }
    if (status == SP_OK)
        status = sp_network_find_bounds(&c, err);
    if (status == SP_OK)
        *out = c;
    else
        sp_network_free(&c);
    return status;
}

sp_status sp_network_damping(const sp_network *net, double zeta, sp_network *out, sp_error *err) {
    const sp_damping law = {.kind = SP_DAMPING_ZETA, .value = zeta};
    return sp_network_dashpots(net, &law, out, err);
}

/* A decimal number up to `end` or a colon; false for anything else. */
static bool read_number(const char **text, double *out) {
    const size_t length = strspn(*text, "0123456789+-.eE");
    char *end = NULL;
    sp_locale locale = sp_locale_enter();
    *out = length > 0 ? strtod(*text, &end) : NAN;
    sp_locale_leave(&locale);
    if (!end || end != *text + length || (*end != '\0' && *end != ':') || !isfinite(*out))
        return false;
    *text = *end == ':' ? end + 1 : end;
    return *end == '\0' || end[1] != '\0';
}

sp_status sp_damping_read(const char *text, sp_damping *out, sp_error *err) {
    static const char *const words[] = {"zeta:", "gamma:", "mass:"};
    sp_damping law = {.ratio = 1};
    const char *at = text;
    for (int k = 0; k < 3; k++)
        if (strncmp(text, words[k], strlen(words[k])) == 0) {
            law.kind = (sp_damping_kind)k;
            at = text + strlen(words[k]);
        }
    double tangential = 0;
    bool ok = read_number(&at, &law.value) && law.value >= 0;
    if (ok && *at && law.kind != SP_DAMPING_ZETA && law.value > 0) {
        ok = read_number(&at, &tangential) && tangential >= 0;
        law.ratio = tangential / law.value;
    }
    if (!ok || *at || !isfinite(law.ratio))
        return sp_fail(err, SP_EINVAL,
                       "damping %.60s: must be a fraction of critical damping, gamma:C[:CT] or mass:RATE[:RATET], "
                       "with numbers of 0 or more",
                       text);
    *out = law;
    return SP_OK;
}
