/* Writes files of modes. */
#include "store/modes_h5.h"

#include "base/base.h"
#include "base/file.h"

#include <sonopack/version.h>

#define FREQUENCY "sqrt(E* / rho)/d"

const sp_h5_name sp_modes_name_vector = {
    "/modes/vector", "1",
    "one mode a row: e = M^(1/2) u, orthonormal, the largest component positive; the "
    "first row is mode n_rattler of omega"};
const sp_h5_name sp_modes_name_mass = {"/modes/mass", "rho d^3, rho d^5",
                                       "mass, or moment of inertia, of each column of vector: u = vector / sqrt(mass)"};
const sp_h5_name sp_modes_name_grain = {"/modes/grain", "1",
                                        "grains of the network by their number in the packing, from 0"};
const sp_h5_name sp_modes_name_column = {
    "/modes/column", "1",
    "of each column of vector: the grain's number in the packing, and the component: 0, "
    "1, 2 displacement along x, y, z; 3, 4, 5 rotation about x, y, z"};
const sp_h5_name sp_modes_name_rattler = {"/modes/rattler", "1", "grains that are not in the network"};
const sp_h5_name sp_modes_name_packing = {"/modes/packing", "1", "hash of the packing's grains, contacts and box"};
const sp_h5_name sp_modes_name_source = {"/modes/source", "1", "source of a: impulse, velocity or displacement"};
const sp_h5_name sp_modes_name_solver = {"/modes/solver", "1", "dense: LAPACK; lanczos: block Lanczos; arpack: ARPACK"};

const sp_modes_array sp_modes_arrays[SP_MODES_ARRAYS] = {
    {{"/modes/omega", FREQUENCY, "angular frequency, ascending; 0: a zero mode"}, offsetof(sp_modes, omega)},
    {{"/modes/error", FREQUENCY, "upper bound of the error of omega"}, offsetof(sp_modes, error)},
    {{"/modes/a", "d sqrt(rho d^3)",
      "amplitude of the source: signal = sum a b sin(omega t); nan: nothing touches the bottom wall"},
     offsetof(sp_modes, a)},
    {{"/modes/b", "E* d/sqrt(rho d^3)", "force on the top wall; nan: nothing touches it"}, offsetof(sp_modes, b)},
    {{"/modes/participation", "1", "(sum w)^2/(N sum w^2), w = |e|^2 of a grain, N grains in the network"},
     offsetof(sp_modes, participation)},
};

const sp_h5_field sp_modes_fields[] = {
    {{"/modes/first", "1", "modes of the whole spectrum below the first of this file"},
     SP_H5_I64,
     offsetof(sp_modes, first)},
    {{"/modes/n_rattler", "1", "zero modes of rattlers: the first of omega, without vectors"},
     SP_H5_I64,
     offsetof(sp_modes, n_rattler)},
    {{"/modes/n_zero", "1", "modes with omega = 0, those of rattlers included"}, SP_H5_I64, offsetof(sp_modes, n_zero)},
    {{"/modes/zero_rattlers", "1", "zero modes of the packing: of rattlers"},
     SP_H5_I64,
     offsetof(sp_modes, zero.rattlers)},
    {{"/modes/zero_spins", "1", "zero modes of single grains that turn"}, SP_H5_I64, offsetof(sp_modes, zero.spins)},
    {{"/modes/zero_rigid", "1", "zero modes of grains that move as a rigid body"},
     SP_H5_I64,
     offsetof(sp_modes, zero.rigid)},
    {{"/modes/zero_mechanisms", "1", "zero modes of all other kinds"}, SP_H5_I64, offsetof(sp_modes, zero.mechanisms)},
    {{"/modes/zero_total", "1", "all zero modes of the packing"}, SP_H5_I64, offsetof(sp_modes, zero.total)},
    {{"/modes/zero_below", FREQUENCY, "modes below this frequency count as zero modes"},
     SP_H5_F64,
     offsetof(sp_modes, zero.below)},
    {{"/modes/on_edge", "1", "modes within their own error of an end of the band"},
     SP_H5_I64,
     offsetof(sp_modes, on_edge)},
    {{"/modes/certified_from", FREQUENCY, "no mode is missing from here ..."},
     SP_H5_F64,
     offsetof(sp_modes, certified_from)},
    {{"/modes/certified_to", FREQUENCY, "... to here"}, SP_H5_F64, offsetof(sp_modes, certified_to)},
    {{"/modes/residual", "1", "largest |A e - omega^2 e|/omega_max^2, A = M^(-1/2) K M^(-1/2)"},
     SP_H5_F64,
     offsetof(sp_modes, residual)},
    {{"/modes/orthogonality", "1", "largest |e_m . e_n - delta_mn|"}, SP_H5_F64, offsetof(sp_modes, orthogonality)},
};
const int sp_modes_field_count = sizeof sp_modes_fields / sizeof *sp_modes_fields;

