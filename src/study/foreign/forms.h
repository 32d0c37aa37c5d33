#ifndef SP_FOREIGN_FORMS_H
#define SP_FOREIGN_FORMS_H
/* The forms of files: each reader fills a sheet with the rows and the box of one frame. */

#include "foreign/sheet.h"

#include <sonopack/study/import.h>

/* Which of several frames: the one of this number, or the last. */
typedef struct sp_frame_choice {
    bool given;
    int64_t frame;
} sp_frame_choice;

typedef sp_status sp_form_reader(sp_number_sheet *s, sp_cursor *at, sp_frame_choice frame, sp_error *err);
sp_form_reader sp_read_lammps_data, sp_read_dump, sp_read_yade, sp_read_mercury_data, sp_read_mercury_fstat,
    sp_read_xyz, sp_read_table;

/* Reads a file by its form. The contacts of MercuryDPM are in another form than the grains; `contacts` says which is
 * meant. Sets s->file to path. */
sp_status sp_read_form(const char *path, sp_form form, bool contacts, sp_frame_choice frame, sp_number_sheet *s,
                       sp_error *err);

#endif
