#ifndef SP_CLI_TRACES_H
#define SP_CLI_TRACES_H
/* Tables in the files of other programs: any table as a MAT-file, tables of signals as SAC or SLIST. */

#include "base/file.h"
#include "cli/cli.h"

#include <sonopack/study/export_file.h>
#include <stdbool.h>

/* Whether the ending is .mat, .sac or .slist. */
bool cli_is_foreign_table(const char *path);
/* How many files the table becomes: one, or for SAC one for each signal. SP_EINVAL for SAC and SLIST unless the first
 * column is the time t, at equal intervals. */
sp_status cli_foreign_files(const sp_table *t, const char *path, int *files, sp_error *err);
/* The name of file k: of several signals, NAME-F1.sac, NAME-F2.sac, ... */
sp_status cli_foreign_name(const sp_table *t, const char *path, int k, char name[SP_PATH_MAX], sp_error *err);
/* Writes all files. */
sp_status cli_foreign_write(const sp_table *t, const char *path, sp_error *err);

#endif
