/* Packing files: HDF5 and text. Round trips bit for bit; every wrong file has its reason. */
#include "test_store_fixture.h"

#include <hdf5.h>

/* ---- round trips ----------------------------------------------------------------------------------------------- */

enum { HDF5, TEXT, FORMS };

static sp_status round_trip(int form, const sp_packing *p, sp_packing *q, sp_error *err) {
    const char *path = fixture_path(folder, form == HDF5 ? "p.h5" : "p.txt");
    sp_status status = form == HDF5 ? sp_packing_save(p, path, err) : sp_packing_save_text(p, path, err);
    return status == SP_OK ? sp_packing_read(path, q, err) : status;
}

/* Every form, cell and dimension; a piston without gravity too. */
TEST_IN_FOLDER(every_bit_is_kept) {
    for (int form = 0; form < FORMS; form++)
        for (int cell = -1; cell <= SP_CELL_BOX; cell++)
            for (int dim = 1; dim <= 3; dim++)
                for (uint64_t seed = 0; seed < 12; seed++) {
                    FREED(sp_packing) p = cell < 0 ? fixture_packing(seed, dim, seed < 4 ? 1 + (int32_t)seed : 50)
                                                   : fixture_cell(seed, dim, 50, (sp_cell)cell),
                                      q = sp_packing_none();
                    assert_ok(round_trip(form, &p, &q, &err));
                    assert_same_packing(&p, &q);
                    assert_true(isnan(q.seconds)); /* in no file */
                    if (form == HDF5) {
                        assert_same_bits("residual", &p.residual, &q.residual, 1);
                        assert_true(p.steps == q.steps);
                        assert_true(p.scene ? q.scene && strcmp(p.scene, q.scene) == 0 : !q.scene);
                    }
                }
}

/* Large enough for several chunks: 20000 grains in 3D. */
TEST_IN_FOLDER(hdf5_keeps_large_packings) {
    FREED(sp_packing) p = fixture_packing(5, 3, 40000), q = sp_packing_none();
    const char *path = fixture_path(folder, "p.h5");
    assert_ok(sp_packing_save(&p, path, &err));
    assert_ok(sp_packing_read(path, &q, &err));
    assert_same_packing(&p, &q);
}

static char *slurp(const char *path, size_t *size) {
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    char *data = malloc(1 << 22);
    *size = fread(data, 1, 1 << 22, f);
    fclose(f);
    return data;
}

static herr_t no_time(hid_t object, const char *name, const H5O_info_t *info, void *user) {
    (void)object, (void)user;
    if (info->atime || info->mtime || info->ctime || info->btime)
        fail_msg("%s has a time stamp", name);
    return 0;
}

/* Files of different times would differ. */
static void assert_no_times(const char *path) {
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0 && H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, no_time, NULL) >= 0);
    H5Fclose(file);
}

TEST_IN_FOLDER(equal_packings_are_equal_files) {
    FREED(sp_packing) p = fixture_packing(3, 2, 30);
    size_t size_a, size_b;
    assert_ok(sp_packing_save(&p, fixture_path(folder, "a.h5"), &err));
    assert_no_times(fixture_path(folder, "a.h5"));
    assert_ok(sp_packing_save(&p, fixture_path(folder, "b.h5"), &err));
    RELEASED char *a = slurp(fixture_path(folder, "a.h5"), &size_a), *b = slurp(fixture_path(folder, "b.h5"), &size_b);
    assert_int_equal(size_a, size_b);
    assert_memory_equal(a, b, size_a);
}

/* Ft as a scalar is exact both ways, although the rounded product is neither one to one nor onto: what is written is
 * what was read. */
