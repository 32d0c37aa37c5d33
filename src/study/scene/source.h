#ifndef SP_SOURCE_H
#define SP_SOURCE_H
/* The text of a scene, and libconfig, which parses it. */

#include <libconfig.h>
#include <sonopack/status.h>

/* Reads a whole text file. SP_EINVAL for binary data, and for files above 32 MB. what is "scene", for messages. Free
 * the text with sp_free. */
sp_status sp_source_load(const char *path, const char *what, char **text, sp_error *err);

/* Parses a text into a config that config_init has prepared. Arrays become lists, and integers have 64 bits. Refused
 * are larger ones, @include, and more settings than any scene has. name is what messages call the file. */
sp_status sp_source_parse(const char *text, const char *name, config_t *out, sp_error *err);

#endif
