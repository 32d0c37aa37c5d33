#ifndef SP_FOREIGN_SHEET_H
#define SP_FOREIGN_SHEET_H
/* Rows of numbers from a text file of another program. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { SP_SHEET_COLUMNS = 128, SP_SHEET_NAME = 64 };

typedef struct sp_number_sheet {
    const char *file; /* for messages; not owned */
    char *text;       /* the whole file */
    char separator;   /* ' ' for any white space, or ',' or '\t' */
    int columns;
    char name[SP_SHEET_COLUMNS][SP_SHEET_NAME];
    int digits[SP_SHEET_COLUMNS]; /* most significant digits that a cell of the column has */
    int64_t rows, room;
    double *value;     /* [rows][columns]; NAN for cells that are no finite numbers */
    const char **line; /* [rows] start of the row in the text */
    int64_t *number;   /* [rows] line numbers */
    /* what the headers say */
    bool box[3]; /* whether edges are known */
    double low[3], high[3];
    double tilt[3];   /* xy, xz, yz */
    int periodic[3];  /* 1, 0; -1: unknown */
    const char *head; /* a line of key=value in the text; NULL: none */
    size_t head_length;
    int frames;
    int64_t frame; /* of the rows, as the file names it */
} sp_number_sheet;

/* Where a reader is in the text. */
typedef struct sp_cursor {
    const char *next;
    const char *end;
    int64_t number; /* of the last line returned, from 1 */
} sp_cursor;

/* Reads the whole file; no rows yet. SP_EIO, SP_EFORMAT for binary files. */
sp_status sp_sheet_open(const char *path, sp_number_sheet *s, sp_cursor *at, sp_error *err);
void sp_sheet_free(sp_number_sheet *s);

/* Returns the next line without its end (LF, CRLF), or NULL at the end of the text. */
const char *sp_cursor_line(sp_cursor *at, size_t *length);
/* The same for lines that are not blank. */
const char *sp_cursor_words(sp_cursor *at, size_t *length);
/* Copies the next cell from a line to `word` and moves on. False at the end of the line. */
bool sp_next_cell(const char **from, const char *end, char separator, char word[SP_SHEET_NAME]);

/* Whether a line, which need not end with a zero, begins with a text. */
bool sp_begins(const char *line, size_t length, const char *text);
/* Reads `count` numbers from a line. Returns how many there were; -1 if one is no finite number. */
int sp_line_numbers(const char *line, size_t length, int count, double *out);

/* Removes all rows, for another frame. */
void sp_sheet_clear(sp_number_sheet *s);
/* Adds a row. SP_EFORMAT unless it has as many cells as there are columns. */
sp_status sp_sheet_row(sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err);
/* Adds `count` rows; blank lines are skipped. SP_EFORMAT if the file ends before. */
sp_status sp_sheet_rows(sp_number_sheet *s, sp_cursor *at, int64_t count, const char *what, sp_error *err);
/* Sets names and number of columns from a line. SP_EFORMAT for too many. */
sp_status sp_sheet_header(sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err);

/* Finds the value of a key that the file says: "key=value" or key="value" in its head, or a comment "# key = value"
 * before the first row. */
bool sp_sheet_said(const sp_number_sheet *s, const char *key, char *value, size_t size);
/* The same in any line of key=value. */
bool sp_line_said(const char *line, size_t length, const char *key, char *value, size_t size);

int sp_sheet_find(const sp_number_sheet *s, const char *name); /* -1: no such column */
static inline double sp_sheet_value(const sp_number_sheet *s, int64_t row, int column) {
    return s->value[row * s->columns + column];
}
/* The text of a cell. Returns word. */
char *sp_sheet_word(const sp_number_sheet *s, int64_t row, int column, char word[SP_SHEET_NAME]);
/* Refuses a cell: "file:line: column is 'word'; must be ...". */
sp_status sp_sheet_fail(const sp_number_sheet *s, int64_t row, int column, const char *rule, sp_error *err);
/* A finite number. */
sp_status sp_sheet_number(const sp_number_sheet *s, int64_t row, int column, double *out, sp_error *err);
/* A whole number. */
sp_status sp_sheet_integer(const sp_number_sheet *s, int64_t row, int column, int64_t *out, sp_error *err);
/* The names of all columns, for messages; cut with "..." if they are too long. Returns text. */
char *sp_sheet_names(const sp_number_sheet *s, char *text, size_t size);
/* The spacing of numbers of so many digits and absolute values up to `largest`. */
double sp_digits_place(int digits, double largest);

#endif
