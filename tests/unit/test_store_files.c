/* Writing whole files: atomically, or not at all. */
#include "test_store_fixture.h"

#include "base/file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>

static void assert_holds(const char *path, const char *expected) {
    char *text;
    size_t size;
    assert_ok(sp_file_read_text(path, &text, &size, &err));
    assert_string_equal(text, expected);
    assert_int_equal(size, strlen(expected));
    sp_free(text);
}

TEST_IN_FOLDER(writes_and_replaces) {
    const char *path = fixture_path(folder, "a.txt");
    assert_ok(sp_text_save(path, "one", 3, &err));
    assert_holds(path, "one");
    assert_int_equal(chmod(path, 0640), 0);
    assert_ok(sp_text_save(path, "", 0, &err));
    assert_holds(path, "");
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
    assert_int_equal(fixture_count_files(folder), 1);
    assert_ok(sp_folder_probe(folder, &err));
    assert_int_equal(fixture_count_files(folder), 1);
}

TEST_IN_FOLDER(links_stay_links) {
    const char *file = fixture_path(folder, "file"), *link = fixture_path(folder, "link");
    assert_ok(sp_text_save(file, "one", 3, &err));
    assert_int_equal(symlink("file", link), 0);
    assert_ok(sp_text_save(link, "two", 3, &err));
    struct stat info;
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    assert_holds(file, "two");
    const char *dangling = fixture_path(folder, "dangling");
    assert_int_equal(symlink("nowhere/file", dangling), 0);
    assert_fails(sp_text_save(dangling, "x", 1, &err), SP_EIO, "dangling");
}

TEST_IN_FOLDER(devices_stay_devices) {
    struct stat info;
    assert_ok(sp_text_save("/dev/null", "x", 1, &err));
    assert_fails(sp_text_save("/dev/full", "x", 1, &err), SP_EIO, "/dev/full No space left on device");
    assert_int_equal(lstat("/dev/null", &info), 0);
    assert_true(S_ISCHR(info.st_mode));
    assert_int_equal(lstat("/dev/full", &info), 0);
    assert_true(S_ISCHR(info.st_mode));
    FREED(sp_packing) p = fixture_packing(1, 2, 5);
    assert_fails(sp_packing_save(&p, "/dev/full", &err), SP_EIO, "regular file");
    assert_fails(sp_packing_save_text(&p, "/dev/full", &err), SP_EIO, "No space left");
}

TEST_IN_FOLDER(places_that_are_none) {
    assert_fails(sp_text_save("", "x", 1, &err), SP_EINVAL, "");
    assert_fails(sp_text_save(folder, "x", 1, &err), SP_EIO, "Is a directory");
    assert_fails(sp_text_save(fixture_path(folder, "no/where"), "x", 1, &err), SP_EIO, "No such file");
    assert_fails(sp_text_save(fixture_path(folder, "new/"), "x", 1, &err), SP_EIO, "new/");
    assert_fails(sp_folder_probe(fixture_path(folder, "no"), &err), SP_EIO, "No such file");
    RELEASED char *longest = malloc(6000);
    memset(longest, 'x', 5999);
    longest[5999] = '\0';
    assert_fails(sp_text_save(longest, "x", 1, &err), SP_EIO, "");
    longest[300] = '\0';
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, longest);
    assert_fails(sp_text_save(path, "x", 1, &err), SP_EIO, "");
    longest[255] = '\0'; /* the longest name there is, and so without room for a suffix */
    snprintf(path, sizeof path, "%s/%s", folder, longest);
    assert_ok(sp_text_save(path, "x", 1, &err));
    assert_int_equal(fixture_count_files(folder), 1);
}

/* Writing stops in the middle: nothing is left, the old file stands. */
static void assert_no_room(const char *where) {
    sp_packing p = fixture_packing(1, 3, 4000), q; /* about 1 MB */
    char path[512], text_path[512];
    snprintf(path, sizeof path, "%s/p.h5", where);
    snprintf(text_path, sizeof text_path, "%s/p.txt", where);
    FREED(sp_packing) old = fixture_packing(2, 2, 5);
    assert_fails(sp_packing_save_text(&p, text_path, &err), SP_EIO, "p.txt");
    assert_fails(sp_packing_save(&p, path, &err), SP_EIO, "p.h5");
    assert_int_equal(fixture_count_files(where), 0);
    assert_ok(sp_packing_save(&old, path, &err));
    assert_fails(sp_packing_save(&p, path, &err), SP_EIO, "p.h5");
    assert_ok(sp_packing_read(path, &q, &err));
    assert_same_packing(&old, &q);
    assert_int_equal(fixture_count_files(where), 1);
    unlink(path);
    sp_packing_free(&p);
    sp_packing_free(&q);
}

TEST_IN_FOLDER(file_size_limit) {
    struct rlimit before, limit;
    getrlimit(RLIMIT_FSIZE, &before);
    limit = before;
    limit.rlim_cur = 100000;
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    assert_no_room(folder);
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
}

TEST_IN_FOLDER(full_disk) {
    char place[512];
    snprintf(place, sizeof place, "%s/disk", folder);
    mkdir(place, 0777);
    if (mount("tmpfs", place, "tmpfs", 0, "size=100k") != 0) {
        rmdir(place);
        skip(); /* only root may */
    }
    assert_no_room(place);
    umount(place);
    rmdir(place);
}

TEST_IN_FOLDER(read_only_folder) {
    if (geteuid() == 0)
        skip(); /* root may write everywhere */
    assert_ok(sp_text_save(fixture_path(folder, "a"), "x", 1, &err));
    chmod(fixture_path(folder, "a"), 0444);
    assert_fails(sp_text_save(fixture_path(folder, "a"), "y", 1, &err), SP_EIO, "Permission denied");
    chmod(folder, 0555);
    assert_fails(sp_text_save(fixture_path(folder, "b"), "y", 1, &err), SP_EIO, "Permission denied");
    assert_fails(sp_folder_probe(folder, &err), SP_EIO, "Permission denied");
    chmod(folder, 0755);
}

/* A temporary that a dead process of the same number left behind is stepped over, and left alone. */
TEST_IN_FOLDER(stale_temporaries) {
    for (int k = 0; k < 2000; k++) {
        char name[64];
        snprintf(name, sizeof name, ".sonopack-%ld-%d.tmp", (long)getpid(), k);
        fixture_write(fixture_path(folder, name), "stale");
    }
    assert_ok(sp_text_save(fixture_path(folder, "a"), "fresh", 5, &err));
    assert_holds(fixture_path(folder, "a"), "fresh");
    assert_int_equal(fixture_count_files(folder), 2001);
}

RUN_TESTS(NULL, NULL)
