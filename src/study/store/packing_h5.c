/* Reads and writes a packing as HDF5: groups of H5MD for grains and box, connectivity of H5MD for contacts, and
 * /sonopack for everything else. docs/file-format.md describes the layout. */
#include "store/packing_h5.h"

#include "base/base.h"
#include "base/file.h"
#include "packing/contact.h"
#include "packing/geometry.h"

#include <sonopack/study/store.h>
#include <sonopack/version.h>
#include <string.h>

static const sp_h5_name name_position = {"/particles/grains/position/value", "d", "centres of the grains"};
static const sp_h5_name name_step = {"/particles/grains/position/step", "1", "steps of the compression; 0 if unknown"};
static const sp_h5_name name_time = {"/particles/grains/position/time", "d / sqrt(E* / rho)",
                                     "time; 0, for a packing is at rest"};
static const sp_h5_name name_radius = {"/particles/grains/radius", "d", "radii of the grains"};
static const sp_h5_name name_mass = {"/particles/grains/mass", "rho d^3", "masses"};
static const sp_h5_name name_inertia = {"/particles/grains/inertia", "rho d^5",
                                        "moments of inertia; absent for spheres of unit density"};
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
static const sp_h5_name name_rattler = {"/sonopack/rattler", "1",
                                        "1: fewer than the force-carrying contacts (F_n > 1e-4 p) that hold a grain"};
static const sp_h5_name name_dim = {"/sonopack/dimension", "1", "dimension: 1, 2 or 3; the last axis is up"};
static const sp_h5_name name_wall = {"/sonopack/wall", "1",
                                     "walls are 'rigid' planes, 'elastic' planes of the grains' material, or springs "
                                     "like those to a fixed identical 'grain'"};
static const sp_h5_name name_pressure = {"/sonopack/pressure", "E*", "force on a wall over its area"};
static const sp_h5_name name_mean = {"/sonopack/pressure", "E*", "mean of the normal stresses in the grains"};
static const sp_h5_name name_scene = {"/sonopack/scene", "1", "the scene that made the packing, with every value"};

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

