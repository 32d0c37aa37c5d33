#ifndef SONOPACK_STUDY_IMPORT_H
#define SONOPACK_STUDY_IMPORT_H
/* Reads packings that other programs wrote: LAMMPS, LIGGGHTS, Yade, MercuryDPM, extended XYZ, tables, and the tables of
 * photoelastic experiments (docs/formats.md). */

#include <sonopack/packing.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_form {
    SP_FORM_AUTO = 0, /* by the content of the file */
    SP_FORM_LAMMPS_DATA,
    SP_FORM_LAMMPS_DUMP,
    SP_FORM_LIGGGHTS, /* dumps, as those of LAMMPS */
    SP_FORM_YADE,
    SP_FORM_MERCURY,
    SP_FORM_XYZ,
    SP_FORM_CSV, /* columns named by a header row, separated by commas, tabs or blanks */
    SP_FORM_PHOTOELASTIC,
    SP_FORM_OURS /* HDF5 or text of this program: not for sp_import */
} sp_form;

/* Names of the forms by their number, ended by NULL: "auto", "lammps-data", ... */
SP_API extern const char *const sp_form_names[];

/* Recognises the form of a file by its content. SP_FORM_AUTO if it is none of these. SP_EIO if it cannot be read. */
SP_API sp_status sp_form_of_file(const char *path, sp_form *out, sp_error *err);

/* What to read and how. Numbers that are NAN follow from the files; docs/formats.md says how. Lengths and forces of the
 * files are multiplied by the units, and are then in the units of the material; without a material they must be in d
 * and E* d^2. The values below are in the units of the files, but for kn and thickness, which are in those of the
 * material. */
typedef struct sp_import_options {
    sp_form form;
    const char *contacts; /* file; "overlap": all pairs that overlap; NULL: in the file of grains, or overlap */
    const char *walls;    /* "overlap", "balance", "none", or a file; NULL: what there is */
    const char *columns;  /* "role=column,..."; NULL: the usual names */
    const char *types;    /* "1,2": only grains of these types; NULL: all */
    bool frame_given;
    int64_t frame; /* as the file names it: time step, or number */
    int dim;       /* 2 or 3; 0: by the positions */
    int up;        /* axis of the walls' normal, 0 .. 2; -1: y in two dimensions, z in three */
    bool open;     /* no periods: the box is wider than the grains */
    bool cut;      /* leaves out contacts across a periodic edge on the axis up; otherwise they are an error */
    bool exact;    /* the numbers of the file are exact, however few digits they have */
    bool rest;     /* brings the packing to rest under its pressure between rigid walls */
    int cell;      /* an sp_cell; -1: the one that the file says, else that of a piston */
    double width, depth, bottom, top, height;
    double side[4]; /* places of the walls of a box: left, right, front, back */
    double tilt[3]; /* xy, xz, yz of a periodic cell */
    double gravity; /* acceleration against the axis up; NAN: 0 */
    double pressure, friction, poisson;
    int wall; /* an sp_wall; -1: the one that forces and overlaps fit */
    sp_material material;
    double length_unit, force_unit, mass_unit; /* 1 */
    double kn, kt_ratio;                       /* stiffness of all contacts [E* d], and k_t / k_n; NAN: Hertz-Mindlin */
    double thickness;                          /* disks of this thickness; NAN: spheres */
    int64_t first_id;                          /* of grains without ids; -1: the form's, 0 or 1 */
    int threads;                               /* used to bring it to rest */
} sp_import_options;

SP_API sp_import_options sp_import_options_default(void);
/* Sets one value from "key=value" ("packing.key=value"): dimension, up, cell, sides, across, width, depth, bottom, top,
 * height, left, right, front, back, xy, xz, yz, gravity, pressure, friction, poisson, wall, digits, first_id. SP_EINVAL
 * for anything else. */
SP_API sp_status sp_import_set(sp_import_options *o, const char *text, sp_error *err);

enum { SP_IMPORT_NOTES = 16, SP_IMPORT_NOTE = 400 };

/* What was read, for the user's eyes. NAN: not known. */
typedef struct sp_import_report {
    sp_form form;
    int32_t grains, contacts, wall_contacts; /* in the packing */
    int64_t left_out;                        /* grains of other types */
    int64_t across;                          /* contacts left out, across a periodic edge on the axis up */
    double balance;       /* largest net force on a force-carrying grain over the mean contact force */
    double hertz;         /* median of Fn over Hertz's law at the overlap; NAN: one follows from the other */
    double hertz_spread;  /* largest deviation of that ratio from its median */
    double overlap_error; /* error of overlaps from the digits in the file, over the mean overlap */
    double bottom_pressure, top_pressure; /* from the forces at the walls [E*] */
    double mean_diameter;                 /* in the units of the file */
    sp_material material;                 /* with the diameter that was used; young = 0: none */
    int notes;                            /* one line each */
    char note[SP_IMPORT_NOTES][SP_IMPORT_NOTE];
} sp_import_report;

/* Reads a packing. report may be NULL. SP_EIO, SP_EFORMAT with file, line, column and value, SP_EINVAL for options that
 * contradict each other or the file, SP_EREFUSED where digits of the file are too few, or forces contradict overlaps.
 */
SP_API sp_status sp_import(const char *path, const sp_import_options *o, sp_packing *out, sp_import_report *report,
                           sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
