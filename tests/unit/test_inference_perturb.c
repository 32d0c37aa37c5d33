/* Packings drawn with errors of measurement. */
#include "packing/geometry.h"
#include "reference.h"
#include "signals.h"

#include <sonopack/uncertainty.h>

#define SMALL REFERENCE("packing_N200_p1e-4.txt")

static sp_packing drawn(const sp_packing *p, const sp_errors *e, int64_t sample) {
    sp_packing q = sp_packing_none();
    assert_ok(sp_packing_perturb(p, e, 7, sample, &q, &err));
    return q;
}

/* Without errors both kinds of measurements give the packing back, by the digits of its file. */
TEST(test_exact) {
    FREED(sp_packing) p = reference_packing(SMALL);
    for (int kind = 0; kind < 2; kind++) {
        sp_errors e = sp_errors_default();
        e.measured = kind == 0 ? SP_MEASURED_FORCES : SP_MEASURED_OVERLAPS;
        e.position = e.radius = e.stiffness = e.false_part = 0.1; /* of sample -1 they do not count */
        FREED(sp_packing) q = drawn(&p, &e, -1);
        assert_int_equal(q.n_contacts, p.n_contacts);
        for (int k = 0; k < p.n_contacts; k++) {
            const sp_contact *a = &p.contacts[k], *b = &q.contacts[k];
            assert_true(a->i == b->i && a->j == b->j);
            assert_relative(b->overlap, a->overlap, 1e-9);
            assert_relative(b->fn, a->fn, 1e-9);
            assert_relative(contact_kn(&q, b), contact_kn(&p, a), 1e-9);
            for (int c = 0; c < 2; c++) {
                assert_close(b->n[c], a->n[c], 1e-12);
                assert_close(b->ft[c], a->ft[c], 1e-9 * p.pressure);
            }
        }
    }
}

/* What each error does, in its distribution: 200 grains and 40 draws give 16000 coordinates. */
TEST(test_distributions) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_errors e = sp_errors_default();
    double moved = 0, grown = 0, force = 0, force_square = 0;
    int64_t coordinates = 0, radii = 0, forces = 0, listed = 0;
    e.position = 0.02;
    e.radius = 0.01;
    e.force = 0.3;
    e.false_part = 0.1;
    for (int s = 0; s < 40; s++) {
        FREED(sp_packing) q = drawn(&p, &e, s);
        for (int i = 0; i < p.n; i++, radii++) {
            for (int a = 0; a < 2; a++, coordinates++)
                moved += pow(q.x[3 * i + a] - p.x[3 * i + a], 2);
            assert_true(q.x[3 * i + 2] == 0);
            grown += pow(q.r[i] - p.r[i], 2);
        }
        for (int k = 0, m = 0; k < q.n_contacts; k++, forces++) {
            while (p.contacts[m].i != q.contacts[k].i || p.contacts[m].j != q.contacts[k].j)
                m++;
            const double l = log(q.contacts[k].fn / p.contacts[m].fn);
            force += l;
            force_square += l * l;
            const double e12 = contact_stiffness_in(&q, q.contacts[k].i, q.contacts[k].j);
            assert_relative(q.contacts[k].kn, contact_normal_stiffness(e12, contact_overlap(e12, q.contacts[k].fn)),
                            1e-12);
        }
        listed += p.n_contacts;
    }
    const double c = (double)coordinates, r = (double)radii, f = (double)forces;
    assert_relative(sqrt(moved / c), 0.02, 4 / sqrt(2 * c)); /* four standard errors each */
    assert_relative(sqrt(grown / r), 0.01, 4 / sqrt(2 * r));
    assert_close(force / f, 0, 4 * 0.3 / sqrt(f));
    assert_relative(sqrt(force_square / f), 0.3, 4 / sqrt(2 * f));
    assert_close(f / (double)listed, 0.9, 4 * sqrt(0.09 / (double)listed));
}

/* Factors of median 1 have another mean; the same draw with the mean 1 is smaller by one common factor. */
TEST(test_mean_one) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_errors e = sp_errors_default();
    e.force = 0.4;
    FREED(sp_packing) median = drawn(&p, &e, 1);
    e.mean_one = true;
    FREED(sp_packing) mean = drawn(&p, &e, 1);
    for (int k = 0; k < p.n_contacts; k++)
        assert_relative(median.contacts[k].fn / mean.contacts[k].fn, exp(0.08), 1e-12);
}

