#ifndef SONOPACK_STATUS_H
#define SONOPACK_STATUS_H
/* How a call ended, and the one-line reason when it failed.
 *
 * Every function that can fail returns an sp_status and takes an sp_error, which may be NULL.
 * Outputs are written on success only; the library never prints and never exits. */

#include <sonopack/export.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_status {
    SP_OK = 0,
    SP_EINVAL = -1,      /* a wrong argument, option or scene */
    SP_EIO = -2,         /* a file could not be opened, read or written */
    SP_EFORMAT = -3,     /* a file is not what it should be: foreign, truncated, inconsistent */
    SP_ENOMEM = -4,      /* no memory */
    SP_EFAILED = -5,     /* the work itself failed: no equilibrium, no convergence */
    SP_EREFUSED = -6,    /* a result that could not be vouched for was withheld */
    SP_EINTERRUPTED = -7 /* stopped on request; what was finished is kept */
} sp_status;

enum { SP_ERROR_TEXT = 1024 };

/* The reason: one line, without a final full stop: where (file, line or field), the value, what would be right. */
typedef struct sp_error {
    sp_status status;
    char text[SP_ERROR_TEXT];
    char key[64]; /* the scene key, option or column at fault as the user writes it; "" if none */
} sp_error;

/* A word for a status ("invalid", "i/o", ...), never NULL. */
SP_API const char *sp_status_name(sp_status status);

/* Frees memory that a function of sonopack handed to its caller (texts, arrays). NULL is allowed. */
SP_API void sp_free(void *memory);

#ifdef __cplusplus
}
#endif
#endif
