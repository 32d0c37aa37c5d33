#ifndef SP_COLUMN_TABLE_H
#define SP_COLUMN_TABLE_H
/* The tables of a column, made under the eyes of somebody who may stop it. */

#include <sonopack/column.h>

/* The share of the work that is done, 0 .. 1. false stops it: SP_EINTERRUPTED. */
typedef bool (*sp_column_watch)(double share, void *user);
typedef struct sp_column_watcher {
    sp_column_watch watch; /* NULL: nobody watches */
    void *user;
} sp_column_watcher;

/* As sp_column_table. */
sp_status sp_column_table_watched(const sp_column_spec *c, int threads, sp_column_watcher watcher, sp_table *out,
                                  sp_error *err);

/* What was asked for, as comments "key = value" with the names of the scene; those that are there already are left. */
sp_status sp_column_note_spec(const sp_column_spec *c, sp_table *t, sp_error *err);
/* What came of a run; and what must be known of it, as comments that begin with "warning: ". */
sp_status sp_column_note_report(const sp_column_spec *c, const sp_column_report *r, sp_table *t, sp_error *err);
/* What must be known of the model, likewise. */
sp_status sp_column_note_model(const sp_column_spec *c, sp_table *t, sp_error *err);

#endif