sp_status sp_h5_put_fields(sp_h5 *h, int count, const sp_h5_field *f, const void *from, sp_error *err) {
    const sp_h5_shape single = {0};
    for (int k = 0; k < count; k++) {
        sp_status status = sp_h5_put(h, &f[k].name, f[k].type, &single, (const char *)from + f[k].offset, err);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

sp_status sp_h5_get_fields(sp_h5 *h, int count, const sp_h5_field *f, void *to, sp_error *err) {
    const sp_h5_shape single = {0};
    for (int k = 0; k < count; k++) {
        sp_status status = sp_h5_get(h, f[k].name.path, f[k].type, &single, (char *)to + f[k].offset, err);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

/* The lowest format whose readers understand this packing. */
static int32_t format_of(const sp_packing *p) {
    if (sp_packing_needs_cell(p))
        return SP_H5_FORMAT_CELL;
    return sp_packing_hertzian(p) ? SP_H5_FORMAT : SP_H5_FORMAT_OWN_LAW;
}

static sp_status put_groups(sp_h5 *h, const sp_packing *p, sp_error *err) {
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
    sp_cell_boundary(p, boundary);
    const int32_t h5md[2] = {1, 1}, dimension = p->dim, format = format_of(p);
    /* in this order: texts, or else integers */
    const struct {
        const char *object, *name;
        int count;
        const char *const *text;
        const int32_t *integer;
    } attribute[] = {{"/h5md", "version", 2, NULL, h5md},
                     {"/h5md/author", "name", 0, &unknown, NULL},
                     {"/h5md/creator", "name", 0, &us, NULL},
                     {"/h5md/creator", "version", 0, &version, NULL},
                     {"/particles/grains/box", "dimension", 0, NULL, &dimension},
                     {"/particles/grains/box", "boundary", p->dim, boundary, NULL},
                     {"/sonopack", "format", 0, NULL, &format},
                     {"/sonopack", "version", 0, &version, NULL}};
    sp_status status = SP_OK;
    for (size_t k = 0; status == SP_OK && k < sizeof group / sizeof *group; k++)
        status = sp_h5_group(h, group[k], err);
    for (size_t k = 0; status == SP_OK && k < sizeof attribute / sizeof *attribute; k++) {
        const char *object = attribute[k].object, *name = attribute[k].name;
        status = attribute[k].text
                     ? sp_h5_attribute_texts(h, object, name, attribute[k].count, attribute[k].text, err)
                     : sp_h5_attribute_ints(h, object, name, attribute[k].count, attribute[k].integer, err);
    }
    return status;
}

static sp_status put_grains(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const sp_h5_shape position = {3, {1, p->n, p->dim}}, one = {1, {1}}, grains = {1, {p->n}};
    const double time = 0;
    double *buffer = sp_alloc((size_t)p->n * (size_t)p->dim, sizeof *buffer);
    uint8_t *rattler = sp_alloc((size_t)p->n, 1);
    sp_status status = buffer && rattler ? SP_OK : sp_fail_memory(err, (size_t)p->n * 9);
    for (size_t i = 0, dim = (size_t)p->dim; status == SP_OK && i < (size_t)p->n; i++)
        memcpy(buffer + dim * i, p->x + 3 * i, dim * sizeof *buffer);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_position, SP_H5_F64, &position, buffer, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_step, SP_H5_I64, &one, &p->steps, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_time, SP_H5_F64, &one, &time, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_radius, SP_H5_F64, &grains, p->r, err);
    for (int32_t i = 0; status == SP_OK && i < p->n; i++)
        buffer[i] = p->mass ? p->mass[i] : grain_mass(p->r[i]);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_mass, SP_H5_F64, &grains, buffer, err);
    if (status == SP_OK && p->mass)
        status = sp_h5_put(h, &name_inertia, SP_H5_F64, &grains, p->inertia, err);
    if (status == SP_OK)
        status = sp_cell_put(h, p, err);
    if (status == SP_OK)
        status = sp_packing_rattlers(p, 1e-4, rattler, NULL, NULL, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_rattler, SP_H5_U8, &grains, rattler, err);
    sp_free(buffer);
    sp_free(rattler);
    return status;
}

/* The numbers and vectors of a contact. */
static const struct contact_part {
    const sp_h5_name *name;
    size_t offset;
    bool vector, optional;
} part[] = {
    {&name_normal, offsetof(sp_contact, n), true, false}, {&name_overlap, offsetof(sp_contact, overlap), false, false},
    {&name_fn, offsetof(sp_contact, fn), false, false},   {&name_ft, offsetof(sp_contact, ft), true, false},
    {&name_kn, offsetof(sp_contact, kn), false, true},    {&name_kt, offsetof(sp_contact, kt), false, true}};

/* Who touches whom. H5MD's connectivity is between particles, and a wall is none. */
static sp_status put_partners(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const size_t n = (size_t)p->n_contacts;
    int32_t *ij = sp_alloc(2 * n, sizeof *ij), count = 0;
    sp_status status = ij ? SP_OK : sp_fail_memory(err, 2 * n * sizeof *ij);
    for (size_t c = 0; status == SP_OK && c < n; c++) {
        ij[2 * c] = p->contacts[c].i;
        ij[2 * c + 1] = p->contacts[c].j;
        count += p->contacts[c].j >= 0; /* pairs come first */
    }
    const sp_h5_shape pairs = {2, {count, 2}}, walls = {2, {p->n_contacts - count, 2}};
    if (status == SP_OK)
        status = sp_h5_put(h, &name_pairs, SP_H5_I32, &pairs, ij, err);
    if (status == SP_OK)
        status = sp_h5_attribute_reference(h, name_pairs.path, "particles_group", "/particles/grains", err);
    if (status == SP_OK && walls.dim[0] > 0)
        status = sp_h5_group(h, "/sonopack/walls", err);
    if (status == SP_OK && walls.dim[0] > 0)
        status = sp_h5_put(h, p->cell == SP_CELL_BOX ? &name_sides : &name_walls, SP_H5_I32, &walls,
                           ij + 2 * (size_t)count, err);
    sp_free(ij);
    return status;
}

static sp_status put_contacts(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const size_t n = (size_t)p->n_contacts, dim = (size_t)p->dim;
    const bool stiffnesses = sp_packing_has_stiffnesses(p);
    double *buffer = sp_alloc(dim * n, sizeof *buffer);
    sp_status status = buffer ? put_partners(h, p, err) : sp_fail_memory(err, n * dim * sizeof *buffer);
    for (size_t k = 0; status == SP_OK && k < sizeof part / sizeof *part; k++) {
        const size_t width = part[k].vector ? dim : 1;
        const sp_h5_shape shape = {part[k].vector ? 2 : 1, {p->n_contacts, p->dim}};
        if (part[k].optional && !stiffnesses)
            continue;
        for (size_t c = 0; c < n; c++)
            memcpy(buffer + c * width, (const char *)&p->contacts[c] + part[k].offset, width * sizeof *buffer);
        status = sp_h5_put(h, part[k].name, SP_H5_F64, &shape, buffer, err);
    }
    sp_free(buffer);
    return status;
}

sp_status sp_packing_put(sp_h5 *h, const sp_packing *p, sp_error *err) {
    const sp_h5_shape single = {0};
    const int32_t dim = p->dim;
    sp_status status = put_groups(h, p, err);
    if (status == SP_OK)
        status = sp_h5_put(h, &name_dim, SP_H5_I32, &single, &dim, err);
    if (status == SP_OK)
        status = sp_h5_put(h, p->cell == SP_CELL_PISTON ? &name_pressure : &name_mean, SP_H5_F64, &single, &p->pressure,
                           err);
    if (status == SP_OK)
        status = sp_h5_put_fields(h, FIELDS, field, p, err);
    if (status == SP_OK)
        status = sp_h5_put_text(h, &name_wall, sp_wall_names[p->wall], err);
    if (status == SP_OK && p->material.young > 0)
        status = sp_h5_group(h, "/sonopack/material", err);
    if (status == SP_OK && p->material.young > 0)
        status = sp_h5_put_fields(h, MATERIAL_FIELDS, material_field, &p->material, err);
    if (status == SP_OK && p->scene)
        status = sp_h5_put_text(h, &name_scene, p->scene, err);
    if (status == SP_OK)
        status = put_grains(h, p, err);
    if (status == SP_OK)
        status = put_contacts(h, p, err);
    return status;
}

sp_status sp_h5_finish(sp_h5 *h, sp_status status, const char *path, sp_error *err) {
    void *data = NULL;
    size_t size = 0;
    if (status == SP_OK)
        status = sp_h5_image(h, &data, &size, err);
    sp_h5_close(h); /* before writing, which may take long */
    if (status == SP_OK)
        status = sp_file_write(path, data, size, err);
    sp_free(data);
    return status;
}

sp_status sp_packing_save(const sp_packing *p, const char *path, sp_error *err) {
    sp_status status = sp_packing_check(p, err);
    if (status != SP_OK)
        return status;
    sp_h5 h;
    status = sp_h5_create(&h, path, err);
    if (status == SP_OK)
        status = sp_packing_put(&h, p, err);
    return sp_h5_finish(&h, status, path, err);
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

sp_status sp_packing_get_format(sp_h5 *h, int64_t *format, sp_error *err) {
    if (!sp_h5_has(h, "/sonopack"))
        return sp_h5_fail(h, err, SP_EFORMAT, "no group /sonopack: not a packing of sonopack");
    sp_status status = sp_h5_attribute_int(h, "/sonopack", "format", format, err);
    if (status == SP_OK && (*format < SP_H5_FORMAT || *format > SP_H5_FORMAT_CELL))
        status = sp_h5_fail(h, err, *format > SP_H5_FORMAT_CELL ? SP_EIO : SP_EFORMAT,
                            "format %lld of /sonopack; this version reads formats %d to %d%s", (long long)*format,
                            SP_H5_FORMAT, SP_H5_FORMAT_CELL,
                            *format > SP_H5_FORMAT_CELL ? ": a newer version made the file" : "");
    return status;
}

static sp_status get_head(sp_h5 *h, int64_t *format, int32_t *dim, sp_error *err) {
    const sp_h5_shape single = {0};
    sp_status status = sp_packing_get_format(h, format, err);
    if (status == SP_OK)
        status = sp_h5_get(h, name_dim.path, SP_H5_I32, &single, dim, err);
    if (status == SP_OK && (*dim < 1 || *dim > 3))
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s is %d; must be 1, 2 or 3", name_dim.path, *dim);
    return status;
}

static sp_status get_wall_and_scene(sp_h5 *h, sp_packing *p, sp_error *err) {
    char *wall = NULL;
    sp_status status = sp_h5_get_text(h, name_wall.path, &wall, err);
    if (status == SP_OK && !sp_wall_read(wall, &p->wall))
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s is '%.60s'; must be rigid, grain or elastic", name_wall.path, wall);
    sp_free(wall);
    if (status == SP_OK && sp_h5_has(h, material_field[0].name.path))
        status = sp_h5_get_fields(h, MATERIAL_FIELDS, material_field, &p->material, err);
    if (status == SP_OK && sp_h5_has(h, name_scene.path))
        status = sp_h5_get_text(h, name_scene.path, &p->scene, err);
    return status;
}

static sp_status get_grains(sp_h5 *h, sp_packing *p, sp_error *err) {
    const sp_h5_shape position = {3, {1, p->n, p->dim}}, grains = {1, {p->n}};
    double *buffer = sp_alloc((size_t)p->n * (size_t)p->dim, sizeof *buffer);
    if (!buffer)
        return sp_fail_memory(err, (size_t)p->n * 8);
    sp_status status = sp_h5_get(h, name_position.path, SP_H5_F64, &position, buffer, err);
    for (size_t i = 0, dim = (size_t)p->dim; status == SP_OK && i < (size_t)p->n; i++)
        memcpy(p->x + 3 * i, buffer + dim * i, dim * sizeof *buffer);
    sp_free(buffer);
    if (status == SP_OK)
        status = sp_h5_get(h, name_radius.path, SP_H5_F64, &grains, p->r, err);
    if (status == SP_OK && sp_h5_has(h, name_inertia.path)) {
        status = sp_packing_alloc_masses(p, err);
        if (status == SP_OK)
            status = sp_h5_get(h, name_mass.path, SP_H5_F64, &grains, p->mass, err);
        if (status == SP_OK)
            status = sp_h5_get(h, name_inertia.path, SP_H5_F64, &grains, p->inertia, err);
    }
    return status;
}

/* The number of rows of an array of two columns. */
static sp_status count_rows(sp_h5 *h, const char *path, int64_t *rows, sp_error *err) {
    sp_h5_shape shape = {0};
    sp_status status = sp_h5_find(h, path, SP_H5_I32, 2, &shape, err);
    *rows = shape.dim[0];
    shape.dim[1] = 2;
    return status == SP_OK ? sp_h5_get(h, path, SP_H5_I32, &shape, NULL, err) : status;
}

/* Finds how many contacts there are between grains and with walls. */
static sp_status count_contacts(sp_h5 *h, int64_t *pairs, int64_t *walls, sp_error *err) {
    *walls = 0;
    sp_status status = count_rows(h, name_pairs.path, pairs, err);
    return status == SP_OK && sp_h5_has(h, name_walls.path) ? count_rows(h, name_walls.path, walls, err) : status;
}

static sp_status get_partners(sp_h5 *h, sp_packing *p, sp_error *err) {
    const size_t n = (size_t)p->n_contacts;
    int64_t pairs = 0, walls = 0;
    int32_t *ij = sp_alloc(2 * n, sizeof *ij);
    sp_status status = ij ? count_contacts(h, &pairs, &walls, err) : sp_fail_memory(err, 2 * n * sizeof *ij);
    const sp_h5_shape first = {2, {pairs, 2}}, second = {2, {walls, 2}};
    if (status == SP_OK && pairs + walls != p->n_contacts) /* as many as were counted before */
        status = sp_h5_fail(h, err, SP_EFORMAT, "%lld contacts; must be %d", (long long)(pairs + walls), p->n_contacts);
    if (status == SP_OK)
        status = sp_h5_get(h, name_pairs.path, SP_H5_I32, &first, ij, err);
    if (status == SP_OK && walls > 0)
        status = sp_h5_get(h, name_walls.path, SP_H5_I32, &second, ij + 2 * pairs, err);
    for (size_t c = 0; status == SP_OK && c < n; c++) {
        p->contacts[c].i = ij[2 * c];
        p->contacts[c].j = ij[2 * c + 1];
    }
    sp_free(ij);
    return status;
}

static sp_status get_contacts(sp_h5 *h, sp_packing *p, sp_error *err) {
    const size_t n = (size_t)p->n_contacts, dim = (size_t)p->dim;
    double *buffer = sp_alloc(dim * n, sizeof *buffer);
    sp_status status = buffer ? get_partners(h, p, err) : sp_fail_memory(err, n * dim * sizeof *buffer);
    for (size_t k = 0; status == SP_OK && k < sizeof part / sizeof *part; k++) {
        const size_t width = part[k].vector ? dim : 1;
        const sp_h5_shape shape = {part[k].vector ? 2 : 1, {p->n_contacts, p->dim}};
        if (part[k].optional && !sp_h5_has(h, part[k].name->path))
            continue;
        status = sp_h5_get(h, part[k].name->path, SP_H5_F64, &shape, buffer, err);
        for (size_t c = 0; status == SP_OK && c < n; c++)
            memcpy((char *)&p->contacts[c] + part[k].offset, buffer + c * width, width * sizeof *buffer);
    }
    sp_free(buffer);
    return status;
}

/* Checks the extents of all arrays, before memory is taken for any of them. No two grains touch twice, and there are
 * six walls at most. */
static sp_status check_sizes(sp_h5 *h, int32_t dim, int64_t n, int64_t contacts, sp_error *err) {
    const sp_h5_shape position = {3, {1, n, dim}};
    /* 32-bit products of counts and axes are safe below */
    if (n > INT32_MAX / 4 || contacts > INT32_MAX / 8 || contacts > n * (n - 1) / 2 + 6 * n)
        return sp_h5_fail(h, err, SP_EFORMAT, "%lld grains, %lld contacts; at most %d, and each pair once",
                          (long long)n, (long long)contacts, INT32_MAX / 8);
    sp_status status = sp_h5_get(h, name_position.path, SP_H5_F64, &position, NULL, err);
    for (size_t k = 0; status == SP_OK && k < sizeof part / sizeof *part; k++) {
        const sp_h5_shape shape = {part[k].vector ? 2 : 1, {contacts, dim}};
        if (!part[k].optional || sp_h5_has(h, part[k].name->path))
            status = sp_h5_get(h, part[k].name->path, SP_H5_F64, &shape, NULL, err);
    }
    return status;
}

sp_status sp_packing_get(sp_h5 *h, sp_packing *out, sp_error *err) {
    sp_packing p = sp_packing_none();
    sp_h5_shape grains;
    const sp_h5_shape single = {0};
    int64_t pairs, walls, format;
    int32_t dim;
    sp_status status = get_head(h, &format, &dim, err);
    if (status == SP_OK)
        status = sp_h5_find(h, name_radius.path, SP_H5_F64, 1, &grains, err);
    if (status == SP_OK)
        status = count_contacts(h, &pairs, &walls, err);
    if (status == SP_OK)
        status = check_sizes(h, dim, grains.dim[0], pairs + walls, err);
    if (status == SP_OK)
        status = sp_packing_alloc(&p, dim, (int32_t)grains.dim[0], (int32_t)(pairs + walls), err);
    if (status == SP_OK)
        status = sp_cell_get(h, format, &p, err);
    if (status == SP_OK)
        status = sp_h5_get(h, name_pressure.path, SP_H5_F64, &single, &p.pressure, err);
    if (status == SP_OK)
        status = sp_h5_get_fields(h, FIELDS, field, &p, err);
    if (status == SP_OK)
        status = get_wall_and_scene(h, &p, err);
    if (status == SP_OK)
        status = get_grains(h, &p, err);
    if (status == SP_OK)
        status = get_contacts(h, &p, err);
    if (status == SP_OK) {
        status = sp_packing_check(&p, err);
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", h->path);
    }
    if (status == SP_OK)
        *out = p;
    else
        sp_packing_free(&p);
    return status;
}
