#ifndef SP_TABLE_WORDS_H
#define SP_TABLE_WORDS_H
/* Rows and columns of words from a text file. */

#include <sonopack/status.h>
#include <stdint.h>

enum { SP_WORD_COLUMNS = 1024 };

typedef struct sp_word_table {
    const char *file; /* for messages; not owned */
    char *text;       /* buffer that all words point into */
    int columns;
    char *name[SP_WORD_COLUMNS]; /* [columns] header; all NULL without a header row */
    int64_t rows;
    char **cell;   /* [rows][columns] */
    int64_t *line; /* [rows] line numbers in the file */
    int comments;
    char **comment; /* [comments] without '#' and the blank after it */
} sp_word_table;

/* Reads TSV with an optional header row (a first row that is not all numbers), or columns separated by blanks. Blank
 * lines are skipped. SP_EFORMAT with the line number for rows of different lengths, too many columns or comments,
 * overlong lines, and binary files. */
SP_SHARED sp_status sp_word_table_read(const char *path, sp_word_table *out, sp_error *err);
SP_SHARED void sp_word_table_free(sp_word_table *s);

SP_SHARED int sp_word_table_find(const sp_word_table *s, const char *name); /* -1: no such column */
SP_SHARED char *sp_word_table_cell(const sp_word_table *s, int64_t row, int column);
/* Value of a comment "key = value", owned by the table; NULL without the key. */
SP_SHARED const char *sp_word_table_value(const sp_word_table *s, const char *key);

#endif
