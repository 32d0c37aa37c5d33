#ifndef SP_CLI_CONVERT_OUT_H
#define SP_CLI_CONVERT_OUT_H
/* What convert writes beside packings of its own: files of other programs, with displacements, and moving pictures. */

#include "cli/cli.h"

#include <sonopack/study/export_file.h>

/* Options of convert about OUT. */
typedef struct convert_out {
    const char *to;      /* name of the form; NULL: by the ending */
    const char *vectors; /* file of modes, or table of displacements */
    int64_t mode;        /* number among all modes; < 0: not given */
    const char *times;   /* "LOW:HIGH:N", or one time; NULL: not given */
    int64_t frames;      /* of a period of a mode; 0: not given */
    double amplitude;    /* largest displacement shown [d]; < 0: not given */
} convert_out;

/* The ending whose form OUT has: that of --to, or its own; NULL if it is neither .h5, .txt nor a form of export.
 * SP_EINVAL for an unknown word of --to. */
sp_status convert_out_ending(const convert_out *o, const char *path, const char **ending, sp_error *err);
/* Whether the ending is a form of another program. */
bool convert_out_is_foreign(const char *ending);
/* Checks options and files before the work. */
sp_status convert_out_check(const cli_common *common, const convert_out *o, const char *ending, const char *path,
                            sp_error *err);
/* Writes the packing p to path. in: the file that p was read from, for which displacements are computed or read; NULL:
 * none. */
sp_status convert_out_write(const cli_common *common, const convert_out *o, const char *ending, const sp_packing *p,
                            const char *in, const char *path, sp_error *err);

#endif
