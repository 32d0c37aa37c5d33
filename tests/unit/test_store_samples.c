/* A store: a folder of samples that many processes may work on. */
#include "test_store_fixture.h"

#include <pthread.h>
#include <sys/stat.h>
#include <sys/wait.h>

/* that a store keeps */
enum { FRONT_NUMBERS = offsetof(sp_front, crossings) / 8, MODULI_NUMBERS = offsetof(sp_moduli, error11) / 8 };

static sp_sample example(unsigned have, uint64_t seed) {
    uint64_t random = seed;
    sp_sample s = {.dim = 2, .grains = 20, .width = 24, .pressure = 1e-4, .friction = 0.5, .height = 40, .have = have};
    snprintf(s.name, sizeof s.name, "%016llx%016llx", (unsigned long long)fixture_next(&random),
             (unsigned long long)fixture_next(&random));
    s.seed = fixture_next(&random);
    double *parts[] = {&s.front.t10, &s.statics.phi2, &s.moduli.c11};
    const size_t counts[] = {FRONT_NUMBERS, sizeof s.statics / 8, MODULI_NUMBERS};
    for (int part = 0; part < 3; part++)
        for (size_t k = 0; k < counts[part]; k++)
            if (have & (1u << part))
                parts[part][k] = k == (part < 2 ? 2 : 5) ? NAN : fixture_uniform(&random);
    if (have & SP_WANT_CTOF) { /* what such results can be */
        s.front.t_peak += s.front.t10;
        s.front.width = NAN;
    }
    if (have & SP_WANT_STATICS) {
        s.statics.z2 += 1;
        s.statics.z3 += 1;
    }
    if (have & SP_WANT_MODULI)
        s.moduli.c_l = s.moduli.c_t = NAN;
    return s;
}

static void assert_same_sample(const sp_sample *a, const sp_sample *b) {
    assert_string_equal(a->name, b->name);
    assert_string_equal(a->reason, b->reason);
    assert_int_equal(a->failed, b->failed);
    assert_int_equal(a->have, b->have);
    assert_true(a->dim == b->dim && a->grains == b->grains && a->seed == b->seed && a->width == b->width);
    assert_true(a->pressure == b->pressure && a->friction == b->friction && a->height == b->height);
    assert_same_bits("front", &a->front.t10, &b->front.t10, FRONT_NUMBERS);
    assert_same_bits("statics", &a->statics.phi2, &b->statics.phi2, sizeof a->statics / 8);
    assert_same_bits("moduli", &a->moduli.c11, &b->moduli.c11, MODULI_NUMBERS);
}

TEST_IN_FOLDER(saves_and_loads) {
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    FREED(sp_scene) scene = sp_scene_default();
    sp_packing p = fixture_packing(1, 2, 20), q = sp_packing_none();
    sp_sample s = example(SP_WANT_CTOF | SP_WANT_STATICS, 1), back;
    bool found = true;
    assert_ok(sink.load(sink.user, s.name, &q, &back, &found, &err));
    assert_false(found);
    assert_false(fixture_has(&sink, s.name, 0));
    assert_ok(sink.save(sink.user, &scene, &s, &p, NULL, &err));
    assert_true(fixture_has(&sink, s.name, 0));
    assert_true(fixture_has(&sink, s.name, SP_WANT_CTOF | SP_WANT_STATICS));
    assert_false(fixture_has(&sink, s.name, SP_WANT_CTOF | SP_WANT_MODULI));
    assert_ok(sink.load(sink.user, s.name, &q, &back, &found, &err));
    assert_true(found);
    assert_same_sample(&s, &back);
    assert_same_packing(&p, &q);
    sp_packing_free(&q);

    /* a packing file like any other */
    char path[600];
    snprintf(path, sizeof path, "%s/%s.h5", folder, s.name);
    assert_ok(sp_packing_read(path, &q, &err));
    assert_same_packing(&p, &q);
    sp_packing_free(&q);

    /* other parts join, without the packing being given again; the signal stays too */
    double t[3] = {0, 1, 2}, f[3] = {0, 0.5, -0.25};
    const sp_sample_arrays arrays = {
        .signal = {.n = 3, .t = t, .f = f, .error = 1e-12, .omega_max = 1.4, .products = 12}};
    sp_sample more = example(SP_WANT_MODULI | SP_WANT_SIGNAL, 1);
    assert_ok(sink.save(sink.user, &scene, &more, NULL, &arrays, &err));
    sp_sample again = example(SP_WANT_STATICS, 1);
    assert_ok(sink.save(sink.user, &scene, &again, &p, NULL, &err));
    assert_true(fixture_has(&sink, s.name, SP_WANT_CTOF | SP_WANT_STATICS | SP_WANT_MODULI | SP_WANT_SIGNAL));
    assert_ok(sink.load(sink.user, s.name, &q, &back, &found, &err));
    assert_same_bits("front", &s.front.t10, &back.front.t10, FRONT_NUMBERS);
    assert_same_bits("statics", &again.statics.phi2, &back.statics.phi2, sizeof s.statics / 8);
    assert_same_bits("moduli", &more.moduli.c11, &back.moduli.c11, MODULI_NUMBERS);
    assert_same_packing(&p, &q);
    sp_packing_free(&q);
    sp_packing_free(&p);
    assert_int_equal(fixture_count_files(folder), 1);
    sp_store_close(store);
}

