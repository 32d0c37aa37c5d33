/* Histograms of contacts. */
#include "base/base.h"
#include "reference.h"

#include <sonopack/counts.h>

#define PACKING SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt"

static double cell(const sp_table *t, int64_t row, const char *name) {
    const int column = sp_table_find_column(t, name);
    assert_true(column >= 0);
    return sp_table_number(t, row, column);
}

/* Integrals are 1, and F_2 = <n_y^2> of the histogram is that of the statics, to the width of the bins: averaging
 * sin^2 over 5 degrees shrinks its deviation from 1/2 by sin(h)/h at h = 5 degrees, 0.13%. */
TEST(test_integrals_and_fabric) {
    sp_packing p = reference_packing(PACKING);
    sp_contact_counts c = sp_contact_counts_none();
    sp_table angles = sp_table_none(), values = sp_table_none();
    sp_statics s;
    assert_ok(sp_contact_counts_add(&c, &p, 1e-4, 3, &err));
    assert_ok(sp_statics_make(&p, 1e-4, 3, &s, &err));
    assert_ok(sp_contact_angles_table(&c, &angles, &err));
    assert_ok(sp_contact_values_table(&c, &values, &err));
    assert_int_equal(angles.rows, SP_ANGLE_BINS);
    double sum[3] = {0}, fabric[3] = {0};
    static const char *const names[] = {"all", "strong", "weak"};
    for (int64_t k = 0; k < angles.rows; k++)
        for (int q = 0; q < 3; q++) {
            const double y = sin(cell(&angles, k, "angle") * acos(-1) / 180), v = cell(&angles, k, names[q]);
            sum[q] += v / SP_ANGLE_BINS;
            fabric[q] += v * y * y / SP_ANGLE_BINS;
        }
    for (int q = 0; q < 3; q++)
        assert_close(sum[q], 1, 1e-12);
    /* a contact anywhere within its bin of 5 degrees: sin^2 changes by 0.044 at the most from the middle, at random for
     * hundreds of contacts */
    assert_close(fabric[0], s.f2, 0.004);
    assert_close(fabric[1], s.f2s, 0.006);
    double area[2] = {0}, mean[2] = {0};
    for (int64_t k = 0; k < values.rows; k++)
        for (int q = 0; q < 2; q++) {
            const double v = cell(&values, k, q == 0 ? "forces" : "stiffnesses");
            area[q] += 0.1 * v;
            mean[q] += 0.1 * v * cell(&values, k, "x");
            assert_true(isnan(cell(&values, k, "forces_err")));
        }
    for (int q = 0; q < 2; q++) {
        assert_close(area[q], 1, 1e-12);
        assert_close(mean[q], 1, 0.01); /* to a tenth of a bin */
    }
    sp_table_free(&angles);
    sp_table_free(&values);
    sp_packing_free(&p);
}

/* In a triangular lattice the bonds lie at 0, 60 and 120 degrees. The packing twice: the same means, errors 0. */
TEST(test_lattice) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    sp_contact_counts c = sp_contact_counts_none();
    sp_table t = sp_table_none();
    spec.kind = SP_PACK_TRIANGULAR;
    spec.width = 8;
    spec.grains = 96;
    spec.friction = 0;
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    for (int k = 0; k < 2; k++)
        assert_ok(sp_contact_counts_add(&c, &p, 1e-4, 3, &err));
    assert_ok(sp_contact_angles_table(&c, &t, &err));
    double near = 0;
    for (int64_t k = 0; k < t.rows; k++) {
        const double angle = cell(&t, k, "angle"), v = cell(&t, k, "all");
        const bool bond = fabs(angle - 60) < 3 || fabs(angle - 120) < 3 || angle < 3 || angle > 177;
        near += bond ? v : 0;
        if (!bond)
            assert_close(v, 0, 0);
        assert_close(cell(&t, k, "all_err"), 0, 1e-7);
    }
    assert_close(near, SP_ANGLE_BINS, 1e-9);
    assert_non_null(sp_table_get_text(&t, "packings"));
    /* no force is above the mean, which all are */
    assert_int_equal(c.strong.packings, 0);
    assert_true(isnan(cell(&t, 0, "strong")));
    assert_close(cell(&t, 12, "angle"), 60, 1e-12);
    sp_table_free(&t);
    sp_packing_free(&p);
}

/* The direction of a contact depends on which grain comes first; its bin does not. */
TEST(test_both_ends_are_one) {
    sp_packing p = reference_packing(PACKING);
    sp_contact_counts c[2] = {sp_contact_counts_none(), sp_contact_counts_none()};
    assert_ok(sp_contact_counts_add(&c[0], &p, 1e-4, 3, &err));
    for (int32_t k = 0; k < p.n_contacts; k++)
        if (p.contacts[k].j >= 0) {
            const int32_t i = p.contacts[k].i;
            p.contacts[k].i = p.contacts[k].j;
            p.contacts[k].j = i;
            for (int a = 0; a < 3; a++)
                p.contacts[k].n[a] = -p.contacts[k].n[a];
        }
    assert_ok(sp_contact_counts_add(&c[1], &p, 1e-4, 3, &err));
    assert_close(c[1].contacts, c[0].contacts, 0);
    for (int b = 0; b < SP_ANGLE_BINS; b++)
        assert_close(c[1].all.sum[b], c[0].all.sum[b], 1e-12);
    sp_packing_free(&p);
}

TEST(test_refusals) {
    sp_packing p = reference_packing(PACKING), chain = chain_packing(12, 1e-4);
    sp_contact_counts c = sp_contact_counts_none();
    sp_table t = sp_table_none();
    assert_fails(sp_contact_angles_table(&c, &t, &err), SP_EREFUSED, "");
    assert_fails(sp_contact_values_table(&c, &t, &err), SP_EREFUSED, "");
    assert_fails(sp_contact_counts_add(&c, &p, 1e-4, 30, &err), SP_EREFUSED, "60");
    assert_fails(sp_contact_counts_add(&c, &p, 1e-4, NAN, &err), SP_EINVAL, "margin nan");
    assert_fails(sp_contact_counts_add(&c, &p, 1e9, 3, &err), SP_EREFUSED, "3");
    assert_int_equal(c.packings, 0);
    assert_ok(sp_contact_counts_add(&c, &chain, 1e-4, 3, &err));
    assert_fails(sp_contact_counts_add(&c, &p, 1e-4, 3, &err), SP_EINVAL, "2 1");
    assert_fails(sp_contact_angles_table(&c, &t, &err), SP_EREFUSED, "1");
    assert_ok(sp_contact_values_table(&c, &t, &err));
    sp_table_free(&t);
    for (int64_t k = 0;; k++) {
        c = sp_contact_counts_none();
        sp_alloc_fail_after(k);
        sp_status status = sp_contact_counts_add(&c, &p, 1e-4, 3, NULL);
        if (status == SP_OK)
            status = sp_contact_angles_table(&c, &t, NULL);
        sp_alloc_fail_after(-1);
        if (status == SP_OK)
            break;
        assert_int_equal(status, SP_ENOMEM);
    }
    sp_table_free(&t);
    sp_packing_free(&p);
    sp_packing_free(&chain);
}

RUN_TESTS(NULL, NULL)
