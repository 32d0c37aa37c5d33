#ifndef SP_CLI_TRACE_H
#define SP_CLI_TRACE_H
/* Tables that commands read: signals of `sonopack signal', and traces of a laboratory. */

#include "cli/cli.h"

/* Reads a table of numbers: CSV if the file ends in .csv, else TSV. */
sp_status cli_read_table(const char *path, sp_table *out, sp_error *err);
/* Whether a file is a packing rather than a table: it is binary, or has the header of a packing. A pipe is taken for a
 * table, because it cannot be read twice. */
sp_status cli_is_packing(const char *path, bool *yes, sp_error *err);

typedef struct cli_trace {
    int64_t n;
    double *t, *f;           /* one block, t its start */
    double window;           /* the first front is searched for up to this time; 0: everywhere */
    bool foreign;            /* the times are not in d/sqrt(E* / rho) */
    const char *length_unit; /* of the height; "": unknown */
    char t_unit[sizeof((sp_column *)0)->unit], f_unit[sizeof((sp_column *)0)->unit]; /* "": unknown */
    double height;                                                                   /* of the packing; NAN: unknown */
} cli_trace;
/* Reads two columns of a table as times and forces. Free out->t. */
sp_status cli_trace_of(const sp_table *table, int time, int force, cli_trace *out, sp_error *err);
/* Number of columns F1, F2, ... from column `first` on; 1 if that has another name. */
int cli_count_signals(const sp_table *t, int first);

/* The detector of a signal's column by the table's metadata, "F2 = from bottom:normal to plane:25:normal, ...". */
typedef struct cli_detector {
    char word[SP_PLACE_TEXT]; /* "plane:25:normal" */
    double plane;             /* its height, in the unit of the table's height; NAN if it is not a plane */
    double source;            /* the same of the source; 0 if that is not a plane */
} cli_detector;
/* False if the metadata does not name the detector. */
bool cli_find_detector(const sp_table *t, const char *column, cli_detector *out);
/* How far a detector at a height is from the source: in a periodic cell by the shorter way, in the unit of the heights.
 */
double cli_way(const sp_table *t, const cli_detector *detector, double at);

#endif
