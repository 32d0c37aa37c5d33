/* Reads and writes a packing as HDF5: groups of H5MD for grains and box, connectivity of H5MD for contacts, and
 * /sonopack for everything else. docs/file-format.md describes the layout. */
#include "store/packing_h5.h"

#include "base/base.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/study/store.h>
#include <sonopack/version.h>
#include <string.h>

#define EDGES_PATH "/particles/grains/box/edges"

static const sp_h5_name name_cell = {
    "/sonopack/cell", "1",
    "walls at the bottom and the top: 'piston', none: 'periodic', on all sides: 'box', two circles: 'ring'"};
static const sp_h5_name name_gravity = {"/sonopack/gravity", "E* / (rho d)", "acceleration against the up axis"};
static const sp_h5_name name_edges = {EDGES_PATH, "d", "lengths of the box; the last is the height between the walls"};
static const sp_h5_name name_periods = {EDGES_PATH, "d", "periods; of a tilted cell its three lattice vectors as rows"};
static const sp_h5_name name_distances = {EDGES_PATH, "d", "distances between opposite walls"};
static const sp_h5_name name_ring = {EDGES_PATH, "d", "diameter of the outer wall, and distance between the walls"};
static const sp_h5_name name_position = {"/particles/grains/position/value", "d", "centres of the grains"};
static const sp_h5_name name_step = {"/particles/grains/position/step", "1", "steps of the compression; 0 if unknown"};
static const sp_h5_name name_time = {"/particles/grains/position/time", "d / sqrt(E* / rho)",
                                     "time; 0, for a packing is at rest"};
static const sp_h5_name name_radius = {"/particles/grains/radius", "d", "radii of the grains"};
static const sp_h5_name name_mass = {"/particles/grains/mass", "rho d^3", "masses"};
static const sp_h5_name name_inertia = {"/particles/grains/inertia", "rho d^5",
                                        "moments of inertia; absent for spheres of unit density"};
static const sp_h5_name name_species = {"/particles/grains/species", "1", "materials of the grains, from 0"};
static const sp_h5_name name_pairs = {"/connectivity/contacts", "1",
                                      "grains i < j of each contact between grains, from 0"};
static const sp_h5_name name_walls = {"/sonopack/walls/contacts", "1",
                                      "grain and wall of each contact with a wall, -1: bottom, -2: top"};
static const sp_h5_name name_sides = {"/sonopack/walls/contacts", "1",
                                      "grain and wall of each contact with a wall, -1: bottom, -2: top, -3: left, "
                                      "-4: right, -5: front, -6: back"};
static const sp_h5_name name_normal = {"/sonopack/contacts/normal", "1", "unit normals, from i to j"};
static const sp_h5_name name_overlap = {"/sonopack/contacts/overlap", "d",
                                        "R_i + R_j - r_ij, or R_i - distance to wall"};
static const sp_h5_name name_fn = {"/sonopack/contacts/normal_force", "E* d^2", "normal elastic force, >= 0"};
static const sp_h5_name name_ft = {"/sonopack/contacts/tangential_force", "E* d^2", "tangential elastic force on i"};
static const sp_h5_name name_kn = {"/sonopack/contacts/normal_stiffness", "E* d",
                                   "stiffnesses that are given; 0: Hertz's at the overlap"};
static const sp_h5_name name_kt = {"/sonopack/contacts/tangential_stiffness", "E* d",
                                   "stiffnesses that are given; 0 where the normal stiffness is 0: Mindlin's"};
static const sp_h5_name name_mu = {"/sonopack/contacts/friction", "1",
                                   "Coulomb's coefficient of the contact; 0: that of the packing"};
static const sp_h5_name name_rattler = {"/sonopack/rattler", "1",
                                        "1: fewer than the force-carrying contacts (F_n > 1e-4 p) that hold a grain"};
