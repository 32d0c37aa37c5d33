#ifndef SONOPACK_STUDY_EXPORT_FILE_H
#define SONOPACK_STUDY_EXPORT_FILE_H
/* Packings, motions and signals in the files of other programs: ParaView, OVITO, LAMMPS, MATLAB and Octave, ObsPy,
 * spreadsheets. docs/formats.md says what each file contains. Every file is written under a temporary name and renamed.
 */

#include <sonopack/packing.h>
#include <sonopack/table.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_export_form {
    SP_EXPORT_NONE = -1,
    SP_EXPORT_VTP = 0, /* VTK XML PolyData: NAME.vtp (grains), NAME-contacts.vtp, NAME-walls.vtp, and NAME.vtm, which
                          names the first two */
    SP_EXPORT_LAMMPS_DATA, /* atom style sphere */
    SP_EXPORT_LAMMPS_DUMP, /* dump custom */
    SP_EXPORT_XYZ,         /* extended XYZ */
    SP_EXPORT_CSV,         /* NAME.csv (grains) and NAME-contacts.csv */
    SP_EXPORT_MAT          /* MATLAB 5 MAT-file: structs grains and contacts, and numbers */
} sp_export_form;

/* The form that the ending of a file name stands for, in upper or lower case; SP_EXPORT_NONE if there is none. */
SP_API sp_export_form sp_export_form_of(const char *path);
/* The form of a name as in "lammps-data"; SP_EXPORT_NONE if there is none. */
SP_API sp_export_form sp_export_form_named(const char *name);
/* Name and ending of form 0, 1, ...; NULL after the last. */
SP_API const char *sp_export_form_name(int form);
SP_API const char *sp_export_form_ending(int form);

/* Displacements of the grains, in a mode or after a pulse. */
typedef struct sp_grain_vectors {
    const double *displacement; /* [n][3]; 0 for grains that do not move */
    const double *rotation;     /* [n][3], or NULL */
} sp_grain_vectors;

enum { SP_EXPORT_FILES_MAX = 4, SP_EXPORT_PATH_MAX = 4096 };
/* How many files sp_export writes, and their names, the first of which is `path`. 0 if a name is too long. */
SP_API int sp_export_files(sp_export_form form, const char *path, char name[SP_EXPORT_FILES_MAX][SP_EXPORT_PATH_MAX]);
typedef struct sp_export_options {
    const sp_grain_vectors *vectors; /* what CSV, MAT, dump, XYZ and VTP list beside the grains; NULL: none */
    const sp_material *si; /* write SI units: m, kg, N, Pa of grains of this material; NULL: d, rho, E* as in the
                              packing. The vectors are written as they are */
} sp_export_options;
/* Writes a packing. options: NULL for none. SP_EINVAL for vectors that are not finite, for a form that has no place for
 * them and for a material that sp_material_check refuses, SP_EIO. After a failure no new file is left. */
SP_API sp_status sp_export(const sp_packing *p, sp_export_form form, const sp_export_options *options, const char *path,
                           sp_error *err);

/* ---- moving pictures -------------------------------------------------------------------------------------------- */

/* A series of snapshots for ParaView: NAME.pvd, and NAME-0000.vtp, NAME-0001.vtp, ... beside it. The points are the
 * centres plus `scale` times the displacements. */
typedef struct sp_export_series {
    int frames;         /* 1 .. SP_EXPORT_FRAMES_MAX */
    const double *time; /* [frames] ascending */
    double scale;
    const sp_material *si; /* centres and radii in m; NULL: in d. Times and displacements are written as they are */
    /* Writes the displacements of frame k to displacement[n][3] and, unless it is NULL, rotation[n][3]. */
    void (*frame)(void *user, int k, double *displacement, double *rotation);
    bool rotations;
    void *user;
} sp_export_series;
enum { SP_EXPORT_FRAMES_MAX = 10000 };

/* Name of the file of frame k of a series; "" if it is too long. */
SP_API void sp_export_frame_name(const char *path, int k, char name[SP_EXPORT_PATH_MAX]);
/* Writes the frames, and at last the .pvd file. SP_EINVAL for displacements that are not finite, SP_EIO. */
SP_API sp_status sp_export_pvd(const sp_packing *p, const sp_export_series *series, const char *path, sp_error *err);

/* ---- tables and signals ----------------------------------------------------------------------------------------- */

/* Writes a table as a MATLAB 5 MAT-file: a variable for each column (text: a cell array), `units` (a struct with a text
 * for each column) and `comments` (a cell array). SP_EREFUSED above 2 GB a variable. */
SP_API sp_status sp_table_save_mat(const sp_table *t, const char *path, sp_error *err);

/* A signal at equal intervals of time. */
typedef struct sp_trace {
    const char *station, *component; /* up to 8 letters or digits each */
    const char *event;               /* up to 16 characters: what the source was */
    const char *unit, *time_unit;    /* of the values and of the times; up to 8 characters each, no blanks */
    double step, begin;              /* interval and first time */
    int64_t n;
    const double *value;     /* [n] */
    double pressure, height; /* of the packing: SAC's user0 and user1; NAN: unknown */
} sp_trace;

/* Writes a SAC file (version 6, little endian). Values, interval and times become single precision. SP_EINVAL for
 * values that are not finite or beyond single precision. */
SP_API sp_status sp_trace_save_sac(const sp_trace *trace, const char *path, sp_error *err);
/* Writes traces as text, SLIST, in full precision. */
SP_API sp_status sp_traces_save_slist(int count, const sp_trace *trace, const char *path, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
