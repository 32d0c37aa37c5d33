#ifndef SP_SOURCE_H
#define SP_SOURCE_H
/* The text of a scene before libconfig parses it. */

#include <sonopack/status.h>
#include <stddef.h>

/* Reads a whole text file. SP_EINVAL for binary data, and for files above 32 MB. what is "scene", for messages. Free
 * the text with sp_free. */
sp_status sp_source_load(const char *path, const char *what, char **text, sp_error *err);

/* Makes a copy that libconfig reads correctly. Integers get the suffix L, because libconfig silently wraps longer ones.
 * Arrays become lists, because libconfig's arrays cannot mix 1 and 0.5. Refused are integers of more than 64 bits,
 * comments and strings without an end, @include, and more nesting or settings than any scene has. name is what messages
 * call the file. Free the copy with sp_free. */
sp_status sp_source_clean(const char *text, const char *name, char **clean, sp_error *err);

#endif
