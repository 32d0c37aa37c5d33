#ifndef SP_FILE_H
#define SP_FILE_H
/* Whole files: read into memory, or written atomically. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Longest path that is handled, the terminating zero included. */
enum { SP_PATH_MAX = 4096 };

/* Reads a whole text file; *text ends with a zero that *size does not count. SP_EIO when it cannot be opened or read,
 * SP_EFORMAT when it holds a zero byte (no text) or is beyond reason. Caller frees with sp_free. */
SP_SHARED sp_status sp_file_read_text(const char *path, char **text, size_t *size, sp_error *err);

/* Any file, likewise. */
SP_SHARED sp_status sp_file_read(const char *path, char **data, size_t *size, sp_error *err);

/* FNV-1a of 64 bits over the bytes of a file. SP_EIO. */
SP_SHARED sp_status sp_file_hash(const char *path, uint64_t *hash, sp_error *err);

/* Writes data to a temporary file in the folder of path, syncs it, and renames it. Devices and pipes are written to
 * directly; a symbolic link stays one. On failure (SP_EIO) nothing has changed under the name. */
SP_SHARED sp_status sp_file_write(const char *path, const void *data, size_t size, sp_error *err);

/* Whether a file can be made in a folder: makes a temporary and removes it. */
SP_SHARED sp_status sp_folder_probe(const char *folder, sp_error *err);

/* Removes the temporary files that processes left behind which were killed while they wrote. */
SP_SHARED void sp_folder_clean(const char *folder);

#endif
