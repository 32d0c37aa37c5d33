#ifndef SP_TEXT_H
#define SP_TEXT_H
/* Writing and reading text: a growing buffer, numbers without loss of bits, and numbered lines. */

#include "base/base.h"

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- writing --------------------------------------------------------------------------------------------------- */

/* If memory runs out, `failed` is set and further additions do nothing: check it once at the end. */
typedef struct sp_text {
    char *data; /* zero-terminated; free with sp_text_free or sp_free */
    size_t size, capacity;
    bool failed;
} sp_text;
SP_SHARED void sp_text_add(sp_text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
SP_SHARED void sp_text_bytes(sp_text *t, const char *bytes, size_t size);
/* Adds the shortest text that reads back as the same double (sp_number_text). */
SP_SHARED void sp_text_number(sp_text *t, double value);
SP_SHARED void sp_text_free(sp_text *t);

/* ---- reading --------------------------------------------------------------------------------------------------- */

/* Parses a whole word as a decimal number, "nan" and "inf" included. False for anything else, including hexadecimal
 * numbers and numbers too large for a double. */
SP_SHARED bool sp_word_number(const char *word, double *out);
/* Parses a whole word as a decimal 64-bit integer. False for anything else. */
SP_SHARED bool sp_word_integer(const char *word, int64_t *out);
SP_SHARED bool sp_word_unsigned(const char *word, uint64_t *out);

/* Splits a text into lines, in place. Lines end with LF or CRLF and have at most 65536 bytes; a byte order mark is
 * skipped. */
typedef struct sp_lines {
    const char *file; /* for error messages */
    char *next, *end;
    int64_t number; /* of the last line returned, from 1 */
} sp_lines;
SP_SHARED sp_lines sp_lines_of(const char *file, char *text, size_t size);
/* Returns the next line, or *line = NULL at the end. SP_EFORMAT if the line is too long. */
sp_status sp_lines_next(sp_lines *l, char **line, sp_error *err);
/* Returns the next line that is neither blank nor a '#' comment. */
SP_SHARED sp_status sp_lines_next_data(sp_lines *l, char **line, sp_error *err);

/* Splits a line into words at spaces and tabs, in place. Returns the number of words; `most` + 1 means that there are
 * more than `most`, and word[] has the first `most`. */
SP_SHARED int sp_line_words(char *line, char **word, int most);

#endif
