#ifndef SP_FOREIGN_WORK_H
#define SP_FOREIGN_WORK_H
/* The state of an import, and its stages in their order. */

#include "foreign/forms.h"

enum { SP_ROLES_MAX = 64 };

/* What the option columns says: the column of a role, and whether its sign changes. */
typedef struct sp_role {
    char role[24], column[SP_SHEET_NAME];
    double sign;
} sp_role;

/* A column of a sheet; index = -1: there is none. */
typedef struct sp_place {
    int index;
    double sign;
} sp_place;

typedef struct sp_raw_grain {
    int64_t id, row;      /* row of the sheet */
    double x[3], r;       /* along the axes of the packing */
    double mass, inertia; /* NAN: not known */
    bool boundary;
} sp_raw_grain;

/* A contact. Numbers that are not known are NAN. */
typedef struct sp_raw_contact {
    int32_t i, j; /* j may be a wall of the cell */
    int64_t row;  /* of the sheet; -1: found by its overlap */
    double n[3];  /* from i to j, by the positions */
    double depth; /* overlap by the positions; NAN: no position of the wall */
    double overlap, fn, ft[3], kn, kt;
} sp_raw_contact;

typedef struct sp_work {
    const char *path;
    const sp_import_options *o; /* own */
    sp_import_options own;      /* as given, and as the files say */
    sp_form form;
    int roles;
    sp_role role[SP_ROLES_MAX];
    bool used[SP_ROLES_MAX];
    sp_number_sheet grains, contacts, walls; /* rows = 0: none */
    int dim, axis[3];                        /* axis[a] of the file is axis a of the packing */
    int32_t n;
    sp_raw_grain *grain; /* [n] by id */
    int32_t found;
    int64_t room;
    sp_raw_contact *contact; /* [found] */
    sp_cell cell;
    double low[3], edge[3]; /* origin and lengths of the box; the last axis is up */
    double tilt[3];
    bool periodic[3];
    bool open[3];                     /* a period wider than all grains, since there is none in the file */
    bool cut;                         /* contacts across the face of the box on the axis up are left out */
    bool has_wall[6];                 /* whether the positions of bottom, top, left, ... are known */
    double gravity;                   /* [E* / (rho d)] */
    double scale, force, stiffness;   /* from units of the file to d, E* d^2; from units of the material to E* d */
    double place;                     /* error of an overlap from the digits of the positions [d] */
    double force_place;               /* relative error of forces from their digits; NAN: no forces */
    double mass_place;                /* relative error of masses from their digits, and those of radii */
    bool has_forces, has_ft, springs; /* normal and tangential forces are given; stiffnesses are */
    sp_wall wall;
    double friction, poisson;
    sp_import_report report;
} sp_work;

enum { SP_WORK_TEXT = 64 };
/* Pressures and lengths for the report: "9.4e-05 E* (98.4 kPa)" and "7.2 d (7.06 mm)"; without a material as they are.
 * Return text. */
char *sp_work_pressure(const sp_work *w, double pressure, char text[SP_WORK_TEXT]);
char *sp_work_length(const sp_work *w, double length, char text[SP_WORK_TEXT]);
/* Adds a line to the report. */
void sp_work_note(sp_work *w, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* columns.c */
sp_status sp_roles_read(sp_work *w, sp_error *err);
/* The column of a role in a sheet: by the option, or by one of its usual names. */
sp_place sp_role_find(sp_work *w, const sp_number_sheet *s, const char *role);
/* The same; SP_EFORMAT names the columns that there are, if there is none. */
sp_status sp_role_need(sp_work *w, const sp_number_sheet *s, const char *role, sp_place *out, sp_error *err);
/* A number in a place, with its sign; NAN if there is no column. */
sp_status sp_place_number(const sp_number_sheet *s, int64_t row, sp_place at, double *out, sp_error *err);
/* -1 if the option turns this axis of the file, as y=-y does; else 1. */
double sp_axis_sign(const sp_work *w, int axis);
/* Whether the option names the column of a role. */
bool sp_role_is_named(const sp_work *w, const char *role);
/* Three components, role_x, role_y, role_z, along the axes of the packing; *given tells whether there are columns.
 * Components along an axis that is turned change their signs, unless the option names their own columns. */
sp_status sp_role_vector(sp_work *w, const sp_number_sheet *s, const char *role, sp_place out[3], bool *given,
                         sp_error *err);
sp_status sp_place_vector(const sp_number_sheet *s, int64_t row, const sp_place *at, double *out, sp_error *err);
/* Refuses roles of the option that no sheet has. */
sp_status sp_roles_check(const sp_work *w, sp_error *err);

/* gather.c */
sp_status sp_gather_grains(sp_work *w, sp_error *err);
/* Index of the grain with an id; -1: none. */
int32_t sp_grain_of_id(const sp_work *w, int64_t id);

/* scale.c */
sp_status sp_scale_grains(sp_work *w, sp_error *err);

/* cell.c */
/* The axis across a wall. */
int sp_work_wall_axis(const sp_work *w, int32_t wall);
/* The wall on this axis that lies in the direction of `sign`. */
int32_t sp_work_wall(const sp_work *w, int axis, double sign);
/* The place that an option gives to a wall, in units of the file; NAN: none. */
double sp_work_wall_given(const sp_work *w, int32_t wall);
/* The cell alone, for sp_packing_nearest and the like: dimension, kind, edges and tilt. */
sp_packing sp_work_cell(const sp_work *w);
/* Decides which kind of cell the file and the options mean. */
sp_status sp_cell_choose(sp_work *w, sp_error *err);
/* Find the box of a periodic cell, or one with walls on all sides, and move the grains to it. */
sp_status sp_cell_find_periods(sp_work *w, sp_error *err);
sp_status sp_cell_find_walls(sp_work *w, sp_error *err);
/* Refuses periods in which two grains could touch twice. */
sp_status sp_cell_check_periods(const sp_work *w, sp_error *err);

/* box.c */
sp_status sp_box_find(sp_work *w, sp_error *err);
/* Vector from grain i to the nearest image of grain j. Sets *across if that is through a face on the axis up. */
void sp_work_separation(const sp_work *w, int32_t i, int32_t j, double d[3]);

/* touch.c */
sp_status sp_work_add(sp_work *w, const sp_raw_contact *c, sp_error *err);
/* Fills in n and depth of a contact of two grains, or of a grain and a flat wall. */
void sp_work_geometry(const sp_work *w, sp_raw_contact *c);
/* Finds all pairs of grains that overlap. */
sp_status sp_touch_grains(sp_work *w, sp_error *err);
/* Only counts them. */
sp_status sp_touch_count(sp_work *w, int64_t *pairs, sp_error *err);
/* Finds all grains that overlap the walls whose positions are known. */
sp_status sp_touch_walls(sp_work *w, sp_error *err);

/* links.c */
sp_status sp_read_links(sp_work *w, sp_error *err);
/* walls.c */
sp_status sp_read_walls(sp_work *w, sp_error *err);
/* law.c */
sp_status sp_law_complete(sp_work *w, sp_error *err);
/* finish.c */
sp_status sp_finish(sp_work *w, sp_packing *out, sp_error *err);
/* rest.c */
sp_status sp_bring_to_rest(sp_work *w, sp_packing *p, sp_error *err);

#endif
