#ifndef GUIDED_H
#define GUIDED_H
/* What all targets share: an input as files, and what must hold of every reader whatever it is given.
 *
 * A target is LLVMFuzzerTestOneInput, which libFuzzer calls where clang builds it (the preset `guided'), and replay.c
 * where any other compiler does. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *count, char ***words);

/* Ends the process with a message that names the condition. */
#define must(condition) guided_must((condition), #condition, __FILE__, __LINE__)
void guided_must(bool good, const char *what, const char *file, int line);

enum { GUIDED_FILES = 4, GUIDED_PATH = 32, GUIDED_WORDS = 24 };

/* Makes file number k, in memory, hold these bytes. The path remains the same. */
const char *guided_file(int k, const void *data, size_t size);

/* A folder that is removed at the end, and paths of files 0 .. GUIDED_FILES - 1 in it, for what is written. */
const char *guided_folder(void);
const char *guided_output(int k);

/* Up to `most` parts of an input, which lines "====" separate, each with a zero after its end. */
typedef struct guided_parts {
    int count;
    char *part[GUIDED_FILES + 1];
    size_t size[GUIDED_FILES + 1];
    char *memory;
} guided_parts;
guided_parts guided_split(const uint8_t *data, size_t size, int most);
void guided_free(guided_parts *p);
/* Splits a text into words at blanks and ends of lines, in place. */
int guided_words(char *text, char *word[GUIDED_WORDS]);

/* A status is one of sp_status, and a failure has its reason in one line. Returns whether it is SP_OK. */
bool guided_good(sp_status status, const sp_error *err);

/* sp_error with a reason that no function would leave there. */
sp_error guided_error(void);

#endif
