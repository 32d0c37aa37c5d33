/* Writes the eigenvectors of sonopack modes --vectors: all of them, or one as displacements. */
#include "base/base.h"
#include "cli/modes.h"
#include "cli/motion.h"
#include "cli/output.h"

#include <sonopack/study/modes_file.h>

sp_status modes_vectors_check(const char *path, int64_t mode, sp_error *err) {
    if (!path)
        return mode < 0 ? SP_OK : sp_fail(err, SP_EINVAL, "--mode %lld: needs --vectors FILE", (long long)mode);
    const bool table = cli_has_ending(path, ".tsv") || cli_has_ending(path, ".csv") || cli_has_ending(path, ".json");
    if (!cli_is_hdf5(path) && !table)
        return sp_fail(err, SP_EINVAL,
                       "--vectors %s: the ending must be .h5, or .tsv, .csv or .json for one mode by --mode N", path);
    if (table && mode < 0)
        return sp_fail(err, SP_EINVAL, "--vectors %s: a table has one mode, which --mode N must select", path);
    if (!table && mode >= 0)
        return sp_fail(err, SP_EINVAL, "--mode %lld: --vectors %s takes all modes", (long long)mode, path);
    return SP_OK;
}

static sp_status write_one(const cli_common *common, const cli_file *file, const sp_modes *m, int64_t mode,
                           const char *path, sp_error *err) {
    const sp_network *net = &file->network;
    const int64_t row = mode - m->first;
    if (row < m->n_rattler || row >= m->n)
        return sp_fail(err, SP_EINVAL, "--mode %lld: must be in %lld .. %lld", (long long)mode,
                       (long long)(m->first + m->n_rattler), (long long)(m->first + m->n - 1));
    double *u = sp_alloc((size_t)m->dofs, sizeof *u);
    if (!u)
        return sp_fail_memory(err, (size_t)m->dofs * sizeof *u);
    cli_motion_of_mode(net, m->vectors + (row - m->n_rattler) * m->dofs, u);
    const cli_motion motion = {.packing = &file->packing,
                               .net = net,
                               .made = file->scene->network,
                               .number = mode,
                               .omega = m->omega[row],
                               .omega_error = m->error[row],
                               .error = sp_modes_vector_error(m, net, row),
                               .u = u};
    const sp_status status = cli_motion_write(common, &motion, path, err);
    sp_free(u);
    return status;
}

sp_status modes_vectors(const cli_common *common, const cli_file *file, const sp_modes *m, sp_source source,
                        int64_t mode, const char *path, sp_error *err) {
    const sp_modes_made made = {.network = file->scene->network, .source = source};
    if (!cli_is_hdf5(path))
        return write_one(common, file, m, mode, path, err);
    return sp_modes_save(m, &file->packing, &file->network, &made, path, err);
}
