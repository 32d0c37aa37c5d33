/* Reads and writes the results of a sample as HDF5. */
#include "store/sample_h5.h"

#include "base/base.h"
#include "store/packing_h5.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define SAMPLE(member, type, unit, description)                                                                        \
    { {"/results/sample/" #member, unit, description}, type, offsetof(sp_sample, member) }
#define FRONT(member, unit, description)                                                                               \
    { {"/results/front/" #member, unit, description}, SP_H5_F64, offsetof(sp_front, member) }
#define SPECTRUM(member, type, unit, description)                                                                      \
    { {"/results/spectrum/" #member, unit, description}, type, offsetof(sp_spectrum_made, member) }
#define TIME      "d / sqrt(E* / rho)"
#define SPEED     "sqrt(E* / rho)"
#define FREQUENCY "sqrt(E* / rho) / d"

static const sp_h5_field sample_field[] = {
    SAMPLE(dim, SP_H5_I32, "1", "dimension"),
    SAMPLE(grains, SP_H5_I32, "1", "number of grains"),
    SAMPLE(width, SP_H5_F64, "d", "period sideways"),
    SAMPLE(pressure, SP_H5_F64, "E*", "pressure on the walls"),
    SAMPLE(friction, SP_H5_F64, "1", "Coulomb's coefficient"),
    SAMPLE(seed, SP_H5_U64, "1", "seed of the random streams"),
    SAMPLE(height, SP_H5_F64, "d", "distance from source to detector"),
};
static const sp_h5_field front_field[] = {
    FRONT(t10, TIME, "arrival: first time at a tenth of the first peak's height"),
    FRONT(t_peak, TIME, "time of the first peak"),
    FRONT(t_zero, TIME, "first zero crossing after the peak"),
    FRONT(amplitude, "E* d^2", "height of the first peak, for the source of the scene at unit strength"),
    FRONT(width, TIME, "t_zero - t10"),
};
/* Units of tables, in which a pure number has none. */
#define UNIT(unit) (sizeof(unit) == 1 ? "1" : (unit))
#define STATICS(member, symbol, unit, description)                                                                     \
    {{"/results/statics/" #member, UNIT(unit), description}, SP_H5_F64, offsetof(sp_statics, member)},
static const sp_h5_field statics_field[] = {
#include <sonopack/quantities.inc>
};
#undef STATICS
#define MODULI(member, symbol, unit, description)                                                                      \
    {{"/results/moduli/" #member, UNIT(unit), description}, SP_H5_F64, offsetof(sp_moduli, member)},
static const sp_h5_field moduli_field[] = {
#include <sonopack/quantities.inc>
};
/* How many of them every sample has; the others are optional. */
enum { STATICS_ALWAYS = 11, MODULI_ALWAYS = 7 };

static const sp_h5_field spectrum_field[] = {
    SPECTRUM(carrying, SP_H5_I32, "1", "grains of the network: without rattlers"),
    SPECTRUM(dof, SP_H5_I32, "1", "degrees of freedom of a grain"),
    SPECTRUM(zero_modes, SP_H5_I32, "1", "how many of the frequencies are 0"),
    SPECTRUM(omega_max, SP_H5_F64, FREQUENCY, "the largest frequency"),
};

#define PROBE(row, name, description)                                                                                  \
    {{"/results/probes/along_" name, "E*", "apparent modulus of motion from wall to wall, " description},              \
     SP_H5_F64,                                                                                                        \
     offsetof(sp_sample, probe[row].along)},                                                                           \
    {                                                                                                                  \
        {"/results/probes/shear_" name, "E*", "apparent modulus of motion along x, " description}, SP_H5_F64,          \
            offsetof(sp_sample, probe[row].shear)                                                                      \
    }
static const sp_h5_field probe_field[] = {
    PROBE(SP_SINE_1, "sine_1", "body force sin(pi y / L)"),
    PROBE(SP_SINE_2, "sine_2", "body force sin(2 pi y / L)"),
    PROBE(SP_LINES_1, "lines_1", "grains on one line displaced"),
    PROBE(SP_LINES_3, "lines_3", "grains on three lines displaced by turns"),
};

/* Optional numbers of a part. NAN is not written, and a missing number is read as NAN. */
#define SHARES(row, name)                                                                                              \
    {{"/results/probes/left_out_" name, "1", "share of the body force on floppy parts, which is left out"},            \
     SP_H5_F64,                                                                                                        \
     offsetof(sp_sample, probe[row].left_out)},                                                                        \
    {                                                                                                                  \
        {"/results/probes/concentrated_" name, "1", "largest share of one grain in the energy"}, SP_H5_F64,            \
            offsetof(sp_sample, probe[row].concentrated)                                                               \
    }
static const sp_h5_field share_field[] = {
    SHARES(SP_SINE_1, "sine_1"),
    SHARES(SP_SINE_2, "sine_2"),
    SHARES(SP_LINES_1, "lines_1"),
    SHARES(SP_LINES_3, "lines_3"),
};

static const struct part {
    unsigned want;
    const char *group; /* NULL: the numbers are optional, and belong to a group above */
    int count;
    const sp_h5_field *field;
    size_t offset;
} part[] = {
    {SP_WANT_CTOF, "/results/front", sizeof front_field / sizeof *front_field, front_field, offsetof(sp_sample, front)},
    {SP_WANT_STATICS, "/results/statics", STATICS_ALWAYS, statics_field, offsetof(sp_sample, statics)},
    {SP_WANT_MODULI, "/results/moduli", MODULI_ALWAYS, moduli_field, offsetof(sp_sample, moduli)},
    {SP_WANT_PROBES, "/results/probes", sizeof probe_field / sizeof *probe_field, probe_field, 0},
    {SP_WANT_SPECTRUM, "/results/spectrum", sizeof spectrum_field / sizeof *spectrum_field, spectrum_field,
     offsetof(sp_sample, spectrum)},
    {SP_WANT_MODULI, NULL, sizeof moduli_field / sizeof *moduli_field - MODULI_ALWAYS, moduli_field + MODULI_ALWAYS,
     offsetof(sp_sample, moduli)},
    {SP_WANT_PROBES, NULL, sizeof share_field / sizeof *share_field, share_field, 0},
    {SP_WANT_STATICS, NULL, sizeof statics_field / sizeof *statics_field - STATICS_ALWAYS,
     statics_field + STATICS_ALWAYS, offsetof(sp_sample, statics)},
};
enum { PARTS = sizeof part / sizeof *part, SAMPLE_FIELDS = sizeof sample_field / sizeof *sample_field };

const sp_plane_field sp_plane_fields[SP_PLANE_FIELDS] = {
    {{"/results/planes/height", "d", "heights of the planes above the bottom wall"},
     offsetof(sp_sample, plane),
     sizeof(double)},
#define PLANE(member, unit, description)                                                                               \
    { {"/results/planes/" #member, unit, description}, offsetof(sp_sample, plane_front[0].member), sizeof(sp_front) }
    PLANE(t10, TIME, "arrival of the momentum flux through each plane; nan: no front"),
    PLANE(t_peak, TIME, "time of the first peak"),
    PLANE(t_zero, TIME, "first zero crossing after the peak"),
    PLANE(amplitude, "E* d^2", "height of the first peak, for the source of the scene at unit strength"),
    PLANE(width, TIME, "t_zero - t10"),
};

double sp_plane_number(const sp_plane_field *f, const sp_sample *s, int32_t plane) {
    double number;
    memcpy(&number, (const char *)s + f->offset + (size_t)plane * f->stride, sizeof number);
    return number;
}

void sp_plane_set(const sp_plane_field *f, sp_sample *s, int32_t plane, double number) {
    memcpy((char *)s + f->offset + (size_t)plane * f->stride, &number, sizeof number);
}

static const sp_h5_field signal_field[] = {
    {{"/signal/error", "E* d^2", "bound of the error of F"}, SP_H5_F64, offsetof(sp_signal, error)},
    {{"/signal/omega_max", "sqrt(E* / rho) / d", "bound of the spectrum that was used"},
     SP_H5_F64,
     offsetof(sp_signal, omega_max)},
    {{"/signal/products", "1", "matrix products that it took"}, SP_H5_I32, offsetof(sp_signal, products)},
};
enum { SIGNAL_FIELDS = sizeof signal_field / sizeof *signal_field };
/* Not written where 0. */
static const sp_h5_field optional_field[] = {
    SAMPLE(
        kind, SP_H5_I32, "1",
        "how it was made: 0 by a piston, 1 a chain, 2 a triangular lattice, 3 from a file, 4 a minimum of the energy"),
    SAMPLE(material, SP_H5_U64, "1", "hash of the keys beside those above: samples that differ in it are not averaged"),
    SAMPLE(fraction, SP_H5_F64, "1", "packing.fraction, which decides the cell in place of the pressure"),
    SAMPLE(stage, SP_H5_I32, "1", "packings of history and path of strain up to this one"),
    SAMPLE(strain, SP_H5_F64, "1", "of the largest component of packing.path.strain"),
    SAMPLE(mean_stress, SP_H5_F64, "E*", "mean normal stress of the packing, at a fraction or a stage"),
};
enum { OPTIONAL_FIELDS = sizeof optional_field / sizeof *optional_field };
/* Parts that failed, with the reason of the first. */
static const sp_h5_field lacks_field[] = {
    SAMPLE(lacks, SP_H5_I32, "1",
           "parts that could not be made: 1 front, 2 statics, 4 moduli, 8 signal, 16 probes, 32 planes, 128 spectrum"),
    SAMPLE(lacks_signal, SP_H5_U64, "1", "hash of the signal's keys with which signal and planes were tried"),
};
enum { LACKS_FIELDS = sizeof lacks_field / sizeof *lacks_field };
static const sp_h5_name name_reason = {"/results/sample/reason", "1", "why the first of these could not be made"};
static const sp_h5_name name_omega = {"/results/spectrum/omega", FREQUENCY,
                                      "frequencies of all vibrations of the network, ascending; zero modes are 0"};
static const sp_h5_name name_t = {"/signal/t", TIME, "time since the pulse at the bottom wall"};
static const sp_h5_name name_f = {"/signal/F", "E* d^2",
                                  "force on the top wall beyond that at rest, positive in "
                                  "compression, for the source of the scene at unit strength"};
static const sp_h5_field tolerance_field = {{"/signal/tolerance", "1", "error asked for, over the largest |F|"},
                                            SP_H5_F64,
                                            offsetof(sp_signal_made, tolerance)};
static const sp_h5_name name_method = {"/signal/method", "1", "how it was computed: chebyshev, dense, ..."};
static const sp_h5_name name_name = {"/results/sample/name", "1", "hash of everything that made the sample"};
static const sp_h5_name name_scene = {"/results/sample/scene", "1", "the sample's scene, with every value"};

void sp_record_free(sp_record *r) {
    sp_sample_arrays_free(&r->arrays);
    sp_free(r->scene);
    *r = (sp_record){0};
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

static void put_planes(sp_h5 *h, const sp_sample *s) {
    const sp_h5_shape shape = {1, {s->planes}};
    sp_h5_group(h, "/results/planes");
    for (int k = 0; k < SP_PLANE_FIELDS; k++) {
        double x[SP_PLANES_MAX];
        for (int32_t i = 0; i < s->planes; i++)
            x[i] = sp_plane_number(&sp_plane_fields[k], s, i);
        sp_h5_put(h, &sp_plane_fields[k].name, SP_H5_F64, &shape, x);
    }
}

static void put_part(sp_h5 *h, const struct part *of, const sp_sample *s) {
    const char *from = (const char *)s + of->offset;
    if (of->group) {
        sp_h5_group(h, of->group);
        sp_h5_put_fields(h, of->count, of->field, from);
        return;
    }
    for (int k = 0; k < of->count; k++) {
        double x;
        memcpy(&x, from + of->field[k].offset, sizeof x);
        if (!isnan(x))
            sp_h5_put_fields(h, 1, &of->field[k], from);
    }
}

static void put_signal(sp_h5 *h, const sp_signal *s, const sp_signal_made *made) {
    const sp_h5_shape shape = {1, {s->n}};
    sp_h5_group(h, "/signal");
    sp_h5_put(h, &name_t, SP_H5_F64, &shape, s->t);
    sp_h5_put(h, &name_f, SP_H5_F64, &shape, s->f);
    sp_h5_put_fields(h, SIGNAL_FIELDS, signal_field, s);
    if (made->tolerance > 0)
        sp_h5_put_fields(h, 1, &tolerance_field, made);
    sp_h5_put_text(h, &name_method, sp_signal_method_name(s->method));
}

bool sp_is_zero(const sp_h5_field *f, const sp_sample *s) {
    static const char zero[8];
    return memcmp((const char *)s + f->offset, zero, f->type == SP_H5_I32 ? 4 : 8) == 0;
}

static void put_keys(sp_h5 *h, const sp_sample *s) {
    sp_h5_group(h, "/results");
    sp_h5_group(h, "/results/sample");
    sp_h5_put_text(h, &name_name, s->name);
    sp_h5_put_fields(h, SAMPLE_FIELDS, sample_field, s);
    for (int k = 0; k < OPTIONAL_FIELDS; k++)
        if (!sp_is_zero(&optional_field[k], s))
            sp_h5_put_fields(h, 1, &optional_field[k], s);
    if (s->lacks) {
        sp_h5_put_fields(h, LACKS_FIELDS, lacks_field, s);
        sp_h5_put_text(h, &name_reason, s->reason);
    }
}

void sp_record_put(sp_h5 *h, const sp_record *r) {
    const sp_sample *s = &r->sample;
    put_keys(h, s);
    if (r->scene)
        sp_h5_put_text(h, &name_scene, r->scene);
    for (int k = 0; k < PARTS; k++)
        if (s->have & part[k].want)
            put_part(h, &part[k], s);
    if (s->have & SP_WANT_PLANES)
        put_planes(h, s);
    if (s->have & SP_WANT_SPECTRUM)
        sp_h5_put(h, &name_omega, SP_H5_F64, &(sp_h5_shape){1, {r->arrays.modes}}, r->arrays.omega);
    if (r->arrays.signal.n > 0)
        put_signal(h, &r->arrays.signal, &s->signal);
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

static void get_planes(sp_h5 *h, sp_sample *s) {
    sp_h5_shape shape;
    if (sp_h5_find(h, sp_plane_fields[0].name.path, SP_H5_F64, 1, &shape) == SP_OK && shape.dim[0] > SP_PLANES_MAX)
        sp_h5_fail(h, SP_EFORMAT, "%s has %lld planes; at most %d", sp_plane_fields[0].name.path,
                   (long long)shape.dim[0], SP_PLANES_MAX);
    for (int k = 0; h->status == SP_OK && k < SP_PLANE_FIELDS; k++) {
        double x[SP_PLANES_MAX] = {0};
        sp_h5_get(h, sp_plane_fields[k].name.path, SP_H5_F64, &shape, x);
        for (int64_t i = 0; i < shape.dim[0]; i++)
            sp_plane_set(&sp_plane_fields[k], s, (int32_t)i, x[i]);
    }
    if (h->status == SP_OK)
        s->planes = (int32_t)shape.dim[0];
    s->have |= SP_WANT_PLANES;
}

/* Reads a part if the file has it. */
static void get_part(sp_h5 *h, const struct part *of, sp_sample *s) {
    const double none = NAN;
    char *to = (char *)s + of->offset;
    if (of->group && sp_h5_has(h, of->group)) {
        s->have |= of->want;
        sp_h5_get_fields(h, of->count, of->field, to);
    }
    for (int k = 0; !of->group && s->have & of->want && k < of->count; k++) {
        memcpy(to + of->field[k].offset, &none, sizeof none);
        if (sp_h5_has(h, of->field[k].name.path))
            sp_h5_get_fields(h, 1, &of->field[k], to);
    }
}

static sp_signal_method get_method(sp_h5 *h) {
    char *text = NULL;
    int k = 0;
    if (sp_h5_get_text(h, name_method.path, &text) != SP_OK)
        return SP_SIGNAL_AUTO;
    while (sp_signal_method_name((sp_signal_method)k) && strcmp(text, sp_signal_method_name((sp_signal_method)k)) != 0)
        k++;
    if (!sp_signal_method_name((sp_signal_method)k))
        sp_h5_fail(h, SP_EFORMAT, "%s is '%.60s'", name_method.path, text);
    sp_free(text);
    return (sp_signal_method)k;
}

/* Reads how the signal was computed; and the signal itself with arrays. */
static void get_signal(sp_h5 *h, bool with_arrays, sp_signal_made *made, sp_signal *s) {
    sp_h5_shape shape = {0};
    sp_h5_find(h, name_t.path, SP_H5_F64, 1, &shape);
    double *t = sp_h5_alloc(h, shape.dim[0], sizeof *t);
    sp_h5_get(h, name_t.path, SP_H5_F64, &shape, t);
    *made = (sp_signal_made){.points = (int32_t)shape.dim[0], .tolerance = NAN, .until = NAN};
    if (t && made->points > 0)
        made->until = t[made->points - 1];
    if (sp_h5_has(h, tolerance_field.name.path))
        sp_h5_get_fields(h, 1, &tolerance_field, made);
    made->method = get_method(h);
    if (!with_arrays || h->status != SP_OK) {
        sp_free(t);
        return;
    }
    *s = (sp_signal){.n = made->points, .sources = 1, .detectors = 1, .method = made->method, .t = t};
    s->f = sp_h5_alloc(h, s->n, sizeof *s->f);
    sp_h5_get(h, name_f.path, SP_H5_F64, &shape, s->f);
    sp_h5_get_fields(h, SIGNAL_FIELDS, signal_field, s);
}

/* Checks the number of frequencies, and reads them with arrays. */
static void get_omega(sp_h5 *h, const sp_spectrum_made *made, bool with_arrays, sp_sample_arrays *out) {
    const int64_t modes = (int64_t)made->carrying * made->dof;
    sp_h5_shape shape;
    if (sp_h5_find(h, name_omega.path, SP_H5_F64, 1, &shape) != SP_OK)
        return;
    if (modes < 1 || shape.dim[0] != modes || made->dof < 1)
        sp_h5_fail(h, SP_EFORMAT, "%s has %lld frequencies of %d grains with %d degrees of freedom each",
                   name_omega.path, (long long)shape.dim[0], made->carrying, made->dof);
    if (!with_arrays || !(out->omega = sp_h5_alloc(h, modes, sizeof *out->omega)))
        return;
    out->modes = modes;
    sp_h5_get(h, name_omega.path, SP_H5_F64, &shape, out->omega);
}

/* Reads a text that has place for `size` characters; a longer one is cut. */
static void get_short(sp_h5 *h, const char *path, size_t size, char *out) {
    char *text = NULL;
    if (sp_h5_get_text(h, path, &text) == SP_OK)
        snprintf(out, size, "%.*s", (int)size - 1, text);
    sp_free(text);
}

const char *sp_sample_fault(const sp_sample *s) {
    const bool rising = s->planes >= 0 && s->planes <= SP_PLANES_MAX;
    for (int32_t k = 0; rising && k < s->planes; k++)
        if (!(s->plane[k] > (k ? s->plane[k - 1] : 0)) || !isfinite(s->plane[k]))
            return "planes/height";
    return s->dim < 1 || s->dim > 3                                                    ? "sample/dim"
           : s->kind < SP_PACK_PISTON || s->kind > SP_PACK_MINIMUM                     ? "sample/kind"
           : s->grains < 1                                                             ? "sample/grains"
           : !(s->width > 0 && isfinite(s->width))                                     ? "sample/width"
           : !(s->pressure > 0 && isfinite(s->pressure))                               ? "sample/pressure"
           : !(s->friction >= 0 && isfinite(s->friction))                              ? "sample/friction"
           : !(s->fraction >= 0 && isfinite(s->fraction))                              ? "sample/fraction"
           : !(s->mean_stress >= 0 && isfinite(s->mean_stress))                        ? "sample/mean_stress"
           : s->stage < 0 || !isfinite(s->strain)                                      ? "sample/stage"
           : !rising                                                                   ? "planes/height"
           : !s->failed && (!(s->height >= 0 || isnan(s->height)) || isinf(s->height)) ? "sample/height"
                                                                                       : NULL;
}

sp_sample sp_sample_blank(void) {
    const double n = NAN;
    sp_sample s = {.moduli = {.error11 = n,
                              .error12 = n,
                              .error13 = n,
                              .error22 = n,
                              .error23 = n,
                              .error33 = n,
                              .error44 = n,
                              .error55 = n,
                              .error66 = n,
                              .error_bulk = n,
                              .error_shear = n}};
    for (int k = 0; k < SP_PROBES; k++)
        s.probe[k] = (sp_probe_moduli){.error_along = NAN, .error_shear = NAN, .grain = -1};
    return s;
}

static int add_results(sp_result *out, int used, int count, const sp_h5_field *field, const sp_result *of) {
    for (int k = 0; k < count; k++)
        out[used + k] = (sp_result){&field[k], of->offset + field[k].offset, of->want};
    return used + count;
}

int sp_results(sp_result out[SP_RESULTS_MAX]) {
    const sp_result always = {0};
    int used = add_results(out, 0, SAMPLE_FIELDS, sample_field, &always);
    used = add_results(out, used, OPTIONAL_FIELDS, optional_field, &always);
    used = add_results(out, used, LACKS_FIELDS, lacks_field, &always);
    for (int k = 0; k < PARTS; k++)
        used = add_results(out, used, part[k].count, part[k].field, &(sp_result){NULL, part[k].offset, part[k].want});
    return used;
}

static void get_keys(sp_h5 *h, sp_sample *s) {
    char name[SP_NAME_MAX + 1] = "";
    if (!sp_h5_has(h, "/results/sample"))
        sp_h5_fail(h, SP_EFORMAT, "no group /results/sample: not a sample of a store");
    get_short(h, name_name.path, sizeof name, name);
    if (strlen(name) >= SP_NAME_MAX)
        sp_h5_fail(h, SP_EFORMAT, "%s has more than %d characters", name_name.path, SP_NAME_MAX - 1);
    memcpy(s->name, name, SP_NAME_MAX - 1);
    sp_h5_get_fields(h, SAMPLE_FIELDS, sample_field, s);
    for (int k = 0; k < OPTIONAL_FIELDS; k++)
        if (sp_h5_has(h, optional_field[k].name.path))
            sp_h5_get_fields(h, 1, &optional_field[k], s);
    if (sp_h5_has(h, lacks_field[0].name.path)) {
        sp_h5_get_fields(h, LACKS_FIELDS, lacks_field, s);
        get_short(h, name_reason.path, sizeof s->reason, s->reason);
    }
}

sp_status sp_record_get(sp_h5 *h, bool with_arrays, sp_record *out) {
    sp_record r = {.sample = sp_sample_blank()};
    sp_sample *s = &r.sample;
    get_keys(h, s);
    for (int k = 0; k < PARTS; k++)
        get_part(h, &part[k], s);
    if (sp_h5_has(h, "/results/planes"))
        get_planes(h, s);
    const char *bad = h->status == SP_OK ? sp_sample_fault(s) : NULL;
    if (bad)
        sp_h5_fail(h, SP_EFORMAT, "/results/%s is no value of a sample", bad);
    if (sp_h5_has(h, "/signal")) {
        s->have |= SP_WANT_SIGNAL;
        get_signal(h, with_arrays, &s->signal, &r.arrays.signal);
    }
    if (s->have & SP_WANT_SPECTRUM)
        get_omega(h, &s->spectrum, with_arrays, &r.arrays);
    if (with_arrays && sp_h5_has(h, name_scene.path))
        sp_h5_get_text(h, name_scene.path, &r.scene);
    if (h->status == SP_OK)
        *out = r;
    else
        sp_record_free(&r);
    return h->status;
}
