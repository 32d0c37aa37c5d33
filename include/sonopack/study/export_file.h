#ifndef SONOPACK_STUDY_EXPORT_FILE_H
#define SONOPACK_STUDY_EXPORT_FILE_H
/* Tables and signals in the files of other programs: MATLAB and Octave, SAC, ObsPy. docs/formats.md says what each file
 * contains. Every file is written under a temporary name and renamed. */

#include <sonopack/table.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

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
