#ifndef SP_STORE_PACKING_TEXT_H
#define SP_STORE_PACKING_TEXT_H
/* The one-file text form of a packing. */

#include <sonopack/packing.h>
#include <stdbool.h>
#include <stddef.h>

/* Whether a text looks like one: its first data line is "N <count> ...". */
SP_SHARED bool sp_packing_text_looks(const char *text);
/* What else a text begins like, and the words of the command that makes a packing of it; NULL if it is unknown. */
typedef struct sp_packing_source {
    const char *what, *command, *output;
} sp_packing_source;
SP_SHARED const sp_packing_source *sp_packing_text_source(const char *text);
/* Whether a file is a packing, or is meant as one, rather than a table: it is binary, has the header of a packing, or
 * is what one is made of. A pipe is taken for a table, because it cannot be read twice. */
SP_SHARED sp_status sp_packing_file_looks(const char *path, bool *yes, sp_error *err);
/* Parses a text in place. path is for messages. The caller checks the packing (sp_packing_check). */
sp_status sp_packing_text_parse(const char *path, char *text, size_t size, sp_packing *out, sp_error *err);

#endif
