/* Files of packings in other cells than under a piston: every bit comes back, and forged files have their reasons. */
#include "test_store_fixture.h"

static char *folder;

static int make_folder(void **state) {
    (void)state;
    folder = fixture_folder();
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    fixture_remove(folder);
    return 0;
}

typedef sp_status round_trip(const sp_packing *p, sp_packing *q, sp_error *err);

static sp_status through_hdf5(const sp_packing *p, sp_packing *q, sp_error *err) {
    const char *path = fixture_path(folder, "p.h5");
    sp_status status = sp_packing_save(p, path, err);
    return status == SP_OK ? sp_packing_read(path, q, err) : status;
}

/* All kinds of cells in all dimensions. A piston with gravity is one of them. */
static void each_cell(round_trip *trip) {
    for (int cell = SP_CELL_PISTON; cell <= SP_CELL_BOX; cell++)
        for (int dim = 1; dim <= 3; dim++)
            for (uint64_t seed = 0; seed < 12; seed++) {
                sp_packing p = fixture_cell(seed, dim, 50, (sp_boundary)cell), q = sp_packing_none();
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

int main(void) {
#define TEST(f) cmocka_unit_test_setup_teardown(f, make_folder, remove_folder)
    const struct CMUnitTest tests[] = {
        TEST(hdf5_keeps_every_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