TEST_IN_FOLDER(tangential_scalar_survives) {
    enum { CONTACTS = 2000 };
    uint64_t random = 11;
    char *text = malloc(CONTACTS * 200), *at = text;
    int collisions = 0;
    double scalar[CONTACTS];
    at += sprintf(at, "N %d Lx %d Ly 4 p 1 mu 1e9 nu 0 contacts 0 bottom %d top 0\n", CONTACTS, 2 * CONTACTS, CONTACTS);
    for (int k = 0; k < CONTACTS; k++)
        at += sprintf(at, "%d.5 0.5 0.5 0\n", 2 * k);
    for (int k = 0; k < CONTACTS; k++) {
        double n[3] = {0};
        fixture_normal(&random, 2, n);
        scalar[k] = (fixture_uniform(&random) - 0.5) * pow(10, -10 * fixture_uniform(&random));
        at += sprintf(at, "%d -1 %.17g %.17g 0.1 1 %.17g\n", k, n[0], n[1], scalar[k]);
    }
    const char *path = fixture_path(folder, "t.txt");
    fixture_write(path, text);
    free(text);
    FREED(sp_packing) p;
    assert_ok(sp_packing_read(path, &p, &err));
    assert_ok(sp_packing_save_text(&p, fixture_path(folder, "again.txt"), &err));
    size_t size;
    char *again = slurp(fixture_path(folder, "again.txt"), &size), *line = again + size - 1;
    again[size - 1] = '\0';
    for (int k = CONTACTS - 1; k >= 0; k--, *line = '\0') {
        const sp_contact *c = &p.contacts[k];
        while (line[-1] != '\n')
            line--;
        assert_true(strtod(strrchr(line, ' '), NULL) == scalar[k]);
        line--;
        collisions += scalar[k] * -c->n[1] != c->ft[0] || scalar[k] * c->n[0] != c->ft[1];
        assert_close(c->ft[0], scalar[k] * -c->n[1], 3e-16 * fabs(c->ft[0]));
        assert_close(c->ft[1], scalar[k] * c->n[0], 3e-16 * fabs(c->ft[1]));
    }
    assert_in_range(collisions, 1, CONTACTS / 2); /* the case does occur */
    free(again);
}

/* ---- reference packings ---------------------------------------------------------------------------------------- */

TEST_IN_FOLDER(reference_packing_reads) {
    const char *path = SOURCE_DIR "/packings/reference/packing_N200_p1e-4.txt";
    sp_packing p = sp_packing_none(), q = sp_packing_none();
    assert_ok(sp_packing_read(path, &p, &err));
    assert_int_equal(p.dim, 2);
    assert_int_equal(p.n, 200);
    assert_int_equal(p.n_contacts, 264 + 15 + 16);
    assert_true(p.seed == 1);
    assert_true(p.box[0] == 24 && p.box[1] == 8.6958069203285007);
    assert_true(p.x[0] == 6.4461863482947761 && p.x[1] == 0.51397880012711539 && p.r[0] == 0.51821614797177595);
    const sp_contact *first = &p.contacts[0]; /* '0 74' comes after '0 171' in the file */
    assert_int_equal(first->i, 0);
    assert_int_equal(first->j, 74);
    assert_true(first->overlap == 0.00907087189449 && first->fn == 0.000290888672502);
    assert_close(first->ft[1], -7.23039767138e-06 * first->n[0], 1e-20);
    const sp_contact *last = &p.contacts[p.n_contacts - 1];
    assert_int_equal(last->i, 194);
    assert_int_equal(last->j, SP_TOP);
    assert_true(last->n[1] == 1 && last->ft[0] == -2.57238623674e-05 && last->ft[1] == 0);

    /* text -> HDF5 -> text -> packing: every number of the file is still the same */
    assert_ok(sp_packing_save(&p, fixture_path(folder, "r.h5"), &err));
    assert_ok(sp_packing_read(fixture_path(folder, "r.h5"), &q, &err));
    assert_same_packing(&p, &q);
    assert_ok(sp_packing_save_text(&q, fixture_path(folder, "r.txt"), &err));
    sp_packing_free(&q);
    assert_ok(sp_packing_read(fixture_path(folder, "r.txt"), &q, &err));
    assert_same_packing(&p, &q);
    sp_packing_free(&p);
    sp_packing_free(&q);
}

/* ---- the text form --------------------------------------------------------------------------------------------- */

#define HEADER   "N 3 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0.1 contacts 2 bottom 1 top 0\n"
#define GRAINS   "1 0.5 0.5 0\n1.9 0.5 0.5 0\n5 2 0.5 1\n"
#define CONTACTS "0 1 1 0 0.1 0.01 0.002\n2 1 0.6 0.8 0.05 0.001 -0.0001\n0 -1 0 -1 0.001 0.002 0\n"

static sp_status read_text(const char *text, sp_packing *p, sp_error *err) {
    const char *path = fixture_path(folder, "t.txt");
    fixture_write(path, text);
    return sp_packing_read(path, p, err);
}

TEST_IN_FOLDER(reversed_contacts_turn_round) {
    FREED(sp_packing) p;
    assert_ok(read_text("# a comment\n\n" HEADER GRAINS CONTACTS, &p, &err));
    const sp_contact *c = &p.contacts[1];
    assert_int_equal(c->i, 1);
    assert_int_equal(c->j, 2);
    assert_true(c->n[0] == -0.6 && c->n[1] == -0.8);
    /* force on grain 2 along t = (-0.8, 0.6) was -1e-4 t; on grain 1 it is the opposite */
    assert_close(c->ft[0], -1e-4 * 0.8, 1e-19);
    assert_close(c->ft[1], 1e-4 * 0.6, 1e-19);
    assert_true(p.contacts[2].j == SP_BOTTOM && p.seed == 0);
}

