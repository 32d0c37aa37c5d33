#ifndef SP_STORE_TEXT_H
#define SP_STORE_TEXT_H
/* Text out and in: a buffer that grows, numbers that keep every bit, and lines with their numbers. */

#include <locale.h>
#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- locale ---------------------------------------------------------------------------------------------------- */

/* Numbers are read and written with a decimal point whatever the program around us has set: between enter and leave
 * this thread uses the "C" locale. */
typedef struct sp_locale {
    locale_t plain, before;
} sp_locale;
SP_SHARED sp_locale sp_locale_enter(void);
SP_SHARED void sp_locale_leave(sp_locale *l);

/* ---- writing --------------------------------------------------------------------------------------------------- */

/* A lack of memory is remembered: test `failed` once at the end. */
typedef struct sp_text {
    char *data; /* ends with a zero; free with sp_free */
    size_t size, capacity;
    bool failed;
} sp_text;
SP_SHARED void sp_text_add(sp_text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
SP_SHARED void sp_text_bytes(sp_text *t, const char *bytes, size_t size);
/* 17 significant digits; nan, inf, -inf. */
SP_SHARED void sp_text_number(sp_text *t, double value);
SP_SHARED void sp_text_free(sp_text *t);

/* ---- reading --------------------------------------------------------------------------------------------------- */

/* The whole word as a decimal number ("nan" and "inf" included), not hexadecimal. False for anything else, also for a
 * number beyond the largest double. */
SP_SHARED bool sp_word_number(const char *word, double *out);
/* The whole word as a decimal integer of 64 bits. */
SP_SHARED bool sp_word_integer(const char *word, int64_t *out);
SP_SHARED bool sp_word_unsigned(const char *word, uint64_t *out);

/* Cuts a text into lines, in place: LF or CRLF, a byte order mark skipped, 65536 bytes a line at the most. */
typedef struct sp_lines {
    const char *file; /* for messages */
    char *next, *end;
    int64_t number; /* of the last line given out, from 1 */
} sp_lines;
SP_SHARED sp_lines sp_lines_of(const char *file, char *text, size_t size);
/* *line = NULL at the end. SP_EFORMAT for a line that is too long. */
sp_status sp_lines_next(sp_lines *l, char **line, sp_error *err);
/* Next line that is neither blank nor a '#' comment. */
SP_SHARED sp_status sp_lines_next_data(sp_lines *l, char **line, sp_error *err);

/* Cuts a line at runs of spaces and tabs, in place; gives the number of words, at most `most` + 1 (then there are too
 * many, and word[] holds the first `most`). */
SP_SHARED int sp_line_words(char *line, char **word, int most);

#endif
