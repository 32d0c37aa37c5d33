/* Files that change while they are read, and memory that is short then: the disk and the memory are named as the
 * reason, and the file is not called damaged. */
#include "test_store_fixture.h"

#include "store/h5.h"
#include "store/packing_h5.h"

#include <sonopack/table.h>

static const char *saved_packing(void) {
    FREED(sp_packing) p = fixture_packing(3, 2, 4000);
    const char *path = fixture_path(folder, "p.h5");
    assert_ok(sp_packing_save(&p, path, &err));
    return path;
}

/* A file that ends early was damaged before it was opened, or has been shortened since. */
TEST_IN_FOLDER(shortened_while_read) {
    const char *path = saved_packing();
    sp_packing p = sp_packing_none();
    sp_error reason = {0}; /* an open file keeps it */
    sp_h5 h;
    assert_int_equal(sp_h5_open(&h, path, &reason), SP_OK);
    const off_t size = (off_t)h.size;
    assert_int_equal(truncate(path, size / 2), 0);
    assert_int_equal(sp_packing_get(&h, &p), SP_EIO);
    assert_non_null(strstr(reason.text, path));
    sp_h5_close(&h);
    assert_fails(sp_packing_read(path, &p, &err), SP_EFORMAT, path);
}

/* Whatever is longer than the file was is not looked at. */
TEST_IN_FOLDER(grown_while_read) {
    const char *path = saved_packing();
    FREED(sp_packing) p = sp_packing_none();
    sp_error reason = {0}; /* an open file keeps it */
    sp_h5 h;
    assert_int_equal(sp_h5_open(&h, path, &reason), SP_OK);
    FILE *file = fopen(path, "a");
    assert_non_null(file);
    fputs("more", file);
    fclose(file);
    assert_int_equal(sp_packing_get(&h, &p), SP_OK);
    sp_h5_close(&h);
    assert_int_equal(p.n, 4000);
}

TEST_IN_FOLDER(no_memory_to_open) {
    const char *path = saved_packing();
    FREED(sp_packing) p = sp_packing_none();
    sp_error reason = {0};
    sp_h5 h;
    sp_alloc_fail_after(0);
    assert_int_equal(sp_h5_open(&h, path, &reason), SP_ENOMEM);
    sp_alloc_fail_after(-1);
    assert_non_null(strstr(reason.text, path));
    sp_h5_close(&h);
    assert_ok(sp_packing_read(path, &p, &err));
}

/* A row whose text finds no memory is no row. */
TEST_IN_FOLDER(no_memory_for_a_row) {
    FREED(sp_table) t = sp_table_none();
    assert_ok(sp_table_add_column(&t, "file", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_column(&t, "x", "", SP_COLUMN_NUMBER, &err));
    assert_ok(sp_table_add_column(&t, "reason", "", SP_COLUMN_TEXT, &err));
    assert_ok(sp_table_add_row(&t, &err, "a", 1.0, "-"));
    for (int fails = 0; fails < 2; fails++) {
        sp_alloc_fail_after(fails);
        assert_fails(sp_table_add_row(&t, &err, "b", 2.0, "-"), SP_ENOMEM, "");
        sp_alloc_fail_after(-1);
        assert_int_equal(t.rows, 1);
    }
    assert_ok(sp_table_add_row(&t, &err, "c", 3.0, "-"));
    assert_int_equal(t.rows, 2);
}

RUN_TESTS(NULL, NULL)
