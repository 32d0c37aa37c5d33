#ifndef SP_STORE_PACKING_TEXT_H
#define SP_STORE_PACKING_TEXT_H
/* The one-file text form of a packing. */

#include <sonopack/packing.h>
#include <stddef.h>

/* Whether a text looks like one: its first data line is "N <count> ...". */
SP_SHARED bool sp_packing_text_looks(const char *text);
/* Parses a text in place. path is for messages. The caller checks the packing (sp_packing_check). */
sp_status sp_packing_text_parse(const char *path, char *text, size_t size, sp_packing *out, sp_error *err);

#endif
