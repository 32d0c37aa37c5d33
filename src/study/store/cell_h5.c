/* The cell of a packing in HDF5: its kind, edges and tilt, and gravity. Files of packings under a piston without
 * gravity have no entries of their own for these. */
#include "base/base.h"
#include "packing/geometry.h"
#include "store/packing_h5.h"

#include <string.h>

#define EDGES_PATH "/particles/grains/box/edges"

static const sp_h5_name name_cell = {
    "/sonopack/cell", "1", "walls at the bottom and the top: 'piston', none: 'periodic', on all sides: 'box'"};
static const sp_h5_name name_gravity = {"/sonopack/gravity", "E* / (rho d)", "acceleration against the up axis"};
static const sp_h5_name name_edges = {EDGES_PATH, "d", "lengths of the box; the last is the height between the walls"};
static const sp_h5_name name_periods = {EDGES_PATH, "d", "periods; of a tilted cell its three lattice vectors as rows"};
static const sp_h5_name name_distances = {EDGES_PATH, "d", "distances between opposite walls"};

bool sp_packing_needs_cell(const sp_packing *p) { return p->cell != SP_CELL_PISTON || p->gravity != 0; }

void sp_cell_boundary(const sp_packing *p, const char *boundary[3]) {
    for (int k = 0; k < p->dim; k++)
        boundary[k] = sp_packing_periodic(p, k) ? "periodic" : "none";
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

/* H5MD has the lattice vectors as the rows of a matrix. */
static sp_status put_lattice(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const sp_h5_shape shape = {2, {p->dim, p->dim}};
    const double row[3][3] = {{p->box[0], 0, 0}, {p->tilt[0], p->box[1], 0}, {p->tilt[1], p->tilt[2], p->box[2]}};
    double matrix[9];
    for (int a = 0; a < p->dim; a++)
        memcpy(matrix + a * p->dim, row[a], (size_t)p->dim * sizeof *matrix);
    return sp_h5_put(h, &name_periods, SP_H5_F64, &shape, matrix, err);
}

static sp_status put_edges(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const sp_h5_shape edges = {1, {p->dim}};
    const sp_h5_name *const name[] = {&name_edges, &name_periods, &name_distances};
    if (p->tilt[0] != 0 || p->tilt[1] != 0 || p->tilt[2] != 0)
        return put_lattice(h, p, err);
    return sp_h5_put(h, name[p->cell], SP_H5_F64, &edges, p->box, err);
}

sp_status sp_cell_put(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const sp_h5_shape single = {0};
    sp_status status = put_edges(h, p, err);
    if (status == SP_OK && sp_packing_needs_cell(p))
        status = sp_h5_put_text(h, &name_cell, sp_cell_names[p->cell], err);
    if (status == SP_OK && sp_packing_needs_cell(p))
        status = sp_h5_put(h, &name_gravity, SP_H5_F64, &single, &p->gravity, err);
    return status;
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

static sp_status get_kind(sp_h5 *h, sp_packing *p, sp_error *err) {
    const sp_h5_shape single = {0};
    char *word = NULL;
    int kind = 0;
    sp_status status = sp_h5_get_text(h, name_cell.path, &word, err);
    while (status == SP_OK && sp_cell_names[kind] && strcmp(sp_cell_names[kind], word) != 0)
        kind++;
    if (status == SP_OK && !sp_cell_names[kind])
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s is '%.60s'; must be piston, periodic or box", name_cell.path, word);
    sp_free(word);
    if (status == SP_OK)
        status = sp_h5_get(h, name_gravity.path, SP_H5_F64, &single, &p->gravity, err);
    if (status == SP_OK)
        p->cell = (sp_cell)kind;
    return status;
}

static sp_status get_lattice(sp_h5 *h, sp_packing *p, sp_error *err) {
    const sp_h5_shape shape = {2, {p->dim, p->dim}};
    double matrix[9], row[3][3] = {{0}};
    sp_status status = sp_h5_get(h, EDGES_PATH, SP_H5_F64, &shape, matrix, err);
    for (int a = 0; status == SP_OK && a < p->dim; a++) {
        memcpy(row[a], matrix + a * p->dim, (size_t)p->dim * sizeof *matrix);
        p->box[a] = row[a][a];
    }
    if (status == SP_OK && !(row[0][1] == 0 && row[0][2] == 0 && row[1][2] == 0))
        status =
            sp_h5_fail(h, err, SP_EFORMAT,
                       "%s: the first lattice vector must lie along x, the second in the plane of x and y", EDGES_PATH);
    p->tilt[0] = row[1][0];
    p->tilt[1] = row[2][0];
    p->tilt[2] = row[2][1];
    return status;
}

sp_status sp_cell_get(sp_h5 *h, int64_t format, sp_packing *p, sp_error *err) {
    const sp_h5_shape edges = {1, {p->dim}};
    sp_h5_shape found;
    const char *boundary[3];
    sp_status status = format >= SP_H5_FORMAT_CELL ? get_kind(h, p, err) : SP_OK;
    sp_cell_boundary(p, boundary);
    if (status == SP_OK)
        status = sp_h5_check_texts(h, "/particles/grains/box", "boundary", p->dim, boundary, err);
    if (status != SP_OK)
        return status;
    if (p->cell == SP_CELL_PERIODIC && sp_h5_find(h, EDGES_PATH, SP_H5_F64, 2, &found, NULL) == SP_OK)
        return get_lattice(h, p, err);
    return sp_h5_get(h, EDGES_PATH, SP_H5_F64, &edges, p->box, err);
}
