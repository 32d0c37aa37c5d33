/* Writes and reads files of modes. */
#include "base/base.h"
#include "store/h5.h"

#include <math.h>
#include <sonopack/study/modes_file.h>
#include <sonopack/version.h>
#include <string.h>

/* Increased when older versions would misread the format. */
enum { MODES_FORMAT = 1, COMPLEX_FORMAT = 2 };

#define FREQUENCY "sqrt(E* / rho)/d"

static const sp_h5_name name_vector = {
    "/modes/vector", "1",
    "one mode a row: e = M^(1/2) u, orthonormal, the largest component positive; the "
    "first row is mode n_rattler of omega"};
static const sp_h5_name name_mass = {"/modes/mass", "rho d^3, rho d^5",
                                     "mass, or moment of inertia, of each column of vector: u = vector / sqrt(mass)"};
static const sp_h5_name name_grain = {"/modes/grain", "1",
                                      "grains of the network by their number in the packing, from 0"};
static const sp_h5_name name_column = {
    "/modes/column", "1",
    "of each column of vector: the grain's number in the packing, and the component: 0, "
    "1, 2 displacement along x, y, z; 3, 4, 5 rotation about x, y, z"};
static const sp_h5_name name_rattler = {"/modes/rattler", "1", "grains that are not in the network"};
static const sp_h5_name name_packing = {"/modes/packing", "1", "hash of the packing's grains, contacts and box"};
static const sp_h5_name name_source = {"/modes/source", "1", "source of a: impulse, velocity or displacement"};
static const sp_h5_name name_solver = {"/modes/solver", "1", "dense: LAPACK; lanczos: block Lanczos; arpack: ARPACK"};

/* Arrays with one number for each mode. */
static const struct mode_array {
    sp_h5_name name;
    size_t offset; /* of the pointer in sp_modes */
} array[] = {
    {{"/modes/omega", FREQUENCY, "angular frequency, ascending; 0: a zero mode"}, offsetof(sp_modes, omega)},
    {{"/modes/error", FREQUENCY, "upper bound of the error of omega"}, offsetof(sp_modes, error)},
    {{"/modes/a", "d sqrt(rho d^3)",
      "amplitude of the source: signal = sum a b sin(omega t); nan: nothing touches the bottom wall"},
     offsetof(sp_modes, a)},
    {{"/modes/b", "E* d/sqrt(rho d^3)", "force on the top wall; nan: nothing touches it"}, offsetof(sp_modes, b)},
    {{"/modes/participation", "1", "(sum w)^2/(N sum w^2), w = |e|^2 of a grain, N grains in the network"},
     offsetof(sp_modes, participation)},
};
enum { ARRAYS = sizeof array / sizeof *array };

/* Counts and certificate. */
#define COUNT(path, member, meaning)                                                                                   \
    { {"/modes/" path, "1", meaning}, SP_H5_I64, offsetof(sp_modes, member) }
#define NUMBER(path, member, unit, meaning)                                                                            \
    { {"/modes/" path, unit, meaning}, SP_H5_F64, offsetof(sp_modes, member) }
static const sp_h5_field field[] = {
    COUNT("first", first, "modes of the whole spectrum below the first of this file"),
    COUNT("n_rattler", n_rattler, "zero modes of rattlers: the first of omega, without vectors"),
    COUNT("n_zero", n_zero, "modes with omega = 0, those of rattlers included"),
    COUNT("zero_rattlers", zero.rattlers, "zero modes of the packing: of rattlers"),
    COUNT("zero_spins", zero.spins, "zero modes of single grains that turn"),
    COUNT("zero_rigid", zero.rigid, "zero modes of grains that move as a rigid body"),
    COUNT("zero_mechanisms", zero.mechanisms, "zero modes of all other kinds"),
    COUNT("zero_total", zero.total, "all zero modes of the packing"),
    NUMBER("zero_below", zero.below, FREQUENCY, "modes below this frequency count as zero modes"),
    COUNT("on_edge", on_edge, "modes within their own error of an end of the band"),
    NUMBER("certified_from", certified_from, FREQUENCY, "no mode is missing from here ..."),
    NUMBER("certified_to", certified_to, FREQUENCY, "... to here"),
    NUMBER("residual", residual, "1", "largest |A e - omega^2 e|/omega_max^2, A = M^(-1/2) K M^(-1/2)"),
    NUMBER("orthogonality", orthogonality, "1", "largest |e_m . e_n - delta_mn|"),
};
enum { FIELDS = sizeof field / sizeof *field };

