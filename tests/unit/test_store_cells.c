/* Files of packings in other cells than under a piston: every bit comes back, and forged files have their reasons. */
#include "test_store_fixture.h"

typedef sp_status round_trip(const sp_packing *p, sp_packing *q, sp_error *err);

static sp_status through_hdf5(const sp_packing *p, sp_packing *q, sp_error *err) {
    const char *path = fixture_path(folder, "p.h5");
    sp_status status = sp_packing_save(p, path, err);
    return status == SP_OK ? sp_packing_read(path, q, err) : status;
}

static sp_status through_text(const sp_packing *p, sp_packing *q, sp_error *err) {
    const char *path = fixture_path(folder, "p.txt");
    sp_status status = sp_packing_save_text(p, path, err);
    return status == SP_OK ? sp_packing_read(path, q, err) : status;
}

static sp_status through_tables(const sp_packing *p, sp_packing *q, sp_error *err) {
    const char *grains = fixture_path(folder, "g.tsv"), *contacts = fixture_path(folder, "c.tsv");
    sp_status status = sp_packing_save_tables(p, grains, contacts, err);
    return status == SP_OK ? sp_packing_read_tables(grains, contacts, 0, NULL, q, err) : status;
}

/* All kinds of cells in all dimensions. A piston with gravity is one of them. */
static void each_cell(round_trip *trip) {
    for (int cell = SP_CELL_PISTON; cell <= SP_CELL_BOX; cell++)
        for (int dim = 1; dim <= 3; dim++)
            for (uint64_t seed = 0; seed < 12; seed++) {
                sp_packing p = fixture_cell(seed, dim, 50, (sp_cell)cell), q = sp_packing_none();
                assert_ok(trip(&p, &q, &err));
                assert_same_packing(&p, &q);
                sp_packing_free(&p);
                sp_packing_free(&q);
            }
}

static void hdf5_keeps_every_bit(void **state) {
    (void)state;
    each_cell(through_hdf5);
}

static void text_keeps_every_bit(void **state) {
    (void)state;
    each_cell(through_text);
}

static void tables_keep_every_bit(void **state) {
    (void)state;
    each_cell(through_tables);
}

/* ---- wrong texts ----------------------------------------------------------------------------------------------- */

#define PERIODIC "N 2 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0.1 contacts 1 walls 0 cell periodic xy 1\n"
#define BOX      "N 2 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0.1 contacts 1 walls 1 cell box\n"
#define GRAINS   "1 0.5 0.5 0\n1.9 0.5 0.5 0\n"
#define PAIR     "0 1 1 0 0.1 0.01 0.002\n"

static sp_status read_text(const char *text, sp_packing *p, sp_error *err) {
    const char *path = fixture_path(folder, "t.txt");
    fixture_write(path, text);
    return sp_packing_read(path, p, err);
}

static void grains_outside_are_wrapped(void **state) {
    (void)state;
    sp_packing p;
    assert_ok(read_text(PERIODIC "1 0.5 0.5 0\n2.9 4.5 0.5 0\n" PAIR, &p, &err));
    assert_close(p.x[3], 1.9, 1e-15); /* one lattice vector (1, 4) lower */
    assert_close(p.x[4], 0.5, 1e-15);
    sp_packing_free(&p);
    assert_ok(read_text(BOX GRAINS PAIR "0 -3 -1 0 0.001 0.002 0\n", &p, &err));
    assert_true(p.cell == SP_CELL_BOX && p.contacts[1].j == SP_LEFT);
    sp_packing_free(&p);
}