/* The same sample of half the error is half as far away. */
TEST(test_nested) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_errors e = sp_errors_default();
    e.position = 1e-3;
    e.stiffness = 0.2;
    FREED(sp_packing) far = drawn(&p, &e, 3);
    e.position /= 2;
    e.stiffness /= 2;
    FREED(sp_packing) near = drawn(&p, &e, 3);
    for (int i = 0; i < 3 * p.n; i++)
        assert_close(near.x[i] - p.x[i], 0.5 * (far.x[i] - p.x[i]), 1e-14);
    for (int k = 0; k < p.n_contacts; k++) {
        const double kn = contact_kn(&p, &p.contacts[k]);
        assert_close(log(near.contacts[k].kn / kn), 0.5 * log(far.contacts[k].kn / kn), 1e-9);
        assert_relative(near.contacts[k].kt, contact_eta(p.poisson) * near.contacts[k].kn, 1e-12);
    }
}

/* Missing contacts join pairs that are not listed, within the gap, with weak forces. */
TEST(test_missing) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_errors e = sp_errors_default();
    int added = 0;
    e.missing = 1;
    e.gap = 0.02;
    FREED(sp_packing) q = drawn(&p, &e, 0);
    for (int k = 0; k < q.n_contacts; k++) {
        const sp_contact *c = &q.contacts[k];
        double d[3] = {0}, gap;
        if (sp_packing_has_contact(&p, c->i, c->j))
            continue;
        if (c->j >= 0)
            sp_packing_separation(&p, c->i, c->j, d);
        gap = c->j >= 0 ? hypot(d[0], d[1]) - p.r[c->i] - p.r[c->j]
                        : sp_packing_wall_distance(&p, c->i, c->j) - p.r[c->i];
        assert_true(gap <= 0.02 && c->fn > 0 && c->fn < 0.2 * 3 * p.pressure);
        added++;
    }
    assert_true(added > 20);
    e.gap = 0.002;
    FREED(sp_packing) less = drawn(&p, &e, 0);
    assert_true(less.n_contacts < q.n_contacts && less.n_contacts >= p.n_contacts);
}

/* From positions alone: an error far below the overlaps keeps nearly all contacts, one far above them loses many. */
TEST(test_overlaps) {
    FREED(sp_packing) p = reference_packing(SMALL);
    sp_errors e = sp_errors_default();
    e.measured = SP_MEASURED_OVERLAPS;
    e.position = 1e-6;
    FREED(sp_packing) q = drawn(&p, &e, 0);
    assert_true(q.n_contacts > 0.99 * p.n_contacts);
    for (int k = 0; k < q.n_contacts; k++)
        assert_true(q.contacts[k].overlap > 0 && q.contacts[k].fn > 0);
    sp_packing_free(&q);
    e.position = 0.02;
    q = drawn(&p, &e, 0);
    assert_true(q.n_contacts < 0.8 * p.n_contacts);
}

TEST(test_refuses) {
    sp_packing p = reference_packing(SMALL), q;
    sp_errors e = sp_errors_default();
    e.position = -1;
    assert_fails(sp_packing_perturb(&p, &e, 1, 0, &q, &err), SP_EINVAL, "position -1");
    e.position = NAN;
    assert_fails(sp_packing_perturb(&p, &e, 1, 0, &q, &err), SP_EINVAL, "position");
    e = sp_errors_default();
    e.false_part = 1.5;
    assert_fails(sp_packing_perturb(&p, &e, 1, 0, &q, &err), SP_EINVAL, "false 1.5");
    e = sp_errors_default();
    e.measured = SP_MEASURED_OVERLAPS;
    e.force = 0.1;
    assert_fails(sp_packing_perturb(&p, &e, 1, 0, &q, &err), SP_EINVAL, "force");
    e.force = 0;
    e.missing = 0.1;
    assert_fails(sp_packing_perturb(&p, &e, 1, 0, &q, &err), SP_EINVAL, "missing");
    sp_packing_free(&p);
}

RUN_TESTS(NULL, NULL)
