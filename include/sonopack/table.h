#ifndef SONOPACK_TABLE_H
#define SONOPACK_TABLE_H
/* A table in memory: what every command prints and every figure is drawn from. */

#include <sonopack/status.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sp_cell_kind { SP_CELL_NUMBER = 0, SP_CELL_INTEGER, SP_CELL_TEXT } sp_cell_kind;

typedef union sp_cell {
    double number;
    int64_t integer;
    char *text; /* owned by the table */
} sp_cell;

typedef struct sp_column {
    char name[40];
    char unit[40]; /* "" if none */
    sp_cell_kind kind;
} sp_column;

enum { SP_COLUMNS_MAX = 1000000 };

typedef struct sp_table {
    int columns;
    int64_t rows, capacity;
    sp_column *column; /* [columns] */
    sp_cell *cells;    /* [rows][columns] */
    int comments;
    char **comment; /* lines without '#', e.g. "pressure = 0.0001" */
} sp_table;

SP_API sp_table sp_table_none(void);
SP_API void sp_table_free(sp_table *t);
/* All columns before the first row. */
SP_API sp_status sp_table_add_column(sp_table *t, const char *name, const char *unit, sp_cell_kind kind, sp_error *err);
/* One value a column in order: double, int64_t or const char * (copied) as the column's kind says. */
SP_API sp_status sp_table_add_row(sp_table *t, sp_error *err, ...);
/* The same where no column is of texts: [columns] of them, whole numbers where the column is of integers. */
SP_API sp_status sp_table_add_numbers(sp_table *t, const double *values, sp_error *err);
/* printf-style comment line; by convention "key = value" or a sentence. */
SP_API sp_status sp_table_add_comment(sp_table *t, sp_error *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
SP_API int sp_table_find_column(const sp_table *t, const char *name); /* -1 if there is none */
/* Value of a comment "key = value" as text inside the table, NULL if there is none. */
SP_API const char *sp_table_comment_value(const sp_table *t, const char *key);
/* A cell as a number: integers converted, NAN for text. */
SP_API double sp_table_number(const sp_table *t, int64_t row, int column);

typedef enum sp_table_format { SP_TSV = 0, SP_CSV, SP_JSON } sp_table_format;
/* The table as text, numbers with the digits that read back exactly (15 to 17). Caller frees; NULL: no memory. */
SP_API char *sp_table_text(const sp_table *t, sp_table_format format);
/* Writes text to path atomically. */
SP_API sp_status sp_text_save(const char *path, const char *text, size_t size, sp_error *err);
/* A TSV file with '#' comments, one header row, then rows; or plain columns of numbers without a header (names c1, c2,
 * ...). Numbers where every cell of a column is one. */
SP_API sp_status sp_table_read(const char *path, sp_table *out, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