const sp_h5_field sp_modes_network_fields[] = {
    {{"/modes/threshold", "1", "contacts with F_n > threshold p d^2 carry force"},
     SP_H5_F64,
     offsetof(sp_modes_numbers, threshold)},
    {{"/modes/prestress", "1", "1: with the rotation of the forces at rest"},
     SP_H5_I32,
     offsetof(sp_modes_numbers, prestress)},
    {{"/modes/sliding_free", "1", "1: contacts at Coulomb's limit have no tangential stiffness"},
     SP_H5_I32,
     offsetof(sp_modes_numbers, sliding_free)},
    {{"/modes/dimension", "1", "dimension: 1, 2 or 3; the last axis is up"},
     SP_H5_I32,
     offsetof(sp_modes_numbers, dim)},
    {{"/modes/freedoms", "1", "degrees of freedom of a grain: translations, then rotations"},
     SP_H5_I32,
     offsetof(sp_modes_numbers, dof)},
};
const int sp_modes_network_field_count = sizeof sp_modes_network_fields / sizeof *sp_modes_network_fields;

const char *const sp_modes_sources[3] = {"impulse", "velocity", "displacement"};
const char *const sp_modes_solvers[4] = {"auto", "lanczos", "arpack", "dense"};

static const sp_h5_name vector_error = {"/modes/vector_error", "1",
                                        "upper bound of |e - exact|, one for each row of vector; 1.41: not determined, "
                                        "for other modes nearly coincide"};

static sp_status put_vector_errors(sp_h5 *h, const sp_modes *m, const sp_network *net, sp_error *err) {
    const sp_h5_shape rows = {1, {m->n - m->n_rattler}};
    double *error = sp_alloc((size_t)rows.dim[0], sizeof *error);
    if (!error)
        return sp_fail_memory(err, (size_t)rows.dim[0] * sizeof *error);
    for (int64_t k = 0; k < rows.dim[0]; k++)
        error[k] = sp_modes_vector_error(m, net, m->n_rattler + k);
    const sp_status status = sp_h5_put(h, &vector_error, SP_H5_F64, &rows, error, err);
    sp_free(error);
    return status;
}

static sp_status check(const sp_modes *m, const sp_packing *p, const sp_network *net, sp_error *err) {
    if (m->n > 0 && (!m->a || (!m->vectors && m->n > m->n_rattler)))
        return sp_fail(err, SP_EINVAL, "modes without vectors: nothing to save");
    if (m->dofs != sp_network_dofs(net) || net->n_all != p->n || net->dim != p->dim)
        return sp_fail(err, SP_EINVAL, "modes of %lld degrees of freedom, network of %lld, packing of %d grains",
                       (long long)m->dofs, (long long)sp_network_dofs(net), p->n);
    return SP_OK;
}

/* 2D: the rotation is about z. */
static int32_t component_of(const sp_network *net, int a) { return a < net->dim ? a : net->dim == 2 ? 5 : a; }