/* Fronts at planes, probes, moduli in three dimensions and what a signal was made with: bit for bit, through joins with
 * other parts too; and one sample by its name. */
TEST_IN_FOLDER(newer_parts_are_kept) {
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    FREED(sp_scene) scene = sp_scene_default();
    sp_packing p = fixture_packing(1, 3, 20), q = sp_packing_none();
    uint64_t random = 77;
    sp_sample s = example(SP_WANT_CTOF | SP_WANT_MODULI, 5), back;
    s.have |= SP_WANT_PLANES | SP_WANT_PROBES | SP_WANT_SIGNAL | SP_WANT_SPECTRUM;
    s.planes = SP_PLANES_MAX;
    for (int k = 0; k < SP_PLANES_MAX; k++) {
        s.plane[k] = k + fixture_uniform(&random);
        double *front = &s.plane_front[k].t10;
        for (int i = 0; i < FRONT_NUMBERS; i++)
            front[i] = k == 3 || i == 2 || i == 4 ? NAN : i + fixture_uniform(&random);
    }
    for (int k = 0; k < SP_PROBES; k++)
        s.probe[k] = (sp_probe_moduli){.along = fixture_uniform(&random),
                                       .shear = k == 2 ? NAN : fixture_uniform(&random),
                                       .concentrated = 0.125 * k,
                                       .left_out = k == 1 ? NAN : 0.5};
    s.signal = (sp_signal_made){.points = 3, .method = SP_SIGNAL_DENSE, .until = 2, .tolerance = 1e-7};
    double t[3] = {0, 1, 2}, f[3] = {0, 0.5, -0.25};
    double omega[6] = {0, 1e-300, 0.1, 0.25, 0.5, 0.7};
    const sp_sample_arrays arrays = {
        .signal = {.n = 3, .t = t, .f = f, .method = SP_SIGNAL_DENSE}, .modes = 6, .omega = omega};
    s.spectrum = (sp_spectrum_made){.carrying = 2, .dof = 3, .zero_modes = 1, .omega_max = 0.7};
    assert_ok(sink.save(sink.user, &scene, &s, &p, &arrays, &err));
    sp_sample more = example(SP_WANT_STATICS, 5); /* joins what is there */
    assert_ok(sink.save(sink.user, &scene, &more, NULL, NULL, &err));
    sp_sample_arrays read = sp_sample_arrays_none();
    assert_ok(sp_store_read(store, s.name, &q, &back, &read, &err));
    assert_int_equal(back.have, s.have | SP_WANT_STATICS);
    assert_same_packing(&p, &q);
    assert_same_bits("moduli", &s.moduli.c11, &back.moduli.c11, MODULI_NUMBERS);
    assert_int_equal(back.planes, SP_PLANES_MAX);
    assert_same_bits("planes", s.plane, back.plane, SP_PLANES_MAX);
    for (int k = 0; k < SP_PLANES_MAX; k++)
        assert_same_bits("front", &s.plane_front[k].t10, &back.plane_front[k].t10, FRONT_NUMBERS);
    for (int k = 0; k < SP_PROBES; k++) {
        assert_same_bits("probe", &s.probe[k].along, &back.probe[k].along, 2);
        assert_same_bits("shares", &s.probe[k].left_out, &back.probe[k].left_out, 2);
    }
    assert_true(isnan(back.probe[0].error_along)); /* is not kept */
    assert_true(back.signal.points == 3 && back.signal.method == SP_SIGNAL_DENSE && back.signal.until == 2 &&
                back.signal.tolerance == 1e-7);
    assert_true(back.spectrum.carrying == 2 && back.spectrum.dof == 3 && back.spectrum.zero_modes == 1 &&
                back.spectrum.omega_max == 0.7);
    assert_int_equal(read.signal.n, 3);
    assert_same_bits("signal", read.signal.f, f, 3);
    assert_int_equal(read.modes, 6);
    assert_same_bits("omega", read.omega, omega, 6);
    sp_sample_arrays_free(&read);
    sp_packing_free(&q);
    /* any of the three alone */
    assert_ok(sp_store_read(store, s.name, NULL, &back, NULL, &err));
    assert_ok(sp_store_read(store, s.name, NULL, NULL, &read, &err));
    assert_true(read.signal.n == 3 && read.modes == 6);
    sp_sample_arrays_free(&read);
    assert_ok(sp_store_read(store, s.name, &q, NULL, NULL, &err));
    sp_packing_free(&q);
    /* no planes inside is a result too; no signal is n = 0, and no frequencies are modes = 0 */
    s = example(SP_WANT_PLANES, 6);
    assert_ok(sink.save(sink.user, &scene, &s, &p, NULL, &err));
    assert_ok(sp_store_read(store, s.name, NULL, &back, &read, &err));
    assert_true(back.have == SP_WANT_PLANES && back.planes == 0 && read.signal.n == 0 && isnan(back.moduli.error11));
    assert_true(read.modes == 0 && !read.omega);
    sp_sample_arrays_free(&read);
    /* none there */
    assert_fails(sp_store_read(store, "0123", NULL, &back, NULL, &err), SP_EINVAL, "32");
    s = example(0, 9);
    assert_fails(sp_store_read(store, s.name, NULL, &back, NULL, &err), SP_EIO, s.name);
    s.failed = true;
    snprintf(s.reason, sizeof s.reason, "no equilibrium");
    assert_ok(sink.save(sink.user, NULL, &s, NULL, NULL, &err));
    assert_fails(sp_store_read(store, s.name, NULL, &back, NULL, &err), SP_EIO, "");
    sp_packing_free(&p);
    sp_store_close(store);
}