static void wrong_texts_have_reasons(void **state) {
    (void)state;
    static const struct {
        const char *text, *reason;
    } wrong[] = {
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 bottom 0 top 0 cell periodic\n" GRAINS PAIR, "walls"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell round\n" GRAINS PAIR, "cell round"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell periodic xy nan\n" GRAINS PAIR, "xy nan"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell periodic xy 5.1\n" GRAINS PAIR, "tilt 5.1"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell periodic xz 1\n" GRAINS PAIR, "tilt 1"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell box xy 1\n" GRAINS PAIR, "tilt 0"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell box gravity inf\n" GRAINS PAIR, "gravity inf"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 2 cell box\n" GRAINS PAIR, "truncated"},
        {PERIODIC GRAINS "0 -1 0 -1 0.001 0.002 0\n", "t.txt:4 -1"},
        {BOX GRAINS PAIR "0 -5 0 -1 0.001 0.002 0\n", "t.txt:5 -5"},
        {BOX GRAINS PAIR "0 -7 0 -1 0.001 0.002 0\n", "t.txt:5 -7"},
        {BOX "-1 0.5 0.5 0\n1.9 0.5 0.5 0\n" PAIR "0 -3 -1 0 0.001 0.002 0\n", "0 -1"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        sp_packing p;
        assert_fails(read_text(wrong[k].text, &p, &err), SP_EFORMAT, wrong[k].reason);
    }
}

/* ---- wrong tables ---------------------------------------------------------------------------------------------- */

#define KEYS "# width = 10\n# height = 4\n# pressure = 1e-4\n# friction = 0.5\n"
#define ROWS "id x y radius\n1 1 0.5 0.5\n2 1.9 0.5 0.5\n"

static sp_status read_tables(const char *grains, const char *contacts, sp_packing *p, sp_error *err) {
    const char *g = fixture_path(folder, "g.tsv"), *c = fixture_path(folder, "c.tsv");
    fixture_write(g, grains);
    fixture_write(c, contacts);
    return sp_packing_read_tables(g, c, 0, NULL, p, err);
}

static void tables_name_walls(void **state) {
    (void)state;
    sp_packing p;
    assert_ok(read_tables(KEYS "# cell = box\n" ROWS, "i j nx ny overlap\n1 left -1 0 0.01\n", &p, &err));
    assert_true(p.n_contacts == 1 && p.contacts[0].j == SP_LEFT);
    sp_packing_free(&p);
    /* under a piston these words are free for grains */
    assert_ok(read_tables(KEYS "id x y radius\nleft 1 0.5 0.5\nright 1.9 0.5 0.5\n",
                          "i j nx ny overlap\nleft right 1 0 0.01\n", &p, &err));
    assert_true(p.n_contacts == 1 && p.contacts[0].j == 1);
    sp_packing_free(&p);
}

static void wrong_tables_have_reasons(void **state) {
    (void)state;
    static const struct {
        const char *grains, *contacts, *reason;
    } wrong[] = {
        {KEYS "# cell = round\n" ROWS, "i j nx ny overlap\n1 2 1 0 0.01\n", "cell round"},
        {KEYS "# cell = periodic\n# xy = 6\n" ROWS, "i j nx ny overlap\n1 2 1 0 0.01\n", "tilt 6"},
        {KEYS "# cell = periodic\n" ROWS, "i j nx ny overlap\n1 bottom 0 -1 0.01\n", "c.tsv:2 -1"},
        {KEYS "# cell = box\n" ROWS, "i j nx ny overlap\n1 front -1 0 0.01\n", "c.tsv:2 front"},
        {KEYS "# cell = box\nid x y radius\nleft 1 0.5 0.5\n", "i j nx ny overlap\n", "g.tsv:7 left"},
        {KEYS ROWS, "i j nx ny overlap\n1 left -1 0 0.01\n", "c.tsv:2 left"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        sp_packing p;
        assert_fails(read_tables(wrong[k].grains, wrong[k].contacts, &p, &err), SP_EFORMAT, wrong[k].reason);
    }
}

int main(void) {
#define BETWEEN(f) cmocka_unit_test_setup_teardown(f, make_folder, remove_folder)
    const struct CMUnitTest tests[] = {
        BETWEEN(hdf5_keeps_every_bit),       BETWEEN(text_keeps_every_bit),     BETWEEN(tables_keep_every_bit),
        BETWEEN(grains_outside_are_wrapped), BETWEEN(wrong_texts_have_reasons), BETWEEN(tables_name_walls),
        BETWEEN(wrong_tables_have_reasons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
