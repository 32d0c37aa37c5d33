#ifndef SONOPACK_TABLE_H
#define SONOPACK_TABLE_H
/* A table in memory: what every command prints and every figure is drawn from. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_column_kind { SP_COLUMN_NUMBER = 0, SP_COLUMN_INTEGER, SP_COLUMN_TEXT } sp_column_kind;

typedef union sp_entry {
    double number;
    int64_t integer;
    char *text; /* owned by the table */
} sp_entry;

typedef struct sp_column {
    char name[40];
    char unit[40]; /* "" if none */
    sp_column_kind kind;
} sp_column;

enum { SP_COLUMNS_MAX = 1000000 };

/* Metadata: one "key = value" of a comment line. */
typedef struct sp_table_value {
    char *key, *text;    /* owned by the table; the value as it is written */
    sp_column_kind kind; /* of the whole value */
    double number;       /* that the value begins with; NAN if none */
    int comment;         /* index of the comment line */
} sp_table_value;

typedef struct sp_table {
    int columns;
    int64_t rows, capacity;
    sp_column *column; /* [columns] */
    sp_entry *cells;   /* [rows][columns] */
    int comments, values;
    char **comment;        /* [comments] lines without '#' */
    sp_table_value *value; /* [values] metadata, in the order of the lines */
} sp_table;

/* ---- building a table ------------------------------------------------------------------------------------------- */

/* A table without columns, rows and comments. */
SP_API sp_table sp_table_none(void);
SP_API void sp_table_free(sp_table *t);

/* Adds a column at the right; "" for a unit means none. SP_EINVAL if the table already has rows. */
SP_API sp_status sp_table_add_column(sp_table *t, const char *name, const char *unit, sp_column_kind kind,
                                     sp_error *err);
/* Adds a row. One argument for each column, in order: double, int64_t or const char * (copied), as the column's kind
 * requires. */
SP_API sp_status sp_table_add_row(sp_table *t, sp_error *err, ...);
/* Adds a row of numbers: values[columns]. Columns of integers get them truncated. SP_EINVAL if a column holds text. */
SP_API sp_status sp_table_add_numbers(sp_table *t, const double *values, sp_error *err);

/* ---- comments and metadata -------------------------------------------------------------------------------------- */

/* Adds a comment line, printf-style. A line "key = value" is metadata too. */
SP_API sp_status sp_table_add_comment(sp_table *t, sp_error *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Set metadata: each adds the comment line "key = value" after the lines so far. SP_EINVAL if the key is already set.
 * A number has so many significant digits, or for digits = 0 the fewest that read back as the same double. */
SP_API sp_status sp_table_set_number(sp_table *t, const char *key, double value, int digits, sp_error *err);
SP_API sp_status sp_table_set_integer(sp_table *t, const char *key, int64_t value, sp_error *err);
SP_API sp_status sp_table_set_text(sp_table *t, const char *key, const char *value, sp_error *err);

/* Gets the number that a value begins with: 0.25 of "0.25, error 0.01". False without the key or a finite number. */
SP_API bool sp_table_get_number(const sp_table *t, const char *key, double *value);
/* The value as it is written, owned by the table; NULL without the key. */
SP_API const char *sp_table_get_text(const sp_table *t, const char *key);

/* ---- looking up ------------------------------------------------------------------------------------------------- */

/* Index of the column with this name, -1 if there is none. */
SP_API int sp_table_find_column(const sp_table *t, const char *name);
/* A cell as a number: integers are converted, text gives NAN. */
SP_API double sp_table_number(const sp_table *t, int64_t row, int column);

/* ---- files ------------------------------------------------------------------------------------------------------ */

typedef enum sp_table_format { SP_TSV = 0, SP_CSV, SP_JSON } sp_table_format;
/* The table as text. Numbers have the digits that read back exactly (15 to 17). Free the text with sp_free; NULL means
 * that memory ran out. CSV leaves out the comments. */
SP_API char *sp_table_text(const sp_table *t, sp_table_format format);
enum { SP_DIGITS_OF_ERRORS = 0, SP_DIGITS_ALL = -1 };
/* The table for readers: as TSV, but columns are aligned, and numbers have 1 to 17 digits; SP_DIGITS_ALL: all;
 * SP_DIGITS_OF_ERRORS: errors two, a column X two of those of X_err, at most six. Free the text with sp_free; NULL
 * means that memory ran out. */
SP_API char *sp_table_aligned(const sp_table *t, int digits);
/* Writes a file at once: a reader sees the old content or the new one, never a part. */
SP_API sp_status sp_text_save(const char *path, const char *text, size_t size, sp_error *err);
/* Reads a TSV file with '#' comments and a header row, or columns of numbers between blanks without a header (named c1,
 * c2, ...). A column holds numbers if all its cells are numbers, text otherwise. SP_EFORMAT for rows of different
 * lengths and for binary files. */
SP_API sp_status sp_table_read(const char *path, sp_table *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