/* Frequencies stay when other parts join, new ones take the place of the old, and a sample whose old file has gone bad
 * has none. */
TEST_IN_FOLDER(frequencies_stay) {
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    FREED(sp_scene) scene = sp_scene_default();
    FREED(sp_packing) p = fixture_packing(1, 2, 20);
    sp_sample s = example(SP_WANT_SPECTRUM, 4), back;
    double omega[3] = {0, 0.5, 1.5}, fresh[6] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
    sp_sample_arrays arrays = {.modes = 3, .omega = omega}, read = sp_sample_arrays_none();
    s.spectrum = (sp_spectrum_made){.carrying = 1, .dof = 3, .zero_modes = 1, .omega_max = 1.5};
    assert_ok(sink.save(sink.user, &scene, &s, &p, &arrays, &err));
    assert_true(fixture_has(&sink, s.name, SP_WANT_SPECTRUM));
    sp_sample more =
        example(SP_WANT_SPECTRUM | SP_WANT_STATICS, 4); /* as a study has it, which has loaded the sample */
    more.spectrum = s.spectrum;
    assert_ok(sink.save(sink.user, &scene, &more, &p, NULL, &err));
    assert_ok(sp_store_read(store, s.name, NULL, &back, &read, &err));
    assert_int_equal(back.have, SP_WANT_SPECTRUM | SP_WANT_STATICS);
    assert_int_equal(read.modes, 3);
    assert_same_bits("omega", read.omega, omega, 3);
    sp_sample_arrays_free(&read);

    arrays = (sp_sample_arrays){.modes = 6, .omega = fresh};
    more.spectrum = (sp_spectrum_made){.carrying = 2, .dof = 3, .zero_modes = 0, .omega_max = 0.6};
    assert_ok(sink.save(sink.user, &scene, &more, NULL, &arrays, &err));
    assert_ok(sp_store_read(store, s.name, NULL, &back, &read, &err));
    assert_true(read.modes == 6 && back.spectrum.carrying == 2 && back.spectrum.omega_max == 0.6);
    assert_same_bits("omega", read.omega, fresh, 6);
    sp_sample_arrays_free(&read);

    char path[600];
    snprintf(path, sizeof path, "%s/%s.h5", folder, s.name);
    assert_int_equal(truncate(path, 4000), 0);
    assert_ok(sink.save(sink.user, &scene, &more, &p, NULL, &err));
    assert_false(fixture_has(&sink, s.name, SP_WANT_SPECTRUM));
    assert_true(fixture_has(&sink, s.name, SP_WANT_STATICS));
    assert_ok(sp_store_read(store, s.name, NULL, &back, &read, &err));
    assert_true(read.modes == 0 && back.have == SP_WANT_STATICS);
    sp_store_close(store);
}