static const sp_h5_name name_dim = {"/sonopack/dimension", "1", "dimension: 1, 2 or 3; the last axis is up"};
static const sp_h5_name name_wall = {"/sonopack/wall", "1",
                                     "walls are 'rigid' planes, 'elastic' planes of the grains' material, or springs "
                                     "like those to a fixed identical 'grain'"};
static const sp_h5_name name_pressure = {"/sonopack/pressure", "E*", "force on a wall over its area"};
static const sp_h5_name name_mean = {"/sonopack/pressure", "E*", "mean of the normal stresses in the grains"};
static const sp_h5_name name_scene = {"/sonopack/scene", "1", "the scene that made the packing, with every value"};
static const sp_h5_name name_frame = {"/sonopack/series/frame", "1",
                                      "number or time step in the series of packings that this one is of"};
static const sp_h5_name name_strain = {"/sonopack/series/strain", "1",
                                       "of the cell since the first of the series: xx, yy, zz, yz, xz, xy, compression "
                                       "positive; nan: none"};

static const sp_h5_field field[] = {
    {{"/sonopack/friction", "1", "Coulomb's coefficient mu"}, SP_H5_F64, offsetof(sp_packing, friction)},
    {{"/sonopack/poisson", "1", "Poisson ratio of the grain material"}, SP_H5_F64, offsetof(sp_packing, poisson)},
    {{"/sonopack/seed", "1", "seed of the random streams; 0 if unknown"}, SP_H5_U64, offsetof(sp_packing, seed)},
    {{"/sonopack/steps", "1", "time steps of the compression; 0 if unknown"}, SP_H5_I64, offsetof(sp_packing, steps)},
    {{"/sonopack/residual", "E* / (rho d)", "largest elastic acceleration at the end (angular: times R)"},
     SP_H5_F64,
     offsetof(sp_packing, residual)},
};
enum { FIELDS = sizeof field / sizeof *field };

static const sp_h5_field material_field[] = {
    {{"/sonopack/material/young", "Pa", "Young's modulus E; E* = E/(1 - poisson^2)"},
     SP_H5_F64,
     offsetof(sp_material, young)},
    {{"/sonopack/material/poisson", "1", "Poisson's ratio"}, SP_H5_F64, offsetof(sp_material, poisson)},
    {{"/sonopack/material/density", "kg/m^3", "density rho of the grains"}, SP_H5_F64, offsetof(sp_material, density)},
    {{"/sonopack/material/diameter", "m", "mean grain diameter d"}, SP_H5_F64, offsetof(sp_material, diameter)},
};
enum { MATERIAL_FIELDS = sizeof material_field / sizeof *material_field };

/* The numbers and vectors of a contact. */
static const struct contact_part {
    const sp_h5_name *name;
    size_t offset;
    bool vector, optional;
} part[] = {
    {&name_normal, offsetof(sp_contact, n), true, false}, {&name_overlap, offsetof(sp_contact, overlap), false, false},
    {&name_fn, offsetof(sp_contact, fn), false, false},   {&name_ft, offsetof(sp_contact, ft), true, false},
    {&name_kn, offsetof(sp_contact, kn), false, true},    {&name_kt, offsetof(sp_contact, kt), false, true},
    {&name_mu, offsetof(sp_contact, mu), false, true}};
enum { PARTS = sizeof part / sizeof *part };

static const sp_h5_shape single = {0}, strains = {1, {SP_SERIES_STRAINS}};

/* Files of packings under a piston without gravity have no entries for the kind of the cell and gravity. */
static bool needs_cell(const sp_packing *p) { return p->cell != SP_CELL_PISTON || p->gravity != 0; }

