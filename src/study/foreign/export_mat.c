/* Packings and tables for MATLAB and Octave. */
#include "base/base.h"
#include "foreign/export.h"
#include "foreign/mat.h"
#include "packing/geometry.h"

#include <string.h>

static sp_status check_size(const sp_mat *m, sp_error *err) {
    return m->large ? sp_fail(err, SP_EREFUSED, "a variable has more than 2 GB, the limit of a MAT-file") : SP_OK;
}

sp_status sp_export_mat(const sp_export_data *e, sp_text text[SP_EXPORT_FILES_MAX], sp_error *err) {
    const sp_packing *p = e->packing;
    sp_table grains = sp_table_none(), contacts = sp_table_none();
    sp_mat m;
    sp_status status = sp_export_grains_table(e, &grains, err);
    if (status == SP_OK)
        status = sp_export_contacts_table(e, &contacts, err);
    if (status == SP_OK) {
        sp_mat_begin(&m, &text[0]);
        sp_mat_number(&m, "dimension", p->dim);
        sp_mat_matrix(&m, "box", 1, p->dim, p->box);
        if (p->cell != SP_CELL_PISTON || p->gravity != 0) {
            sp_mat_text(&m, "cell", sp_cell_names[p->cell]);
            sp_mat_matrix(&m, "tilt", 1, 3, p->tilt);
            sp_mat_number(&m, "gravity", p->gravity);
        }
        sp_mat_number(&m, "pressure", p->pressure);
        sp_mat_number(&m, "friction", p->friction);
        sp_mat_number(&m, "poisson", p->poisson);
        sp_mat_text(&m, "wall", sp_wall_names[p->wall]);
        sp_mat_text(&m, "units", e->units->all);
        if (p->scene)
            sp_mat_text(&m, "scene", p->scene);
        sp_mat_struct(&m, "grains", &grains);
        sp_mat_units(&m, "grains_units", &grains);
        sp_mat_struct(&m, "contacts", &contacts);
        sp_mat_units(&m, "contacts_units", &contacts);
        status = check_size(&m, err);
    }
    sp_table_free(&grains);
    sp_table_free(&contacts);
    return status;
}

sp_status sp_table_save_mat(const sp_table *t, const char *path, sp_error *err) {
    sp_text text = {0};
    sp_mat m;
    sp_mat_begin(&m, &text);
    sp_mat_columns(&m, t);
    sp_mat_units(&m, "units", t);
    sp_mat_comments(&m, "comments", t);
    sp_status status = check_size(&m, err);
    if (status == SP_OK && text.failed)
        status = sp_fail_memory(err, text.capacity);
    if (status == SP_OK)
        status = sp_text_save(path, text.data, text.size, err);
    sp_text_free(&text);
    return status;
}
