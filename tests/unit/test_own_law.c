/* Grains and contacts that are not Hertzian spheres: masses and stiffnesses of their own, walls of the grains'
 * material, and the material in SI units. */
#include "test_store_fixture.h"

#include "packing/contact.h"

#include <sonopack/network.h>
#include <sonopack/signal.h>

/* Gives every contact the stiffnesses that Hertz and Mindlin give it, and every grain a sphere's mass, times factors.
 */
static void state_own_law(sp_packing *p, double mass, double kn, double kt) {
    assert_ok(sp_packing_alloc_masses(p, &err));
    for (int32_t i = 0; i < p->n; i++) {
        p->mass[i] *= mass;
        p->inertia[i] *= mass;
    }
    for (int32_t c = 0; c < p->n_contacts; c++) {
        sp_contact *k = &p->contacts[c];
        const double hertz = contact_kn(p, k);
        k->kn = kn * hertz;
        k->kt = kt * contact_eta(p->poisson) * hertz;
    }
}

static void assert_same_own(const sp_packing *p, const sp_packing *q) {
    assert_same_packing(p, q);
    assert_int_equal(p->wall, q->wall);
    assert_true(!p->mass == !q->mass);
    if (p->mass) {
        assert_same_bits("mass", p->mass, q->mass, p->n);
        assert_same_bits("inertia", p->inertia, q->inertia, p->n);
    }
    for (int32_t c = 0; c < p->n_contacts; c++)
        assert_same_bits("kn", &p->contacts[c].kn, &q->contacts[c].kn, 2);
    assert_same_bits("material", &p->material.young, &q->material.young, 4);
}

TEST(files_keep_every_bit) {
    const char *h5 = fixture_path(folder, "p.h5");
    for (int dim = 1; dim <= 3; dim++)
        for (int own = 0; own < 4; own++) {
            FREED(sp_packing) p = fixture_packing((uint64_t)(7 + own), dim, 40), q = sp_packing_none();
            p.wall = own & 1 ? SP_WALL_ELASTIC : SP_WALL_GRAIN;
            p.material = (sp_material){.young = 7e10 / 3, .poisson = 0.22, .density = 2500, .diameter = 1e-3 / 7};
            if (own & 2)
                state_own_law(&p, 1.25, 1.0 / 3, 0.7);
            assert_ok(sp_packing_save(&p, h5, &err));
            assert_ok(sp_packing_read(h5, &q, &err));
            assert_same_own(&p, &q);
            assert_true(sp_packing_hash(&p) == sp_packing_hash(&q));
            const sp_status text = sp_packing_save_text(&p, fixture_path(folder, "p.txt"), NULL);
            assert_int_equal(text, own & 2 ? SP_EINVAL : SP_OK); /* has no columns for them */
        }
}

/* Stiffnesses times a and masses times b: frequencies times sqrt(a/b), to the last bit for powers of 4. */
TEST(network_takes_them) {
    sp_pack_spec spec = sp_pack_spec_default();
    spec.grains = 60;
    spec.width = 8;
    spec.tolerance = 1e-8;
    FREED(sp_packing) p = sp_packing_none();
    assert_ok(sp_packing_make(&spec, NULL, NULL, &p, &err));
    const sp_network_options opt = sp_network_options_default();
    FREED(sp_network) hertz = sp_network_none(), same = hertz, scaled = hertz;
    assert_ok(sp_network_make(&p, &opt, &hertz, &err));
    const uint64_t before = sp_packing_hash(&p);
    sp_pack_spec from = sp_pack_spec_default();
    from.kind = SP_PACK_FILE;
    assert_ok(sp_pack_spec_from(&from, &p, &err));
    state_own_law(&p, 1, 1, 1);
    from = sp_pack_spec_default();
    from.kind = SP_PACK_FILE;
    assert_int_equal(sp_pack_spec_from(&from, &p, NULL), SP_EINVAL); /* there is no law to compress it by */
    assert_true(sp_packing_hash(&p) != before);
    assert_ok(sp_network_make(&p, &opt, &same, &err));
    assert_int_equal(hertz.n_springs, same.n_springs);
    for (int32_t k = 0; k < same.n_springs; k++)
        assert_same_bits("springs", &hertz.springs[k].kn, &same.springs[k].kn, 2);
    assert_same_bits("masses", hertz.mass, same.mass, sp_network_dofs(&same));
    sp_statics statics;
    double density, heavier;
    assert_ok(sp_statics_make(&p, opt.threshold, 1, &statics, &err));
    assert_ok(sp_packing_density(&p, opt.threshold, 1, &density, &err));
    assert_true(density > 0.4 && density == statics.phi3s); /* spheres of unit density */
    for (int32_t i = 0; i < p.n; i++) {
        p.mass[i] *= 4;
        p.inertia[i] *= 4;
    }
    assert_ok(sp_packing_density(&p, opt.threshold, 1, &heavier, &err));
    assert_true(heavier == 4 * density); /* the speeds of long waves halve */
    for (int32_t c = 0; c < p.n_contacts; c++)
        p.contacts[c].kt = 0; /* frictionless contacts in a frictional packing */
    assert_ok(sp_network_make(&p, &opt, &scaled, &err));
    for (int32_t k = 0; k < scaled.n_springs; k++)
        assert_true(scaled.springs[k].kt == 0 && scaled.springs[k].kn == same.springs[k].kn);
    assert_true(scaled.mass[0] == 4 * same.mass[0] && scaled.mass[2] == 4 * same.mass[2]);
}