TEST_IN_FOLDER(positions_are_wrapped) {
    FREED(sp_packing) p;
    assert_ok(
        read_text("N 1 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0 contacts 0 bottom 0 top 0 seed 7\r\n-0.5 1 0.5 0\r\n", &p, &err));
    assert_true(p.x[0] == 9.5 && p.seed == 7);
}

#define PERIODIC "N 2 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0.1 contacts 1 walls 0 cell periodic xy 1\n"
#define IN_BOX   "N 2 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0.1 contacts 1 walls 1 cell box\n"
#define TWO      "1 0.5 0.5 0\n1.9 0.5 0.5 0\n"
#define PAIR     "0 1 1 0 0.1 0.01 0.002\n"

TEST_IN_FOLDER(cells_as_text) {
    sp_packing p;
    assert_ok(read_text(PERIODIC "1 0.5 0.5 0\n2.9 4.5 0.5 0\n" PAIR, &p, &err));
    assert_close(p.x[3], 1.9, 1e-15); /* one lattice vector (1, 4) lower */
    assert_close(p.x[4], 0.5, 1e-15);
    sp_packing_free(&p);
    assert_ok(read_text(IN_BOX TWO PAIR "0 -3 -1 0 0.001 0.002 0\n", &p, &err));
    assert_true(p.cell == SP_CELL_BOX && p.contacts[1].j == SP_LEFT);
    sp_packing_free(&p);
}

