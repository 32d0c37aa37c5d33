#ifndef SP_SOURCE_H
#define SP_SOURCE_H
/* The text of a scene before the parser sees it. */

#include <sonopack/status.h>
#include <stddef.h>

/* The whole file as a string; refuses what is no text file of reasonable size. what: "scene", for messages. Free with
 * sp_free. */
sp_status sp_source_load(const char *path, const char *what, char **text, sp_error *err);

/* A copy that libconfig reads safely: integers carry the suffix L (libconfig wraps longer ones silently), arrays are
 * lists (its arrays do not take 1 beside 0.5), and what it would take without a word or at any cost is refused:
 * integers of more than 64 bits, comments and strings without end,
 * @include (a scene is one file), nesting and numbers of settings beyond any scene. name: the file, for messages. Free
 * with sp_free. */
sp_status sp_source_clean(const char *text, const char *name, char **clean, sp_error *err);

#endif