/* Which grain and which component each column is, and which grains are in no column. */
static sp_status put_columns(sp_h5 *h, const sp_network *net, sp_error *err) {
    const sp_h5_shape grains = {1, {net->n}}, columns = {2, {sp_network_dofs(net), 2}}, left = {1, {net->rattlers}};
    int32_t *column = sp_alloc((size_t)sp_network_dofs(net), 2 * sizeof *column);
    int32_t *rattler = sp_alloc((size_t)net->rattlers, sizeof *rattler);
    sp_status status =
        column && rattler ? SP_OK : sp_fail_memory(err, (size_t)sp_network_dofs(net) * 2 * sizeof *column);
    for (int32_t i = 0, next = 0, at = 0; status == SP_OK && i < net->n_all; i++) {
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
    if (status == SP_OK)
        status = sp_h5_put(h, &sp_modes_name_grain, SP_H5_I32, &grains, net->grain, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &sp_modes_name_column, SP_H5_I32, &columns, column, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &sp_modes_name_rattler, SP_H5_I32, &left, rattler, err);
    sp_free(rattler);
    sp_free(column);
    return status;
}

static sp_status put_head(sp_h5 *h, const sp_modes *m, const sp_packing *p, const sp_network *net,
                          const sp_modes_made *made, sp_error *err) {
    const char *const version = SONOPACK_VERSION;
    const int32_t format = SP_MODES_FORMAT;
    const sp_h5_shape single = {0};
    const uint64_t hash = sp_packing_hash(p);
    const sp_modes_numbers numbers = {made->network.threshold, made->network.prestress, made->network.sliding_free,
                                      net->dim, net->dof};
    sp_status status = sp_h5_group(h, "/modes", err);
    if (status == SP_OK)
        status = sp_h5_attribute_ints(h, "/modes", "format", 0, &format, err);
    if (status == SP_OK)
        status = sp_h5_attribute_texts(h, "/modes", "version", 0, &version, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &sp_modes_name_packing, SP_H5_U64, &single, &hash, err);
    if (status == SP_OK)
        status = sp_h5_put_fields(h, sp_modes_field_count, sp_modes_fields, m, err);
    if (status == SP_OK)
        status = sp_h5_put_fields(h, sp_modes_network_field_count, sp_modes_network_fields, &numbers, err);
    if (status == SP_OK)
        status = sp_h5_put_text(h, &sp_modes_name_source, sp_modes_sources[made->source], err);
    if (status == SP_OK)
        status = sp_h5_put_text(h, &sp_modes_name_solver, sp_modes_solvers[m->solver], err);
    return status;
}

static sp_status put_all(sp_h5 *h, const sp_modes *m, const sp_packing *p, const sp_network *net,
                         const sp_modes_made *made, sp_error *err) {
    const sp_h5_shape modes = {1, {m->n}}, columns = {1, {m->dofs}}, vectors = {2, {m->n - m->n_rattler, m->dofs}};
    sp_modes all = *m;
    sp_status status = put_head(h, m, p, net, made, err);
    for (int k = 0; k < SP_MODES_ARRAYS && status == SP_OK; k++)
        status = sp_h5_put(h, &sp_modes_arrays[k].name, SP_H5_F64, &modes,
                           *sp_modes_array_at(&sp_modes_arrays[k], &all), err);
    if (status == SP_OK)
        status = put_columns(h, net, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &sp_modes_name_mass, SP_H5_F64, &columns, net->mass, err);
    if (status == SP_OK)
        status = put_vector_errors(h, m, net, err);
    if (status == SP_OK)
        status = sp_h5_put_rows(h, &sp_modes_name_vector, SP_H5_F64, &vectors, m->vectors, err);
    return status == SP_OK ? sp_h5_end_draft(h, err) : status;
}

sp_status sp_modes_save(const sp_modes *m, const sp_packing *p, const sp_network *net, const sp_modes_made *made,
                        const char *path, sp_error *err) {
    sp_draft draft;
    sp_h5 h;
    sp_status status = check(m, p, net, err);
    if (status == SP_OK && made->network.tangential != SP_SPRINGS_CONSTANT)
        status = sp_fail_key(err, SP_EREFUSED, "network.tangential",
                             ": must be \"constant\" for a file of modes, which cannot say otherwise");
    if (status == SP_OK)
        status = sp_draft_begin(path, &draft, err);
    if (status != SP_OK)
        return status;
    status = sp_h5_create_draft(&h, draft.fd, path, err);
    if (status == SP_OK)
        status = put_all(&h, m, p, net, made, err);
    sp_h5_close(&h);
    if (status == SP_OK)
        return sp_draft_commit(&draft, err);
    sp_draft_drop(&draft);
    return status;
}
