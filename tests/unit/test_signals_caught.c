/* The library leaves the handlers of its host alone, and its temporary files go when the host asks. */
#include "base/base.h"
#include "base/file.h"
#include "linalg/supernodes.h"
#include "test.h"

#include <sonopack/packing.h>

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

static void handler(int number) { (void)number; }

/* The lower triangle of a cube of L^3 points whose neighbours are coupled: CHOLMOD would have METIS order it. */
static sp_sparse cube(int32_t length) {
    const int32_t n = length * length * length, step[] = {1, length, length * length};
    sp_sparse a = {.n = n, .p = calloc((size_t)n + 1, sizeof *a.p), .i = calloc((size_t)n * 4, sizeof *a.i)};
    a.x = calloc((size_t)n * 4, sizeof *a.x);
    assert_true(a.p && a.i && a.x);
    for (int32_t c = 0; c < n; c++) {
        int64_t q = a.p[c];
        a.i[q++] = c;
        for (int k = 0; k < 3; k++)
            if (c / step[k] % length + 1 < length)
                a.i[q++] = c + step[k];
        a.p[c + 1] = q;
    }
    return a;
}

static atomic_bool done;
static atomic_int replaced;

/* Looks at the handlers as long as the other thread works. */
static void *look(void *unused) {
    (void)unused;
    static const int numbers[] = {SIGTERM, SIGABRT, SIGINT};
    while (!atomic_load(&done))
        for (int k = 0; k < 3; k++) {
            struct sigaction now;
            if (sigaction(numbers[k], NULL, &now) != 0 || now.sa_handler != handler)
                atomic_store(&replaced, numbers[k]);
        }
    return NULL;
}

TEST(orderings_leave_handlers_alone) {
    sp_sparse a = cube(40);
    FREED(sp_supernodes) s;
    pthread_t thread;
    signal(SIGTERM, handler);
    signal(SIGABRT, handler);
    signal(SIGINT, handler);
    assert_int_equal(pthread_create(&thread, NULL, look, NULL), 0);
    assert_ok(sp_supernodes_make(&a, NULL, &s, &err));
    atomic_store(&done, true);
    pthread_join(thread, NULL);
    assert_int_equal(atomic_load(&replaced), 0);
    free(a.p);
    free(a.i);
    free(a.x);
}

TEST(drafts_are_abandoned) {
    char folder[] = "/tmp/sonopack-drafts-XXXXXX", path[2][SP_PATH_MAX];
    sp_draft d[3];
    assert_non_null(mkdtemp(folder));
    for (int k = 0; k < 2; k++)
        snprintf(path[k], sizeof path[k], "%s/%d.txt", folder, k);
    assert_ok(sp_draft_begin(path[0], &d[0], &err));
    assert_ok(sp_draft_begin(path[1], &d[1], &err));
    assert_ok(sp_draft_begin(path[1], &d[2], &err));
    assert_ok(sp_draft_commit(&d[0], &err));
    sp_draft_drop(&d[1]);
    assert_int_equal(access(d[2].temporary, F_OK), 0);
    sp_drafts_abandon();
    assert_int_not_equal(access(d[2].temporary, F_OK), 0);
    assert_int_equal(access(path[0], F_OK), 0); /* what is finished stays */
    sp_draft_drop(&d[2]);
    assert_int_equal(unlink(path[0]), 0);
    assert_int_equal(rmdir(folder), 0); /* nothing else is there */
}

static bool refuse(const sp_pack_progress *progress, void *user) {
    *(int64_t *)user = progress->steps;
    return false;
}

TEST(placing_can_be_stopped) {
    sp_pack_spec spec = sp_pack_spec_default();
    sp_packing p = sp_packing_none();
    sp_error err = {0};
    int64_t steps = -1;
    spec.grains = 10000;
    spec.width = 100;
    assert_int_equal(sp_packing_make(&spec, refuse, &steps, &p, &err), SP_EINTERRUPTED);
    assert_int_equal(steps, 0); /* before the grains have moved */
}

RUN_TESTS(NULL, NULL)