TEST_IN_FOLDER(failures_are_kept) {
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    sp_sample s = example(0, 3), *all;
    s.failed = true;
    s.height = 0;
    snprintf(s.reason, sizeof s.reason, "no equilibrium after 1e7 steps: residual = 3e-9");
    assert_ok(sink.save(sink.user, NULL, &s, NULL, NULL, &err));
    assert_true(fixture_has(&sink, s.name, SP_WANT_CTOF));
    int64_t n, bad;
    assert_ok(sp_store_samples(store, &n, &all, &bad, &err));
    assert_true(n == 1 && bad == 0);
    assert_same_sample(&s, &all[0]);
    sp_free(all);
    /* made after all: the failure is forgotten */
    FREED(sp_packing) p = fixture_packing(1, 2, 20);
    sp_sample good = example(SP_WANT_CTOF, 3);
    assert_ok(sink.save(sink.user, NULL, &good, &p, NULL, &err));
    assert_int_equal(fixture_count_files(folder), 1);
    assert_false(fixture_has(&sink, s.name, SP_WANT_MODULI));
    sp_store_close(store);
}

TEST_IN_FOLDER(samples_skip_what_is_damaged) {
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    sp_packing p = fixture_packing(1, 2, 20), q;
    sp_sample s[5], *all, back;
    for (uint64_t k = 0; k < 5; k++) {
        s[k] = example(SP_WANT_CTOF, 10 + k);
        assert_ok(sink.save(sink.user, NULL, &s[k], &p, NULL, &err));
    }
    char path[600], other[600];
    snprintf(path, sizeof path, "%s/%s.h5", folder, s[2].name);
    assert_int_equal(truncate(path, 5000), 0);
    snprintf(path, sizeof path, "%s/%s.h5", folder, s[3].name); /* under a name that is not its own */
    snprintf(other, sizeof other, "%s/%032x.h5", folder, 7);
    rename(path, other);
    fixture_write(fixture_path(folder, "README"), "not a sample");
    fixture_write(fixture_path(folder, ".sonopack-1-1.tmp"), "left by a dead process");
    int64_t n, bad;
    sp_error reason = {0};
    assert_int_equal(sp_store_samples(store, &n, &all, &bad, &reason), SP_OK);
    assert_true(n == 3 && bad == 2);
    assert_true(reason.status == SP_OK && strstr(reason.text, ".h5"));
    for (int64_t k = 1; k < n; k++)
        assert_true(strcmp(all[k - 1].name, all[k].name) < 0);
    sp_free(all);

    /* a damaged sample is one to make anew; its remains are put aside */
    bool found = true;
    assert_false(fixture_has(&sink, s[2].name, 0));
    assert_ok(sink.load(sink.user, s[2].name, &q, &back, &found, &err));
    assert_false(found);
    assert_ok(sink.save(sink.user, NULL, &s[2], &p, NULL, &err));
    assert_true(fixture_has(&sink, s[2].name, SP_WANT_CTOF));
    snprintf(path, sizeof path, "%s/%s.bad", folder, s[2].name);
    assert_int_equal(access(path, F_OK), 0);
    sp_packing_free(&p);
    sp_store_close(store);
}