/* The same of modes that may grow, without those of rattlers; offset: in sp_complex_modes. */
static const struct mode_array complex_array[] = {
    {{"/modes/omega", FREQUENCY, "imaginary part of the exponent: the motion is M^(-1/2) e exp((growth + i omega) t)"},
     offsetof(sp_complex_modes, omega)},
    {{"/modes/growth", FREQUENCY, "real part of the exponent; negative: the motion decays"},
     offsetof(sp_complex_modes, growth)},
    {{"/modes/error", FREQUENCY, "upper bound of |growth + i omega - exact|"}, offsetof(sp_complex_modes, error)},
    {{"/modes/cosine", "E* d^2", "signal = sum exp(growth t) (cosine cos(omega t) + sine sin(omega t))"},
     offsetof(sp_complex_modes, cosine)},
    {{"/modes/sine", "E* d^2", "see cosine"}, offsetof(sp_complex_modes, sine)},
};
enum { COMPLEX_ARRAYS = sizeof complex_array / sizeof *complex_array };

static const struct mode_array complex_vector[] = {
    {{"/modes/vector", "1",
      "real part of e, one mode a row: A e = -(growth + i omega)^2 e, A = M^(-1/2) J M^(-1/2), |e| = 1, the largest "
      "component positive"},
     offsetof(sp_complex_modes, right)},
    {{"/modes/vector_imaginary", "1", "imaginary part of e"}, offsetof(sp_complex_modes, right_im)},
    {{"/modes/left", "1", "real part of f: A^T f = -(growth + i omega)^2 f, f . e = 1 without conjugation"},
     offsetof(sp_complex_modes, left)},
    {{"/modes/left_imaginary", "1", "imaginary part of f"}, offsetof(sp_complex_modes, left_im)},
};