TEST_IN_FOLDER(wrong_texts_have_reasons) {
    static const struct {
        const char *text, *reason;
    } wrong[] = {
        {"", "HDF5"},
        {"hello world\n", "HDF5"},
        {"N 3 Lx 10\n" GRAINS, "contacts"},
        {"N 3 N 3 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 0 bottom 0 top 0\n", "N"},
        {"N 2000000000 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0 contacts 0 bottom 0 top 0\n", "t.txt"},
        {"N 3 Lx 10 Ly -4 p 1e-4 mu 0.5 nu 0 contacts 0 bottom 0 top 0\n" GRAINS, "Ly -4"},
        {"N 3 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0.6 contacts 0 bottom 0 top 0\n" GRAINS, "Poisson 0.6"},
        {"N 3 Lx 10 Ly 4 p 1e-4 mu 0.5 nu 0 contacts 0 bottom 0 top 0 seed -1\n" GRAINS, "seed -1"},
        {HEADER GRAINS, "4"},
        {HEADER "1 0.5 0.5 0\n1.9 0.5 0.5 0\n5 2 nan 1\n" CONTACTS, "t.txt:4 R nan"},
        {HEADER "1 0.5 0.5 0\n1.9 0.5\n5 2 0.5 1\n" CONTACTS, "t.txt:3 2"},
        {HEADER "1 4.5 0.5 0\n1.9 0.5 0.5 0\n5 2 0.5 1\n" CONTACTS, "t.txt"},
        {HEADER GRAINS "0 1 1 0 0.1 0.01 0.002\n0 3 0.6 0.8 0.05 0.001 0\n0 -1 0 -1 0.001 0.002 0\n", "t.txt:6"},
        {HEADER GRAINS "0 1 1 0 0.1 0.01 0.002\n2 2 0.6 0.8 0.05 0.001 0\n0 -1 0 -1 0.001 0.002 0\n", "t.txt:6 2 2"},
        {HEADER GRAINS "0 1 1 0 0.1 0.01 0.002\n2 1 0.6 0.80001 0.05 0.001 0\n0 -1 0 -1 0.001 0.002 0\n", "t.txt:6"},
        {HEADER GRAINS "0 1 1 0 0.1 0.01 0.002\n2 1 0.6 0.8 0.05 1e999 0\n0 -1 0 -1 0.001 0.002 0\n",
         "t.txt:6 Fn 1e999"},
        {HEADER GRAINS "0 1 1 0 0.1 0.01 0.002\n2 1 0.6 0.8 0.05 0.001 0\n0 -2 0 -1 0.001 0.002 0\n", "1 0"},
        {HEADER GRAINS CONTACTS "0 2 1 0 0.1 0.01 0.002\n", "t.txt"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 bottom 0 top 0 cell periodic\n" TWO PAIR, "walls"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell round\n" TWO PAIR, "cell round"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell periodic xy nan\n" TWO PAIR, "xy nan"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell periodic xy 5.1\n" TWO PAIR, "tilt 5.1"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell periodic xz 1\n" TWO PAIR, "tilt 1"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell box xy 1\n" TWO PAIR, "tilt 0"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 0 cell box gravity inf\n" TWO PAIR, "gravity inf"},
        {"N 2 Lx 10 Ly 4 p 1 mu 0 nu 0 contacts 1 walls 2 cell box\n" TWO PAIR, "truncated"},
        {PERIODIC TWO "0 -1 0 -1 0.001 0.002 0\n", "t.txt:4 -1"},
        {IN_BOX TWO PAIR "0 -5 0 -1 0.001 0.002 0\n", "t.txt:5 -5"},
        {IN_BOX TWO PAIR "0 -7 0 -1 0.001 0.002 0\n", "t.txt:5 -7"},
        {IN_BOX "-1 0.5 0.5 0\n1.9 0.5 0.5 0\n" PAIR "0 -3 -1 0 0.001 0.002 0\n", "0 -1"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        sp_packing p;
        assert_fails(read_text(wrong[k].text, &p, &err), SP_EFORMAT, wrong[k].reason);
    }
}

TEST_IN_FOLDER(every_truncated_text_fails) {
    const char whole[] = HEADER GRAINS CONTACTS;
    for (size_t length = 0; length + 14 < sizeof whole; length++) { /* short of the last line's end */
        char part[sizeof whole];
        memcpy(part, whole, length);
        part[length] = '\0';
        sp_packing p;
        sp_error err = {0};
        if (read_text(part, &p, &err) != SP_EFORMAT)
            fail_msg("%zu bytes: \"%s\"", length, err.text);
    }
}

TEST_IN_FOLDER(missing_files_are_io) {
    sp_packing p;
    assert_fails(sp_packing_read(fixture_path(folder, "nowhere.h5"), &p, &err), SP_EIO, "nowhere.h5 No such file");
    assert_fails(sp_packing_read(folder, &p, &err), SP_EIO, "Is a directory");
    assert_fails(sp_packing_read("/dev/zero", &p, &err), SP_EFORMAT, "/dev/zero");
    assert_fails(sp_packing_read("/dev/null", &p, &err), SP_EFORMAT, "/dev/null");
}

/* ---- no memory ------------------------------------------------------------------------------------------------- */

/* Each allocation in turn fails: an error, no leak (the sanitizer's part), no file under the final name. */
TEST_IN_FOLDER(lack_of_memory_is_an_error) {
    sp_packing p = fixture_packing(9, 2, 20), q;
    assert_ok(sp_packing_save(&p, fixture_path(folder, "good.h5"), &err));
    assert_ok(sp_packing_save_text(&p, fixture_path(folder, "good.txt"), &err));
    const int files = fixture_count_files(folder);
    for (int action = 0; action < 4; action++) {
        sp_status status = SP_ENOMEM;
        for (int64_t k = 0; status != SP_OK; k++) {
            sp_error err = {0};
            sp_alloc_fail_after(k);
            switch (action) {
            case 0: status = sp_packing_save(&p, fixture_path(folder, "new.h5"), &err); break;
            case 1: status = sp_packing_save_text(&p, fixture_path(folder, "new.txt"), &err); break;
            case 2: status = sp_packing_read(fixture_path(folder, "good.h5"), &q, &err); break;
            case 3: status = sp_packing_read(fixture_path(folder, "good.txt"), &q, &err); break;
            }
            sp_alloc_fail_after(-1);
            assert_true(k < 1000);
            if (status == SP_OK && action >= 2)
                sp_packing_free(&q);
            if (status != SP_OK) {
                assert_int_equal(status, SP_ENOMEM);
                if (action < 2)
                    assert_int_equal(fixture_count_files(folder), files);
            }
        }
        unlink(fixture_path(folder, "new.h5"));
        unlink(fixture_path(folder, "new.txt"));
    }
    sp_packing_free(&p);
}

TEST_IN_FOLDER(wrong_packings_are_not_saved) {
    FREED(sp_packing) p = fixture_packing(9, 2, 20);
    p.r[3] = NAN;
    assert_fails(sp_packing_save(&p, fixture_path(folder, "p.h5"), &err), SP_EFORMAT, "3");
    assert_fails(sp_packing_save_text(&p, fixture_path(folder, "p.txt"), &err), SP_EFORMAT, "3");
    assert_int_equal(fixture_count_files(folder), 0);
}

RUN_TESTS(NULL, NULL)