TEST_IN_FOLDER(wrong_saves) {
    sp_store *store;
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    FREED(sp_packing) p = fixture_packing(1, 2, 20);
    sp_sample s = example(SP_WANT_CTOF, 3);
    assert_fails(sink.save(sink.user, NULL, &s, NULL, NULL, &err), SP_EINVAL, "sample");
    snprintf(s.name, sizeof s.name, "../../../etc/passwd");
    assert_fails(sink.save(sink.user, NULL, &s, &p, NULL, &err), SP_EINVAL, "32");
    assert_false(fixture_has(&sink, s.name, 0));
    s = example(SP_WANT_CTOF, 3);
    p.r[0] = -1;
    assert_fails(sink.save(sink.user, NULL, &s, &p, NULL, &err), SP_EFORMAT, "0");
    assert_int_equal(fixture_count_files(folder), 0);
    sp_store_close(store);
}

TEST_IN_FOLDER(opening) {
    sp_store *store;
    const char *new = fixture_path(folder, "new"), *file = fixture_path(folder, "file");
    assert_fails(sp_store_open(new, false, &store, &err), SP_EIO, "No such file");
    assert_fails(sp_store_open("", true, &store, &err), SP_EIO, "4031");
    assert_fails(sp_store_open(fixture_path(folder, "no/where"), true, &store, &err), SP_EIO, "No such file");
    assert_ok(sp_store_open(new, true, &store, &err));
    sp_store_close(store);
    assert_ok(sp_store_open(new, false, &store, &err));
    int64_t n, bad;
    sp_sample *all;
    assert_ok(sp_store_samples(store, &n, &all, &bad, &err));
    assert_true(n == 0 && bad == 0);
    sp_free(all);
    sp_store_close(store);
    rmdir(new);
    fixture_write(file, "x");
    assert_fails(sp_store_open(file, true, &store, &err), SP_EIO, "Not a directory");
    assert_fails(sp_store_open("/proc", true, &store, &err), SP_EIO,
                 "/proc"); /* no place for files, not for root either */
    if (geteuid() != 0) {
        chmod(folder, 0555);
        assert_fails(sp_store_open(folder, true, &store, &err), SP_EIO, "Permission denied");
        assert_ok(sp_store_open(folder, false, &store, &err));
        sp_store_close(store);
        chmod(folder, 0755);
    }
}

/* Processes that add different parts to the same sample at once: no part is lost. */
TEST_IN_FOLDER(processes_save_together) {
    const unsigned part[] = {SP_WANT_CTOF, SP_WANT_STATICS, SP_WANT_MODULI};
    for (uint64_t round = 0; round < 10; round++) {
        for (int k = 0; k < 3; k++) {
            if (fork() != 0)
                continue;
            sp_store *store;
            sp_packing p = fixture_packing(round, 2, 20);
            sp_sample s = example(part[k], round);
            bool good = sp_store_open(folder, true, &store, NULL) == SP_OK;
            sp_study_sink sink = sp_store_sink(store);
            good = good && sink.save(sink.user, NULL, &s, &p, NULL, NULL) == SP_OK;
            _exit(good ? 0 : 1);
        }
        for (int k = 0; k < 3; k++) {
            int status;
            wait(&status);
            assert_int_equal(status, 0);
        }
    }
    sp_store *store;
    sp_sample *all;
    int64_t n, bad;
    assert_ok(sp_store_open(folder, false, &store, &err));
    assert_ok(sp_store_samples(store, &n, &all, &bad, &err));
    assert_true(n == 10 && bad == 0);
    for (int64_t k = 0; k < n; k++)
        assert_int_equal(all[k].have, SP_WANT_CTOF | SP_WANT_STATICS | SP_WANT_MODULI);
    assert_int_equal(fixture_count_files(folder), 10);
    sp_free(all);
    sp_store_close(store);
}