#define OF_COMPLEX(path, type, member, unit, meaning)                                                                  \
    { {"/modes/" path, unit, meaning}, SP_H5_##type, offsetof(sp_complex_modes, member) }
static const sp_h5_field complex_field[] = {
    OF_COMPLEX("first", I64, first, "1", "motions of the whole spectrum below the first of this file"),
    OF_COMPLEX("pairs", I64, pairs, "1", "complex pairs of omega^2"),
    OF_COMPLEX("zero_motions", I64, zero, "1", "motions that count as zero and have no rows"),
    OF_COMPLEX("on_edge", I64, on_edge, "1", "motions within their own error of an end of the band"),
    OF_COMPLEX("complete", F64, complete, FREQUENCY, "no motion below this omega is missing, but zero motions"),
    OF_COMPLEX("residual", F64, residual, "1",
               "largest |A e - z e| and |A^T f - z f|/|f| over the square of the bound of all frequencies"),
    OF_COMPLEX("orthogonality", F64, orthogonality, "1", "largest |f_m . e_n - delta_mn|"),
};
enum { COMPLEX_FIELDS = sizeof complex_field / sizeof *complex_field };

/* The network, and what a mode is. */
typedef struct network_numbers {
    double threshold;
    int32_t prestress, sliding_free, dim, dof;
} network_numbers;
#define OF_NETWORK(path, type, member, meaning)                                                                        \
    { {"/modes/" path, "1", meaning}, SP_H5_##type, offsetof(network_numbers, member) }
static const sp_h5_field network_field[] = {
    OF_NETWORK("threshold", F64, threshold, "contacts with F_n > threshold p d^2 carry force"),
    OF_NETWORK("prestress", I32, prestress, "1: with the rotation of the forces at rest"),
    OF_NETWORK("sliding_free", I32, sliding_free, "1: contacts at Coulomb's limit have no tangential stiffness"),
    OF_NETWORK("dimension", I32, dim, "dimension: 1, 2 or 3; the last axis is up"),
    OF_NETWORK("freedoms", I32, dof, "degrees of freedom of a grain: translations, then rotations"),
};
enum { NETWORK_FIELDS = sizeof network_field / sizeof *network_field };

static const char *const sources[] = {"impulse", "velocity", "displacement", NULL};
static const char *const solvers[] = {"auto", "lanczos", "arpack", "dense", NULL};

static const sp_h5_name name_vector_error = {
    "/modes/vector_error", "1",
    "upper bound of |e - exact|, one for each row of vector; 1.41: not determined, for other modes nearly coincide"};

static const sp_h5_shape single = {0};

static double **array_at(int k, sp_modes *m) { return (double **)(void *)((char *)m + array[k].offset); }

/* ---- writing --------------------------------------------------------------------------------------------------- */

static void put_vector_errors(sp_h5 *h, const sp_modes *m, const sp_network *net) {
    const sp_h5_shape rows = {1, {m->n - m->n_rattler}};
    double *error = sp_h5_alloc(h, rows.dim[0], sizeof *error);
    for (int64_t k = 0; error && k < rows.dim[0]; k++)
        error[k] = sp_modes_vector_error(m, net, m->n_rattler + k);
    sp_h5_put(h, &name_vector_error, SP_H5_F64, &rows, error);
    sp_free(error);
}

/* What a file belongs to. */
typedef struct place {
    const sp_packing *p;
    const sp_network *net;
    const sp_modes_made *made;
} place;

static sp_status check(const place *at, int64_t dofs, bool vectors, sp_error *err) {
    if (!vectors)
        return sp_fail(err, SP_EINVAL, "modes without vectors: nothing to save");
    if (dofs != sp_network_dofs(at->net) || at->net->n_all != at->p->n || at->net->dim != at->p->dim)
        return sp_fail(err, SP_EINVAL, "modes of %lld degrees of freedom, network of %lld, packing of %d grains",
                       (long long)dofs, (long long)sp_network_dofs(at->net), at->p->n);
    if (at->made->network.tangential != SP_SPRINGS_CONSTANT)
        return sp_fail_key(err, SP_EREFUSED, "network.tangential",
                           ": must be \"constant\" for a file of modes, which cannot say otherwise");
    return SP_OK;
}

/* 2D: the rotation is about z. */
static int32_t component_of(const sp_network *net, int a) { return a < net->dim ? a : net->dim == 2 ? 5 : a; }

/* Which grain and which component each column is, and which grains are in no column. */
static void put_columns(sp_h5 *h, const sp_network *net) {
    const sp_h5_shape grains = {1, {net->n}}, columns = {2, {sp_network_dofs(net), 2}}, left = {1, {net->rattlers}};
    int32_t *column = sp_h5_alloc(h, sp_network_dofs(net), 2 * sizeof *column);
    int32_t *rattler = sp_h5_alloc(h, net->rattlers, sizeof *rattler);
    for (int32_t i = 0, next = 0, at = 0; h->status == SP_OK && i < net->n_all; i++) {
        if (next == net->n || net->grain[next] != i) {
            rattler[at++] = i;
            continue;
        }
        for (int a = 0; a < net->dof; a++) {
            column[2 * ((int64_t)next * net->dof + a)] = i;
            column[2 * ((int64_t)next * net->dof + a) + 1] = component_of(net, a);
        }
        next++;
    }
    sp_h5_put(h, &name_grain, SP_H5_I32, &grains, net->grain);
    sp_h5_put(h, &name_column, SP_H5_I32, &columns, column);
    sp_h5_put(h, &name_rattler, SP_H5_I32, &left, rattler);
    sp_free(rattler);
    sp_free(column);
}

static void put_head(sp_h5 *h, const place *at, int32_t format) {
    const char *const version = SONOPACK_VERSION;
    const uint64_t hash = sp_packing_hash(at->p);
    sp_h5_group(h, "/modes");
    sp_h5_attribute_ints(h, "/modes", "format", 0, &format);
    sp_h5_attribute_texts(h, "/modes", "version", 0, &version);
    sp_h5_put(h, &name_packing, SP_H5_U64, &single, &hash);
}

static void put_network(sp_h5 *h, const place *at) {
    const sp_network_options *o = &at->made->network;
    const network_numbers numbers = {o->threshold, o->prestress, o->sliding_free, at->net->dim, at->net->dof};
    sp_h5_put_fields(h, NETWORK_FIELDS, network_field, &numbers);
    sp_h5_put_text(h, &name_source, sources[at->made->source]);
}

static void put_mass(sp_h5 *h, const sp_network *net) {
    const sp_h5_shape columns = {1, {sp_network_dofs(net)}};
    put_columns(h, net);
    sp_h5_put(h, &name_mass, SP_H5_F64, &columns, net->mass);
}

static void put_all(sp_h5 *h, const sp_modes *m, const place *at) {
    const sp_h5_shape modes = {1, {m->n}}, vectors = {2, {m->n - m->n_rattler, m->dofs}};
    sp_modes all = *m;
    put_head(h, at, MODES_FORMAT);
    sp_h5_put_fields(h, FIELDS, field, m);
    put_network(h, at);
    sp_h5_put_text(h, &name_solver, solvers[m->solver]);
    for (int k = 0; k < ARRAYS; k++)
        sp_h5_put(h, &array[k].name, SP_H5_F64, &modes, *array_at(k, &all));
    put_mass(h, at->net);
    put_vector_errors(h, m, at->net);
    sp_h5_put_rows(h, &name_vector, SP_H5_F64, &vectors, m->vectors);
}

static const double *complex_at(const struct mode_array *a, const sp_complex_modes *m) {
    return *(double *const *)(const void *)((const char *)m + a->offset);
}

static void put_complex(sp_h5 *h, const sp_complex_modes *m, const place *at) {
    const sp_h5_shape modes = {1, {m->n - m->rattlers}}, vectors = {2, {modes.dim[0], m->dofs}};
    sp_complex_modes rest = *m;
    rest.first += m->rattlers;
    put_head(h, at, COMPLEX_FORMAT);
    sp_h5_put_fields(h, COMPLEX_FIELDS, complex_field, &rest);
    put_network(h, at);
    for (const struct mode_array *a = complex_array; a < complex_array + COMPLEX_ARRAYS; a++)
        sp_h5_put(h, &a->name, SP_H5_F64, &modes, complex_at(a, m) + m->rattlers);
    put_mass(h, at->net);
    for (const struct mode_array *a = complex_vector; a < complex_vector + 4; a++)
        sp_h5_put_rows(h, &a->name, SP_H5_F64, &vectors, complex_at(a, m));
}

sp_status sp_modes_save(const sp_modes *m, const sp_packing *p, const sp_network *net, const sp_modes_made *made,
                        const char *path, sp_error *err) {
    const place at = {p, net, made};
    const bool vectors = m->n == 0 || (m->a && (m->vectors || m->n == m->n_rattler));
    const sp_status status = check(&at, m->dofs, vectors, err);
    sp_h5 h;
    if (status != SP_OK)
        return status;
    sp_folder_clean_beside(path); /* drafts are large, and so is what a killed process leaves */
    if (sp_h5_create(&h, path, err) == SP_OK)
        put_all(&h, m, &at);
    return sp_h5_close(&h);
}

sp_status sp_complex_modes_save(const sp_complex_modes *m, const sp_packing *p, const sp_network *net,
                                const sp_modes_made *made, const char *path, sp_error *err) {
    const place at = {p, net, made};
    const sp_status status = check(&at, m->dofs, m->right || m->n == m->rattlers, err);
    sp_h5 h;
    if (status != SP_OK)
        return status;
    sp_folder_clean_beside(path);
    if (sp_h5_create(&h, path, err) == SP_OK)
        put_complex(&h, m, &at);
    return sp_h5_close(&h);
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

sp_modes_file sp_modes_file_none(void) { return (sp_modes_file){.modes = sp_modes_none()}; }

void sp_modes_file_free(sp_modes_file *f) {
    sp_modes_free(&f->modes);
    sp_free(f->grain);
    sp_free(f->mass);
    *f = sp_modes_file_none();
}

static void get_head(sp_h5 *h, const sp_packing *p, sp_modes_file *f) {
    network_numbers numbers = {0};
    int64_t format;
    int source = 0, solver = 0;
    if (!sp_h5_has(h, "/modes"))
        sp_h5_fail(h, SP_EFORMAT, "no group /modes: not a file of `sonopack modes --vectors'");
    if (sp_h5_attribute_int(h, "/modes", "format", &format) == SP_OK && format == COMPLEX_FORMAT)
        sp_h5_fail(h, SP_EFORMAT,
                   "modes that may grow; must be a table of one, of `sonopack modes --vectors FILE.tsv --mode N'");
    if (h->status == SP_OK && format != MODES_FORMAT)
        sp_h5_fail(h, SP_EFORMAT, "format %lld of /modes; this version reads format %d", (long long)format,
                   MODES_FORMAT);
    sp_h5_get(h, name_packing.path, SP_H5_U64, &single, &f->packing);
    sp_h5_get_fields(h, FIELDS, field, &f->modes);
    sp_h5_get_fields(h, NETWORK_FIELDS, network_field, &numbers);
    sp_h5_get_word(h, name_source.path, sources, &source);
    sp_h5_get_word(h, name_solver.path, solvers, &solver);
    f->dim = numbers.dim;
    f->dof = numbers.dof;
    f->modes.solver = (sp_modes_solver)solver;
    f->made.source = (sp_source)source;
    f->made.network = (sp_network_options){
        .threshold = numbers.threshold, .prestress = numbers.prestress != 0, .sliding_free = numbers.sliding_free != 0};
    if (f->packing != sp_packing_hash(p))
        sp_h5_fail(h, SP_EFORMAT, "the modes are of another packing: %s is %016llx; must be %016llx", name_packing.path,
                   (unsigned long long)f->packing, (unsigned long long)sp_packing_hash(p));
    if (f->dim != p->dim)
        sp_h5_fail(h, SP_EFORMAT, "/modes/dimension is %d; must be %d", f->dim, p->dim);
}

/* The numbers of modes, grains and columns must agree before memory is taken. */
static sp_status get_sizes(sp_h5 *h, const sp_packing *p, sp_modes_file *f) {
    sp_modes *m = &f->modes;
    sp_h5_shape modes, grains, vectors;
    sp_h5_find(h, array[0].name.path, SP_H5_F64, 1, &modes);
    sp_h5_find(h, name_grain.path, SP_H5_I32, 1, &grains);
    if (sp_h5_find(h, name_vector.path, SP_H5_F64, 2, &vectors) != SP_OK)
        return h->status;
    m->n = modes.dim[0];
    f->n = (int32_t)grains.dim[0];
    m->dofs = vectors.dim[1];
    const bool turns = f->dof == (f->dim == 1 ? 1 : f->dim == 2 ? 3 : 6), slides = f->dof == f->dim;
    if ((!turns && !slides) || f->n < 1 || f->n > p->n || m->dofs != (int64_t)f->n * f->dof)
        return sp_h5_fail(h, SP_EFORMAT, "%d grains of %d with %d degrees of freedom, and %lld columns of vector", f->n,
                          p->n, f->dof, (long long)m->dofs);
    const sp_zero_modes *z = &m->zero;
    const bool counted = z->rattlers >= 0 && z->spins >= 0 && z->rigid >= 0 && z->mechanisms >= 0 && z->below >= 0 &&
                         z->total == z->rattlers + z->spins + z->rigid + z->mechanisms;
    if (!counted || m->n_zero > z->total || m->first > (int64_t)p->n * f->dof - m->n)
        return sp_h5_fail(h, SP_EFORMAT,
                          "%lld modes from number %lld on, of %d grains, and %lld zero modes: a count is wrong",
                          (long long)m->n, (long long)m->first, p->n, (long long)z->total);
    if (m->n_rattler < 0 || m->n_rattler > m->n_zero || m->n_zero > m->n || m->first < 0 || m->on_edge < 0 ||
        vectors.dim[0] != m->n - m->n_rattler)
        return sp_h5_fail(h, SP_EFORMAT,
                          "%lld modes, %lld of them of rattlers, %lld zero modes, and %lld rows of vector",
                          (long long)m->n, (long long)m->n_rattler, (long long)m->n_zero, (long long)vectors.dim[0]);
    return SP_OK;
}

static void get_arrays(sp_h5 *h, sp_modes_file *f) {
    sp_modes *m = &f->modes;
    const sp_h5_shape modes = {1, {m->n}}, grains = {1, {f->n}}, columns = {1, {m->dofs}};
    double *block = m->omega = sp_h5_alloc(h, ARRAYS * m->n, sizeof *block); /* sp_modes_free frees the block */
    f->grain = sp_h5_alloc(h, f->n, sizeof *f->grain);
    f->mass = sp_h5_alloc(h, m->dofs, sizeof *f->mass);
    for (int k = 0; k < ARRAYS && h->status == SP_OK; k++)
        sp_h5_get(h, array[k].name.path, SP_H5_F64, &modes, *array_at(k, m) = block + k * m->n);
    sp_h5_get(h, name_grain.path, SP_H5_I32, &grains, f->grain);
    sp_h5_get(h, name_mass.path, SP_H5_F64, &columns, f->mass);
}

/* Whether all numbers are finite, or (amplitudes without a wall) none is. */
static bool all_or_none(int64_t n, const double *x) {
    int64_t finite = 0, missing = 0;
    for (int64_t k = 0; k < n; k++) {
        finite += isfinite(x[k]) != 0;
        missing += isnan(x[k]) != 0;
    }
    return finite == n || missing == n;
}

static sp_status check_modes(sp_h5 *h, const sp_modes *m) {
    for (int64_t k = 0; k < m->n; k++) {
        const double omega = m->omega[k], error = m->error[k], part = m->participation[k];
        if (!(omega >= (k > 0 ? m->omega[k - 1] : 0) && isfinite(omega)) || (omega > 0) != (k >= m->n_zero))
            return sp_h5_fail(h, SP_EFORMAT, "omega[%lld] is %g; must be finite, ascending, and 0 for zero modes",
                              (long long)k, omega);
        if (!(error >= 0 && isfinite(error)) || !(part > 0 && part <= 1 + 1e-9))
            return sp_h5_fail(h, SP_EFORMAT, "error[%lld] is %g and participation %g", (long long)k, error, part);
    }
    if (!all_or_none(m->n, m->a) || !all_or_none(m->n, m->b))
        return sp_h5_fail(h, SP_EFORMAT, "an amplitude a or b is not finite");
    const bool measured = m->residual >= 0 && m->orthogonality >= 0;
    if (!(m->certified_from >= 0 && m->certified_from <= m->certified_to) || (m->n > m->n_rattler && !measured))
        return sp_h5_fail(h, SP_EFORMAT, "certified %g to %g, residual %g, orthogonality %g", m->certified_from,
                          m->certified_to, m->residual, m->orthogonality);
    return SP_OK;
}

static sp_status check_columns(sp_h5 *h, const sp_modes_file *f, const sp_packing *p) {
    for (int32_t k = 0; k < f->n; k++)
        if (f->grain[k] < (k > 0 ? f->grain[k - 1] + 1 : 0) || f->grain[k] >= p->n)
            return sp_h5_fail(h, SP_EFORMAT, "%s[%d] is %d; must ascend within 0..%d", name_grain.path, k, f->grain[k],
                              p->n - 1);
    for (int64_t k = 0; k < f->modes.dofs; k++)
        if (!(f->mass[k] > 0 && isfinite(f->mass[k])))
            return sp_h5_fail(h, SP_EFORMAT, "%s[%lld] is %g; must be positive", name_mass.path, (long long)k,
                              f->mass[k]);
    return SP_OK;
}

bool sp_modes_file_looks(const char *path) {
    sp_h5 h;
    sp_error reason = {0};
    const bool looks = sp_h5_open(&h, path, &reason) == SP_OK && sp_h5_has(&h, "/modes");
    sp_h5_close(&h);
    return looks;
}

sp_status sp_modes_file_read(const char *path, const sp_packing *p, sp_modes_file *out, sp_error *err) {
    sp_modes_file f = sp_modes_file_none();
    sp_h5 h;
    if (sp_h5_open(&h, path, err) == SP_OK)
        get_head(&h, p, &f);
    if (h.status == SP_OK && get_sizes(&h, p, &f) == SP_OK)
        get_arrays(&h, &f);
    if (h.status == SP_OK && check_modes(&h, &f.modes) == SP_OK)
        check_columns(&h, &f, p);
    const sp_status status = sp_h5_close(&h);
    if (status == SP_OK)
        *out = f;
    else
        sp_modes_file_free(&f);
    return status;
}

/* A damaged vector is nearly never a unit vector. */
static sp_status check_unit(const char *path, const sp_modes_file *f, int64_t row, int64_t count, const double *e,
                            sp_error *err) {
    for (int64_t k = 0; k < count; k++) {
        double sum = 0;
        for (int64_t c = 0; c < f->modes.dofs; c++)
            sum += e[k * f->modes.dofs + c] * e[k * f->modes.dofs + c];
        if (!(fabs(sum - 1) <= 1e-6))
            return sp_fail(err, SP_EFORMAT, "%s: the vector of mode %lld has the length %.6g; must be 1", path,
                           (long long)(f->modes.first + row + k), sqrt(sum));
    }
    return SP_OK;
}

sp_status sp_modes_file_vectors(const char *path, const sp_modes_file *f, int64_t row, int64_t count, double *out,
                                sp_error *err) {
    const sp_modes *m = &f->modes;
    const sp_h5_shape whole = {2, {m->n - m->n_rattler, m->dofs}};
    if (row < m->n_rattler || count < 0 || row > m->n - count)
        return sp_fail(err, SP_EINVAL, "%s: vectors of rows %lld .. %lld, must be within %lld .. %lld", path,
                       (long long)row, (long long)(row + count - 1), (long long)m->n_rattler, (long long)m->n - 1);
    sp_h5 h;
    if (sp_h5_open(&h, path, err) == SP_OK)
        sp_h5_get_rows(&h, name_vector.path, SP_H5_F64, &whole, row - m->n_rattler, count, out);
    const sp_status status = sp_h5_close(&h);
    return status == SP_OK ? check_unit(path, f, row, count, out, err) : status;
}
