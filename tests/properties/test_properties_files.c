/* Random packings of every kind written to each of the program's own forms and read: the same numbers. */
#include "properties/changes.h"
#include "properties/scenes.h"

#include <float.h>
#include <sonopack/study/store.h>
#include <unistd.h>

#ifndef SCENES
#define SCENES 60
#endif

static char folder[] = "/tmp/sonopack-properties-XXXXXX";

static void check_same(claims *c, const sp_packing *p, const sp_packing *q) {
    claims_true(c, "the same cell",
                p->dim == q->dim && p->n == q->n && p->n_contacts == q->n_contacts && p->cell == q->cell &&
                    p->wall == q->wall && memcmp(p->box, q->box, sizeof p->box) == 0 &&
                    memcmp(p->tilt, q->tilt, sizeof p->tilt) == 0);
    claims_check(c, "pressure, friction, nu, gravity",
                 fabs(p->pressure - q->pressure) + fabs(p->friction - q->friction) + fabs(p->poisson - q->poisson) +
                     fabs(p->gravity - q->gravity),
                 0);
    if (p->n != q->n || p->n_contacts != q->n_contacts)
        return;
    double off = 0;
    for (int32_t i = 0; i < 3 * p->n; i++)
        off = fmax(off, fabs(p->x[i] - q->x[i]) + fabs(p->r[i / 3] - q->r[i / 3]));
    claims_check(c, "centres and radii", off, 0);
    claims_true(c, "masses of their own", !p->mass == !q->mass);
    for (int32_t i = 0; i < p->n && p->mass && q->mass; i++)
        claims_check(c, "masses", fabs(p->mass[i] - q->mass[i]) + fabs(p->inertia[i] - q->inertia[i]), 0);
}

/* In two dimensions text has F_t as a number along (-ny, nx), which rounds it. */
static void check_contacts(claims *c, const sp_packing *p, const sp_packing *q, double rounding) {
    for (int32_t k = 0; k < p->n_contacts && p->n_contacts == q->n_contacts; k++) {
        const sp_contact *a = &p->contacts[k], *b = &q->contacts[k];
        double off = fabs(a->overlap - b->overlap) + fabs(a->fn - b->fn) + fabs(a->kn - b->kn) + fabs(a->kt - b->kt);
        double turned = 0, size = 0;
        for (int d = 0; d < 3; d++) {
            off += fabs(a->n[d] - b->n[d]);
            turned = fmax(turned, fabs(a->ft[d] - b->ft[d]));
            size = fmax(size, fabs(a->ft[d]));
        }
        claims_check(c, "contacts", a->i == b->i && a->j == b->j ? off : NAN, 0);
        claims_check(c, "tangential forces", turned, rounding * size);
    }
}

static sp_status written(int form, const sp_packing *p, sp_packing *q, sp_error *why) {
    char path[64];
    snprintf(path, sizeof path, "%s/one", folder);
    sp_status status = form == 0 ? sp_packing_save(p, path, why) : sp_packing_save_text(p, path, why);
    if (status == SP_OK)
        status = sp_packing_read(path, q, why);
    unlink(path);
    return status;
}

static void run(claims *c, sp_random *draw) {
    static const char *const names[] = {"HDF5", "text"};
    scene s = scene_draw(draw, 12);
    sp_error why = {0};
    c->words = s.words;
    for (int form = 0; form < 2 && sp_packing_check(&s.p, &why) == SP_OK; form++) {
        FREED(sp_packing) q = sp_packing_none();
        if (form == 1 && (s.p.mass || sp_packing_has_stiffnesses(&s.p)))
            continue; /* text has no place for these */
        if (claims_served(c, names[form], written(form, &s.p, &q, &why), &why)) {
            check_same(c, &s.p, &q);
            check_contacts(c, &s.p, &q, form > 0 && s.p.dim == 2 ? 4 * DBL_EPSILON : 0);
        }
    }
    sp_packing_free(&s.p);
}

TEST(test_files) {
    claims c = {0};
    assert_non_null(mkdtemp(folder));
    claims_scenes(&c, SCENES, run);
    assert_int_equal(rmdir(folder), 0);
    claims_close(&c);
}

RUN_TESTS(NULL, NULL)