/* What needs forces away from rest refuses them. */
TEST(law_is_needed) {
    FREED(sp_packing) p = fixture_packing(3, 2, 40);
    assert_true(sp_packing_hertzian(&p));
    assert_ok(sp_packing_need_law(&p, "this", &err));
    p.contacts[0].kn = 1;
    assert_int_equal(sp_packing_need_law(&p, "this", NULL), SP_EREFUSED);
    p.contacts[0].kn = 0;
    assert_ok(sp_packing_alloc_masses(&p, &err));
    assert_false(sp_packing_hertzian(&p));
}

/* An elastic wall is half as stiff as a rigid plane, whose modulus is that of one grain. */
TEST(elastic_wall) {
    assert_true(contact_wall_stiffness(0.49, SP_WALL_ELASTIC) == 0.5 * contact_wall_stiffness(0.49, SP_WALL_RIGID));
}

TEST(structure_is_checked) {
    const double bad[] = {-1, NAN, INFINITY};
    FREED(sp_packing) p = fixture_packing(3, 2, 40);
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        p.contacts[0].kn = bad[k];
        assert_int_equal(sp_packing_check(&p, NULL), SP_EFORMAT);
    }
    p.contacts[0].kn = 0;
    p.contacts[0].kt = 1; /* kt without kn */
    assert_int_equal(sp_packing_check(&p, NULL), SP_EFORMAT);
    p.contacts[0].kt = 0;
    assert_ok(sp_packing_alloc_masses(&p, &err));
    assert_ok(sp_packing_check(&p, &err));
    p.inertia[0] = 0;
    assert_int_equal(sp_packing_check(&p, NULL), SP_EFORMAT);
}

TEST(material_as_text) {
    sp_material m, again;
    char text[SP_MATERIAL_TEXT];
    assert_ok(sp_material_read("d=1e-3, rho=2500,E=70e9,nu=0.22", &m, &err));
    assert_true(m.young == 70e9 && m.poisson == 0.22 && m.density == 2500 && m.diameter == 1e-3);
    assert_ok(sp_material_read(sp_material_text(&m, text), &again, &err));
    assert_same_bits("material", &m.young, &again.young, 4);
    const struct {
        const char *text, *key;
    } wrong[] = {{"E=70e9,nu=0.22,rho=2500", "material.d"},     {"E=0,nu=0.22,rho=2500,d=1", "material.E"},
                 {"E=70e9,nu=0.6,rho=2500,d=1", "material.nu"}, {"E=1,nu=0,rho=nan,d=1", "material.rho"},
                 {"E=1,nu=0,rho=1,d=one", "material.d"},        {"E=1,E=1,nu=0,rho=1,d=1", "material.E"},
                 {"E=1,nu=0,rho=1,d=inf", "material.d"},        {"", "material.E"}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        sp_error fault = {0};
        assert_int_equal(sp_material_read(wrong[k].text, &m, &fault), SP_EINVAL);
        assert_string_equal(fault.key, wrong[k].key);
    }
    assert_int_equal(sp_material_read("young=1", &m, NULL), SP_EINVAL);
}

RUN_TESTS(make_folder, remove_folder)
