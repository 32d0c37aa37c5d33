/* Series of snapshots: VTK PolyData files, and a ParaView data file that gives each of them its time. */
#include "base/base.h"
#include "base/file.h"
#include "foreign/export.h"
#include "foreign/vtk.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

static const char note_own[] = "sonopack: lengths in d; the points are displaced by scale times displacement",
                  note_si[] = "sonopack: lengths in m; the points are displaced by scale times displacement";

void sp_export_frame_name(const char *path, int k, char name[SP_EXPORT_PATH_MAX]) {
    char suffix[24];
    snprintf(suffix, sizeof suffix, "-%04d.vtp", k);
    if (!sp_export_beside(path, suffix, name))
        name[0] = '\0';
}

/* Arrays of the grains for one frame. */
typedef struct frame {
    const sp_packing *packing;
    const sp_export_series *series;
    double length; /* unit of centres and radii */
    double *displacement, *rotation, *points, *radius;
    int64_t *id;
} frame;

static sp_status check_frame(const frame *f, int k, sp_error *err) {
    for (int32_t i = 0; i < 3 * f->packing->n; i++)
        if (!isfinite(f->displacement[i]) || (f->rotation && !isfinite(f->rotation[i])))
            return sp_fail(err, SP_EINVAL, "frame %d: the displacement of grain %d is not a finite number", k, i / 3);
    return SP_OK;
}

static void add_frame(const frame *f, int k, sp_text *t) {
    const sp_packing *p = f->packing;
    for (size_t i = 0; i < 3 * (size_t)p->n; i++)
        f->points[i] = f->length * p->x[i] + f->series->scale * f->displacement[i];
    sp_vtk_begin(t, f->series->si ? note_si : note_own);
    sp_vtk_piece(t, SP_VTK_VERTICES, p->n);
    sp_text_add(t, "<PointData Scalars=\"radius\" Vectors=\"displacement\">\n");
    sp_vtk_array(t, "id", SP_VTK_I64, 1, p->n, f->id);
    sp_vtk_array(t, "radius", SP_VTK_F64, 1, p->n, f->radius);
    sp_vtk_array(t, "displacement", SP_VTK_F64, 3, p->n, f->displacement);
    if (f->rotation)
        sp_vtk_array(t, "rotation", SP_VTK_F64, 3, p->n, f->rotation);
    sp_text_add(t, "</PointData>\n");
    sp_vtk_points(t, SP_VTK_VERTICES, p->n, f->points);
    sp_vtk_field(t);
    sp_vtk_array(t, "TimeValue", SP_VTK_F64, 1, 1, &f->series->time[k]);
    sp_vtk_array(t, "scale", SP_VTK_F64, 1, 1, &f->series->scale);
    sp_vtk_end(t);
}

static sp_status write_frame(const frame *f, int k, const char *path, sp_error *err) {
    char name[SP_EXPORT_PATH_MAX];
    sp_text t = {0};
    f->series->frame(f->series->user, k, f->displacement, f->rotation);
    sp_status status = check_frame(f, k, err);
    sp_export_frame_name(path, k, name);
    if (status == SP_OK)
        add_frame(f, k, &t);
    if (status == SP_OK && t.failed)
        status = sp_fail_memory(err, 2 * t.capacity);
    if (status == SP_OK)
        status = sp_file_write(name, t.data, t.size, err);
    sp_text_free(&t);
    return status;
}

static sp_status write_index(const sp_export_series *series, const char *path, sp_error *err) {
    char name[SP_EXPORT_PATH_MAX];
    sp_text t = {0};
    sp_text_add(&t, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
    for (int k = 0; k < series->frames; k++) {
        sp_export_frame_name(path, k, name);
        sp_text_add(&t, "<DataSet timestep=\"");
        sp_text_number(&t, series->time[k]);
        sp_text_add(&t, "\" group=\"\" part=\"0\" file=\"");
        sp_vtk_escaped(&t, sp_export_base(name));
        sp_text_add(&t, "\"/>\n");
    }
    sp_text_add(&t, "</Collection>\n</VTKFile>\n");
    sp_status status = t.failed ? sp_fail_memory(err, t.capacity) : sp_file_write(path, t.data, t.size, err);
    sp_text_free(&t);
    return status;
}

static sp_status check_series(const sp_packing *p, const sp_export_series *s, const char *path, sp_error *err) {
    char name[SP_EXPORT_PATH_MAX];
    sp_export_frame_name(path, s->frames, name);
    if (s->frames < 1 || s->frames > SP_EXPORT_FRAMES_MAX)
        return sp_fail(err, SP_EINVAL, "%d frames; must be 1 .. %d", s->frames, SP_EXPORT_FRAMES_MAX);
    if (!isfinite(s->scale) || !name[0])
        return sp_fail(err, SP_EINVAL, "%.100s: the scale is not finite, or the name is too long", path);
    const sp_status status = s->si ? sp_material_check(s->si, err) : SP_OK;
    return status == SP_OK ? sp_packing_check(p, err) : status;
}

/* Removes the frames 0 .. count - 1 that were not there before. */
static void remove_frames(const char *path, int count, const uint8_t *new) {
    char name[SP_EXPORT_PATH_MAX];
    for (int k = 0; k < count; k++) {
        sp_export_frame_name(path, k, name);
        if (new[k])
            unlink(name);
    }
}

static sp_status write_series(const frame *f, const char *path, uint8_t *new, sp_error *err) {
    char name[SP_EXPORT_PATH_MAX];
    sp_status status = SP_OK;
    int k = 0;
    for (; k < f->series->frames && status == SP_OK; k++) {
        sp_export_frame_name(path, k, name);
        new[k] = access(name, F_OK) != 0;
        status = write_frame(f, k, path, err);
    }
    if (status == SP_OK)
        status = write_index(f->series, path, err);
    if (status != SP_OK)
        remove_frames(path, k, new);
    return status;
}

sp_status sp_export_pvd(const sp_packing *p, const sp_export_series *series, const char *path, sp_error *err) {
    sp_status status = check_series(p, series, path, err);
    if (status != SP_OK)
        return status;
    const size_t n = (size_t)p->n;
    frame f = {.packing = p, .series = series, .length = sp_export_units_of(series->si).length};
    f.displacement = sp_alloc(3 * n, sizeof *f.displacement);
    f.rotation = series->rotations ? sp_alloc(3 * n, sizeof *f.rotation) : NULL;
    f.points = sp_alloc(3 * n, sizeof *f.points);
    f.radius = sp_alloc(n, sizeof *f.radius);
    f.id = sp_alloc(n, sizeof *f.id);
    uint8_t *new = sp_alloc((size_t)series->frames, 1);
    if (!f.displacement || (series->rotations && !f.rotation) || !f.points || !f.radius || !f.id || !new)
        status = sp_fail_memory(err, 10 * n * sizeof *f.points);
    for (size_t i = 0; i < n && status == SP_OK; i++)
        f.id[i] = (int64_t)i, f.radius[i] = f.length * p->r[i];
    if (status == SP_OK)
        status = write_series(&f, path, new, err);
    sp_free(f.displacement);
    sp_free(f.rotation);
    sp_free(f.points);
    sp_free(f.radius);
    sp_free(f.id);
    sp_free(new);
    return status;
}
