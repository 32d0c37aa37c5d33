#ifndef SP_FILE_H
#define SP_FILE_H
/* Reads whole files, and writes them atomically. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Longest supported path, including the terminating zero. */
enum { SP_PATH_MAX = 4096 };

/* Reads a whole text file. *text is terminated by a zero that *size does not count; free it with sp_free. SP_EIO if the
 * file cannot be opened or read, SP_EFORMAT if it contains a zero byte or is too large. */
SP_SHARED sp_status sp_file_read_text(const char *path, char **text, size_t *size, sp_error *err);

/* The same for any file; zero bytes are allowed. */
SP_SHARED sp_status sp_file_read(const char *path, char **data, size_t *size, sp_error *err);

/* Reads bytes of an open file at a place: their number, which is below `size` at the end of the file only, or -1 with
 * errno. */
SP_SHARED int64_t sp_file_read_at(int fd, void *data, size_t size, int64_t at);

/* Writes data to a temporary file in the same folder, syncs it, and renames it to path. Devices and pipes are written
 * directly, and a symbolic link keeps pointing to its target. On failure (SP_EIO) the old file is unchanged. */
SP_SHARED sp_status sp_file_write(const char *path, const void *data, size_t size, sp_error *err);

/* A file that is written piece by piece, under a temporary name in the folder of `path`. */
typedef struct sp_draft {
    char path[SP_PATH_MAX], temporary[SP_PATH_MAX];
    int fd;   /* open to read and write, and locked; -1: there is no draft */
    int mode; /* of the file that it replaces; -1: there is none */
} sp_draft;
/* SP_EIO if the file cannot be written, or is a device or a pipe. */
SP_SHARED sp_status sp_draft_begin(const char *path, sp_draft *d, sp_error *err);
/* Syncs the draft and renames it to `path`. On failure (SP_EIO) it is dropped, and the old file is unchanged. */
SP_SHARED sp_status sp_draft_commit(sp_draft *d, sp_error *err);
SP_SHARED void sp_draft_drop(sp_draft *d);

/* Removes all temporary files that this process is writing, and lets it make no more. For a handler of signals that
 * ends the process: it calls nothing that is unsafe there. */
SP_SHARED void sp_drafts_abandon(void);

/* Checks that a file can be created in the folder, by creating a temporary one and removing it. SP_EIO if not. */
SP_SHARED sp_status sp_folder_probe(const char *folder, sp_error *err);

/* Checks that sp_file_write could write the file, as far as this shows before: SP_EIO for a link to nothing, a file
 * that must not be written, a folder in which none can be created. */
SP_SHARED sp_status sp_file_probe(const char *path, sp_error *err);

/* Removes temporary files of processes that were killed while writing. */
SP_SHARED void sp_folder_clean(const char *folder);
SP_SHARED void sp_folder_clean_beside(const char *path); /* in the folder of a file */

#endif