static void *save_and_read(void *user) {
    uint64_t id = *(uint64_t *)user;
    char path[600];
    snprintf(path, sizeof path, "%s/%llu.h5", folder, (unsigned long long)id);
    for (uint64_t round = 0; round < 10; round++) {
        FREED(sp_packing) p = fixture_packing(10 * id + round, 2, 20), q = sp_packing_none();
        sp_error err = {0};
        bool good = sp_packing_save(&p, path, &err) == SP_OK && sp_packing_read(path, &q, &err) == SP_OK &&
                    q.x[0] == p.x[0] && sp_packing_read("/dev/null", &q, &err) == SP_EFORMAT;
        if (!good)
            return user;
    }
    return NULL;
}

TEST_IN_FOLDER(threads_save_together) {
    pthread_t thread[4];
    uint64_t id[4] = {0, 1, 2, 3};
    for (int k = 0; k < 4; k++)
        assert_int_equal(pthread_create(&thread[k], NULL, save_and_read, &id[k]), 0);
    for (int k = 0; k < 4; k++) {
        void *bad;
        pthread_join(thread[k], &bad);
        assert_null(bad);
    }
}

TEST_IN_FOLDER(lack_of_memory) {
    sp_store *store = NULL;
    sp_packing p = fixture_packing(1, 2, 20), q;
    FREED(sp_scene) scene = sp_scene_default();
    sp_sample s = example(SP_WANT_CTOF | SP_WANT_SPECTRUM, 3), back, *all;
    double omega[3] = {0.25, 0.5, 1}, t[2] = {0, 1}, f[2] = {0, 1};
    const sp_sample_arrays arrays = {.signal = {.n = 2, .t = t, .f = f}, .modes = 3, .omega = omega};
    sp_sample_arrays read;
    s.spectrum = (sp_spectrum_made){.carrying = 1, .dof = 3, .omega_max = 1};
    sp_alloc_fail_after(0);
    assert_fails(sp_store_open(folder, true, &store, &err), SP_ENOMEM, "");
    assert_ok(sp_store_open(folder, true, &store, &err));
    sp_study_sink sink = sp_store_sink(store);
    assert_ok(sink.save(sink.user, &scene, &s, &p, &arrays, &err));
    for (int action = 0; action < 6; action++) {
        sp_status status = SP_ENOMEM;
        for (int64_t k = 0; status != SP_OK; k++) {
            bool found;
            int64_t n, bad;
            sp_error err = {0};
            sp_alloc_fail_after(k);
            switch (action) {
            case 0: status = sink.save(sink.user, &scene, &s, NULL, NULL, &err); break;
            case 1: status = sink.save(sink.user, &scene, &s, &p, NULL, &err); break;
            case 2: status = sink.load(sink.user, s.name, &q, &back, &found, &err); break;
            case 3: status = sp_store_samples(store, &n, &all, &bad, &err); break;
            case 4: status = sink.save(sink.user, &scene, &s, &p, &arrays, &err); break;
            case 5: status = sp_store_read(store, s.name, NULL, NULL, &read, &err); break;
            }
            sp_alloc_fail_after(-1);
            assert_true(k < 1000 && (status == SP_OK || status == SP_ENOMEM));
            assert_int_equal(fixture_count_files(folder), 1);
            if (status == SP_OK && action == 2) {
                assert_true(found);
                sp_packing_free(&q);
            }
            if (status == SP_OK && action == 3)
                sp_free(all);
            if (status == SP_OK && action == 5) {
                assert_true(read.modes == 3 && read.signal.n == 2);
                sp_sample_arrays_free(&read);
            }
        }
    }
    sp_packing_free(&p);
    sp_store_close(store);
}

RUN_TESTS(NULL, NULL)
