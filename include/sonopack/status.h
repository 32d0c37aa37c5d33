#ifndef SONOPACK_STATUS_H
#define SONOPACK_STATUS_H
/* Error reporting.
 *
 * Every function that can fail returns an sp_status and takes an sp_error, which may be NULL. Outputs are written on
 * success only. The library never prints and never exits. */

#include <sonopack/visibility.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_status {
    SP_OK = 0,
    SP_EINVAL = -1,      /* invalid argument, option or scene */
    SP_EIO = -2,         /* a file could not be opened, read or written */
    SP_EFORMAT = -3,     /* a file has the wrong format, or is truncated or inconsistent */
    SP_ENOMEM = -4,      /* out of memory */
    SP_EFAILED = -5,     /* the computation failed: no equilibrium, no convergence */
    SP_EREFUSED = -6,    /* a result was withheld because its accuracy cannot be guaranteed */
    SP_EINTERRUPTED = -7 /* stopped on request; finished work is kept */
} sp_status;

enum { SP_ERROR_TEXT = 1024 };

/* Reason of a failure: one line without a full stop. It names the place (file, line or field), the value, and what
 * would be right. */
typedef struct sp_error {
    sp_status status;
    char text[SP_ERROR_TEXT];
    char key[64]; /* the scene key, option or column at fault as the user writes it; "" if none */
} sp_error;

/* Name of a status ("invalid", "i/o", ...), never NULL. */
SP_API const char *sp_status_name(sp_status status);

/* Frees memory (texts, arrays) that the library has returned to its caller. NULL is allowed. */
SP_API void sp_free(void *memory);

#ifdef __cplusplus
}
#endif
#endif