/* H5MD's word for each axis. */
static void boundary_of(const sp_packing *p, const char *boundary[3]) {
    for (int k = 0; k < p->dim; k++)
        boundary[k] = sp_packing_periodic(p, k) ? "periodic" : "none";
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

/* The lowest format whose readers understand this packing. */
static int32_t format_of(const sp_packing *p) {
    if (needs_cell(p))
        return SP_H5_FORMAT_CELL;
    return sp_packing_hertzian(p) ? SP_H5_FORMAT : SP_H5_FORMAT_OWN_LAW;
}

static void put_groups(sp_h5 *h, const sp_packing *p) {
    static const char *const group[] = {"/h5md",
                                        "/h5md/author",
                                        "/h5md/creator",
                                        "/particles",
                                        "/particles/grains",
                                        "/particles/grains/box",
                                        "/connectivity",
                                        "/particles/grains/position",
                                        "/sonopack",
                                        "/sonopack/contacts"};
    const char *const version = SONOPACK_VERSION, *const us = "sonopack", *const unknown = "unknown";
    const char *boundary[3];
    const int32_t h5md[2] = {1, 1}, dimension = p->dim, format = format_of(p);
    boundary_of(p, boundary);
    for (size_t k = 0; k < sizeof group / sizeof *group; k++)
        sp_h5_group(h, group[k]);
    sp_h5_attribute_ints(h, "/h5md", "version", 2, h5md);
    sp_h5_attribute_texts(h, "/h5md/author", "name", 0, &unknown);
    sp_h5_attribute_texts(h, "/h5md/creator", "name", 0, &us);
    sp_h5_attribute_texts(h, "/h5md/creator", "version", 0, &version);
    sp_h5_attribute_ints(h, "/particles/grains/box", "dimension", 0, &dimension);
    sp_h5_attribute_texts(h, "/particles/grains/box", "boundary", p->dim, boundary);
    sp_h5_attribute_ints(h, "/sonopack", "format", 0, &format);
    sp_h5_attribute_texts(h, "/sonopack", "version", 0, &version);
}

/* The edges, or the lattice vectors as the rows of a matrix, as H5MD has them; the kind of the cell, and gravity. */
static void put_cell(sp_h5 *h, const sp_packing *p) {
    const sp_h5_shape edges = {1, {p->dim}}, lattice = {2, {p->dim, p->dim}};
    const sp_h5_name *const name[] = {&name_edges, &name_periods, &name_distances, &name_ring};
    const double row[3][3] = {{p->box[0], 0, 0}, {p->tilt[0], p->box[1], 0}, {p->tilt[1], p->tilt[2], p->box[2]}};
    double matrix[9];
    for (int a = 0; a < p->dim; a++)
        memcpy(matrix + a * p->dim, row[a], (size_t)p->dim * sizeof *matrix);
    if (p->tilt[0] != 0 || p->tilt[1] != 0 || p->tilt[2] != 0)
        sp_h5_put(h, &name_periods, SP_H5_F64, &lattice, matrix);
    else
        sp_h5_put(h, name[p->cell], SP_H5_F64, &edges, p->box);
    if (!needs_cell(p))
        return;
    sp_h5_put_text(h, &name_cell, sp_cell_names[p->cell]);
    sp_h5_put(h, &name_gravity, SP_H5_F64, &single, &p->gravity);
}

static void put_grains(sp_h5 *h, const sp_packing *p) {
    const sp_h5_shape position = {3, {1, p->n, p->dim}}, one = {1, {1}}, grains = {1, {p->n}};
    const double time = 0;
    const size_t dim = (size_t)p->dim;
    double *buffer = sp_h5_alloc(h, (int64_t)p->n * p->dim, sizeof *buffer);
    uint8_t *rattler = sp_h5_alloc(h, p->n, 1);
    for (size_t i = 0; buffer && i < (size_t)p->n; i++)
        memcpy(buffer + dim * i, p->x + 3 * i, dim * sizeof *buffer);
    sp_h5_put(h, &name_position, SP_H5_F64, &position, buffer);
    sp_h5_put(h, &name_step, SP_H5_I64, &one, &p->steps);
    sp_h5_put(h, &name_time, SP_H5_F64, &one, &time);
    sp_h5_put(h, &name_radius, SP_H5_F64, &grains, p->r);
    for (int32_t i = 0; buffer && i < p->n; i++)
        buffer[i] = p->mass ? p->mass[i] : grain_mass(p->r[i]);
    sp_h5_put(h, &name_mass, SP_H5_F64, &grains, buffer);
    if (p->mass)
        sp_h5_put(h, &name_inertia, SP_H5_F64, &grains, p->inertia);
    if (p->species)
        sp_h5_put(h, &name_species, SP_H5_I32, &grains, p->species);
    put_cell(h, p);
    if (h->status == SP_OK)
        h->status = sp_packing_rattlers(p, 1e-4, rattler, NULL, NULL, h->err);
    sp_h5_put(h, &name_rattler, SP_H5_U8, &grains, rattler);
    sp_free(buffer);
    sp_free(rattler);
}

/* Who touches whom. H5MD's connectivity is between particles, and a wall is none. */
static void put_partners(sp_h5 *h, const sp_packing *p) {
    int32_t *ij = sp_h5_alloc(h, 2 * (int64_t)p->n_contacts, sizeof *ij), count = 0;
    for (size_t c = 0; ij && c < (size_t)p->n_contacts; c++) {
        ij[2 * c] = p->contacts[c].i;
        ij[2 * c + 1] = p->contacts[c].j;
        count += p->contacts[c].j >= 0; /* pairs come first */
    }
    const sp_h5_shape pairs = {2, {count, 2}}, walls = {2, {p->n_contacts - count, 2}};
    sp_h5_put(h, &name_pairs, SP_H5_I32, &pairs, ij);
    sp_h5_attribute_reference(h, name_pairs.path, "particles_group", "/particles/grains");
    if (ij && walls.dim[0] > 0) {
        sp_h5_group(h, "/sonopack/walls");
        sp_h5_put(h, p->cell == SP_CELL_BOX ? &name_sides : &name_walls, SP_H5_I32, &walls, ij + 2 * (size_t)count);
    }
    sp_free(ij);
}

static sp_h5_shape shape_of(const struct contact_part *of, int64_t contacts, int dim) {
    return (sp_h5_shape){of->vector ? 2 : 1, {contacts, dim}};
}

static void put_contacts(sp_h5 *h, const sp_packing *p) {
    const bool stiffnesses = sp_packing_has_stiffnesses(p);
    bool frictions = false;
    for (int32_t c = 0; c < p->n_contacts; c++)
        frictions = frictions || p->contacts[c].mu > 0;
    put_partners(h, p);
    double *buffer = sp_h5_alloc(h, (int64_t)p->dim * p->n_contacts, sizeof *buffer);
    for (const struct contact_part *of = part; buffer && of < part + PARTS; of++) {
        const size_t width = of->vector ? (size_t)p->dim : 1;
        const sp_h5_shape shape = shape_of(of, p->n_contacts, p->dim);
        if (of->optional && !(of->name == &name_mu ? frictions : stiffnesses))
            continue;
        for (size_t c = 0; c < (size_t)p->n_contacts; c++)
            memcpy(buffer + c * width, (const char *)&p->contacts[c] + of->offset, width * sizeof *buffer);
        sp_h5_put(h, of->name, SP_H5_F64, &shape, buffer);
    }
    sp_free(buffer);
}

void sp_packing_put(sp_h5 *h, const sp_packing *p) {
    const int32_t dim = p->dim;
    put_groups(h, p);
    sp_h5_put(h, &name_dim, SP_H5_I32, &single, &dim);
    sp_h5_put(h, p->cell == SP_CELL_PISTON ? &name_pressure : &name_mean, SP_H5_F64, &single, &p->pressure);
    sp_h5_put_fields(h, FIELDS, field, p);
    sp_h5_put_text(h, &name_wall, sp_wall_names[p->wall]);
    if (p->material.young > 0) {
        sp_h5_group(h, "/sonopack/material");
        sp_h5_put_fields(h, MATERIAL_FIELDS, material_field, &p->material);
    }
    if (p->scene)
        sp_h5_put_text(h, &name_scene, p->scene);
    if (!isnan(p->frame)) {
        sp_h5_group(h, "/sonopack/series");
        sp_h5_put(h, &name_frame, SP_H5_F64, &single, &p->frame);
        sp_h5_put(h, &name_strain, SP_H5_F64, &strains, p->strain);
    }
    put_grains(h, p);
    put_contacts(h, p);
}

sp_status sp_packing_save(const sp_packing *p, const char *path, sp_error *err) {
    sp_h5 h;
    sp_status status = sp_packing_check(p, err);
    if (status != SP_OK)
        return status;
    if (sp_h5_create(&h, path, err) == SP_OK)
        sp_packing_put(&h, p);
    return sp_h5_close(&h);
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

sp_status sp_packing_get_format(sp_h5 *h, int64_t *format) {
    if (!sp_h5_has(h, "/sonopack"))
        return sp_h5_fail(h, SP_EFORMAT, "no group /sonopack: %s",
                          sp_h5_has(h, "/modes") ? "a file of modes, must be the packing that they are of"
                                                 : "not a packing of sonopack");
    if (sp_h5_attribute_int(h, "/sonopack", "format", format) != SP_OK)
        return h->status;
    const bool newer = *format > SP_H5_FORMAT_CELL;
    if (newer || *format < SP_H5_FORMAT)
        sp_h5_fail(h, newer ? SP_EIO : SP_EFORMAT, "format %lld of /sonopack; this version reads formats %d to %d%s",
                   (long long)*format, SP_H5_FORMAT, SP_H5_FORMAT_CELL, newer ? ": a newer version made the file" : "");
    return h->status;
}

/* H5MD has the lattice vectors as the rows of a matrix. */
static void get_lattice(sp_h5 *h, sp_packing *p) {
    const sp_h5_shape shape = {2, {p->dim, p->dim}};
    double matrix[9], row[3][3] = {{0}};
    if (sp_h5_get(h, EDGES_PATH, SP_H5_F64, &shape, matrix) != SP_OK)
        return;
    for (int a = 0; a < p->dim; a++) {
        memcpy(row[a], matrix + a * p->dim, (size_t)p->dim * sizeof *matrix);
        p->box[a] = row[a][a];
    }
    if (!(row[0][1] == 0 && row[0][2] == 0 && row[1][2] == 0))
        sp_h5_fail(h, SP_EFORMAT, "%s: the first lattice vector must lie along x, the second in the plane of x and y",
                   EDGES_PATH);
    p->tilt[0] = row[1][0];
    p->tilt[1] = row[2][0];
    p->tilt[2] = row[2][1];
}

/* Whether the box is given by lattice vectors, and not by edges. */
static bool has_lattice(sp_h5 *h) {
    hid_t set = h->status == SP_OK ? H5Dopen2(h->file, EDGES_PATH, H5P_DEFAULT) : H5I_INVALID_HID;
    hid_t space = set >= 0 ? H5Dget_space(set) : H5I_INVALID_HID;
    const bool two = space >= 0 && H5Sget_simple_extent_ndims(space) == 2;
    H5Sclose(space);
    H5Dclose(set);
    return two;
}

/* p: allocated, with a piston. */
static void get_cell(sp_h5 *h, int64_t format, sp_packing *p) {
    const sp_h5_shape edges = {1, {p->dim}};
    const char *boundary[3];
    int kind = SP_CELL_PISTON;
    if (format >= SP_H5_FORMAT_CELL && sp_h5_get_word(h, name_cell.path, sp_cell_names, &kind) == SP_OK)
        sp_h5_get(h, name_gravity.path, SP_H5_F64, &single, &p->gravity);
    p->cell = (sp_cell)kind;
    boundary_of(p, boundary);
    sp_h5_check_texts(h, "/particles/grains/box", "boundary", p->dim, boundary);
    if (p->cell == SP_CELL_PERIODIC && sp_h5_has(h, EDGES_PATH) && has_lattice(h))
        get_lattice(h, p);
    else
        sp_h5_get(h, EDGES_PATH, SP_H5_F64, &edges, p->box);
}

static void get_wall_and_scene(sp_h5 *h, sp_packing *p) {
    int wall = 0;
    if (sp_h5_get_word(h, name_wall.path, sp_wall_names, &wall) == SP_OK)
        p->wall = (sp_wall)wall;
    if (sp_h5_has(h, material_field[0].name.path))
        sp_h5_get_fields(h, MATERIAL_FIELDS, material_field, &p->material);
    if (sp_h5_has(h, name_scene.path))
        sp_h5_get_text(h, name_scene.path, &p->scene);
}

static void get_grains(sp_h5 *h, sp_packing *p) {
    const sp_h5_shape position = {3, {1, p->n, p->dim}}, grains = {1, {p->n}};
    const size_t dim = (size_t)p->dim;
    double *buffer = sp_h5_alloc(h, (int64_t)p->n * p->dim, sizeof *buffer);
    sp_h5_get(h, name_position.path, SP_H5_F64, &position, buffer);
    for (size_t i = 0; buffer && i < (size_t)p->n; i++)
        memcpy(p->x + 3 * i, buffer + dim * i, dim * sizeof *buffer);
    sp_free(buffer);
    sp_h5_get(h, name_radius.path, SP_H5_F64, &grains, p->r);
    if (h->status == SP_OK && sp_h5_has(h, name_species.path)) {
        h->status = sp_packing_alloc_species(p, h->err);
        sp_h5_get(h, name_species.path, SP_H5_I32, &grains, p->species);
    }
    if (h->status != SP_OK || !sp_h5_has(h, name_inertia.path))
        return;
    h->status = sp_packing_alloc_masses(p, h->err);
    sp_h5_get(h, name_mass.path, SP_H5_F64, &grains, p->mass);
    sp_h5_get(h, name_inertia.path, SP_H5_F64, &grains, p->inertia);
}

/* The number of rows of an array of two columns; 0 if it fails. */
static int64_t count_rows(sp_h5 *h, const char *path) {
    sp_h5_shape shape = {0};
    if (sp_h5_find(h, path, SP_H5_I32, 2, &shape) != SP_OK)
        return 0;
    const sp_h5_shape expected = {2, {shape.dim[0], 2}};
    return sp_h5_get(h, path, SP_H5_I32, &expected, NULL) == SP_OK ? shape.dim[0] : 0;
}

static void get_partners(sp_h5 *h, int64_t count, sp_packing *p) {
    const sp_h5_shape pairs = {2, {count, 2}}, walls = {2, {p->n_contacts - count, 2}};
    int32_t *ij = sp_h5_alloc(h, 2 * (int64_t)p->n_contacts, sizeof *ij);
    sp_h5_get(h, name_pairs.path, SP_H5_I32, &pairs, ij);
    if (ij && walls.dim[0] > 0)
        sp_h5_get(h, name_walls.path, SP_H5_I32, &walls, ij + 2 * count);
    for (size_t c = 0; ij && c < (size_t)p->n_contacts; c++) {
        p->contacts[c].i = ij[2 * c];
        p->contacts[c].j = ij[2 * c + 1];
    }
    sp_free(ij);
}

static void get_contacts(sp_h5 *h, int64_t pairs, sp_packing *p) {
    get_partners(h, pairs, p);
    double *buffer = sp_h5_alloc(h, (int64_t)p->dim * p->n_contacts, sizeof *buffer);
    for (const struct contact_part *of = part; buffer && of < part + PARTS; of++) {
        const size_t width = of->vector ? (size_t)p->dim : 1;
        const sp_h5_shape shape = shape_of(of, p->n_contacts, p->dim);
        if (of->optional && !sp_h5_has(h, of->name->path))
            continue;
        if (sp_h5_get(h, of->name->path, SP_H5_F64, &shape, buffer) != SP_OK)
            break;
        for (size_t c = 0; c < (size_t)p->n_contacts; c++)
            memcpy((char *)&p->contacts[c] + of->offset, buffer + c * width, width * sizeof *buffer);
    }
    sp_free(buffer);
}

/* Checks the extents of all arrays, before memory is taken for any of them. No two grains touch twice, and there are
 * six walls at most. */
static sp_status check_sizes(sp_h5 *h, int32_t dim, int64_t n, int64_t contacts) {
    const sp_h5_shape position = {3, {1, n, dim}};
    if (h->status != SP_OK)
        return h->status;
    /* 32-bit products of counts and axes are safe below */
    if (n > INT32_MAX / 4 || contacts > INT32_MAX / 8 || contacts > n * (n - 1) / 2 + 6 * n)
        return sp_h5_fail(h, SP_EFORMAT, "%lld grains, %lld contacts; at most %d, and each pair once", (long long)n,
                          (long long)contacts, INT32_MAX / 8);
    sp_h5_get(h, name_position.path, SP_H5_F64, &position, NULL);
    for (const struct contact_part *of = part; of < part + PARTS; of++) {
        const sp_h5_shape shape = shape_of(of, contacts, dim);
        if (!of->optional || sp_h5_has(h, of->name->path))
            sp_h5_get(h, of->name->path, SP_H5_F64, &shape, NULL);
    }
    return h->status;
}

/* Makes the packing, empty but for its sizes. */
static void get_sizes(sp_h5 *h, int64_t *format, int64_t *pairs, sp_packing *p) {
    sp_h5_shape grains = {0};
    int32_t dim = 0;
    sp_packing_get_format(h, format);
    if (sp_h5_get(h, name_dim.path, SP_H5_I32, &single, &dim) == SP_OK && (dim < 1 || dim > 3))
        sp_h5_fail(h, SP_EFORMAT, "%s is %d; must be 1, 2 or 3", name_dim.path, dim);
    sp_h5_find(h, name_radius.path, SP_H5_F64, 1, &grains);
    *pairs = count_rows(h, name_pairs.path);
    const int64_t walls = sp_h5_has(h, name_walls.path) ? count_rows(h, name_walls.path) : 0;
    if (check_sizes(h, dim, grains.dim[0], *pairs + walls) == SP_OK)
        h->status = sp_packing_alloc(p, dim, (int32_t)grains.dim[0], (int32_t)(*pairs + walls), h->err);
}

sp_status sp_packing_get(sp_h5 *h, sp_packing *out) {
    sp_packing p = sp_packing_none();
    int64_t pairs = 0, format = 0;
    get_sizes(h, &format, &pairs, &p);
    if (h->status == SP_OK) {
        get_cell(h, format, &p);
        sp_h5_get(h, name_pressure.path, SP_H5_F64, &single, &p.pressure);
        sp_h5_get_fields(h, FIELDS, field, &p);
        get_wall_and_scene(h, &p);
        if (sp_h5_has(h, name_frame.path)) {
            sp_h5_get(h, name_frame.path, SP_H5_F64, &single, &p.frame);
            sp_h5_get(h, name_strain.path, SP_H5_F64, &strains, p.strain);
        }
        get_grains(h, &p);
        get_contacts(h, pairs, &p);
    }
    if (h->status == SP_OK) {
        h->status = sp_packing_check(&p, h->err);
        if (h->status != SP_OK)
            sp_fail_prefix(h->err, "%s", h->path);
    }
    if (h->status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return h->status;
}
