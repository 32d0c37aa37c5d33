/* Reads a text file into rows and columns of words, and these into a table. */
#include "table/words.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"

#include <sonopack/table.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { COMMENTS_MAX = 4096 };

void sp_word_table_free(sp_word_table *s) {
    sp_free(s->text);
    sp_free(s->cell);
    sp_free(s->line);
    sp_free(s->comment);
    *s = (sp_word_table){0};
}

int sp_word_table_find(const sp_word_table *s, const char *name) {
    for (int c = 0; c < s->columns; c++)
        if (s->name[c] && strcmp(s->name[c], name) == 0)
            return c;
    return -1;
}

char *sp_word_table_cell(const sp_word_table *s, int64_t row, int column) { return s->cell[row * s->columns + column]; }

const char *sp_word_table_value(const sp_word_table *s, const char *key) {
    size_t length = strlen(key);
    for (int c = 0; c < s->comments; c++) {
        const char *line = s->comment[c] + strspn(s->comment[c], " \t");
        if (strncmp(line, key, length) != 0)
            continue;
        line += length + strspn(line + length, " \t");
        if (*line == '=')
            return line + 1 + strspn(line + 1, " \t");
    }
    return NULL;
}

/* ---- cells ----------------------------------------------------------------------------------------------------- */

/* Replaces the escapes \t, \n, \r, \# and \\ of sp_table_text. Other backslashes stay. */
static void unescape(char *word) {
    char *to = word;
    for (const char *from = word; *from; from++) {
        char c = *from;
        if (c == '\\') {
            switch (from[1]) {
            case 't': c = '\t', from++; break;
            case 'n': c = '\n', from++; break;
            case 'r': c = '\r', from++; break;
            case '#': c = '#', from++; break;
            case '\\': from++; break;
            default: break;
            }
        }
        *to++ = c;
    }
    *to = '\0';
}

static char *trim(char *word) {
    word += strspn(word, " ");
    size_t length = strlen(word);
    while (length > 0 && word[length - 1] == ' ')
        length--;
    word[length] = '\0';
    return word;
}

/* Splits a line at single tabs. Returns the number of cells like sp_line_words. */
static int tab_cells(char *line, char **word, int most) {
    for (int count = 0;;) {
        char *tab = strchr(line, '\t');
        if (tab)
            *tab = '\0';
        if (count == most)
            return most + 1;
        word[count] = trim(line);
        unescape(word[count++]);
        if (!tab)
            return count;
        line = tab + 1;
    }
}

static bool all_numbers(char *const *word, int count) {
    double value;
    for (int c = 0; c < count; c++)
        if (!sp_word_number(word[c], &value))
            return false;
    return true;
}

/* Whether single tabs separate the cells, which then may contain blanks. That is so if the first row has tabs and no
 * empty cell, and is not a row of numbers. */
static bool tabs_separate(const char *line, bool *tabs) {
    char *word[SP_WORD_COLUMNS];
    char *copy = sp_strdup(line);
    if (!copy)
        return false;
    int count = sp_line_words(copy, word, SP_WORD_COLUMNS);
    *tabs = strchr(line, '\t') && !(count <= SP_WORD_COLUMNS && all_numbers(word, count));
    const char *cell = line;
    while (*tabs) {
        cell += strspn(cell, " ");
        if (*cell == '\t' || !*cell)
            *tabs = false;
        cell += strcspn(cell, "\t");
        if (!*cell)
            break;
        cell++;
    }
    sp_free(copy);
    return true;
}

/* ---- rows and comments ----------------------------------------------------------------------------------------- */

static sp_status add_comment(sp_word_table *s, char *text, int64_t line, sp_error *err) {
    if (s->comments == COMMENTS_MAX)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: more than %d comment lines", s->file, (long long)line, COMMENTS_MAX);
    char **larger = sp_array_reserve(s->comment, (size_t)s->comments, sizeof *larger);
    if (!larger)
        return sp_fail_memory(err, (size_t)s->comments * sizeof *larger);
    s->comment = larger;
    s->comment[s->comments++] = text + (*text == ' ');
    return SP_OK;
}

static sp_status add_row(sp_word_table *s, char *const *word, int count, int64_t line, sp_error *err) {
    if (count != s->columns)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %s%d cells where the first row has %d", s->file, (long long)line,
                       count > SP_WORD_COLUMNS ? "more than " : "", count > SP_WORD_COLUMNS ? SP_WORD_COLUMNS : count,
                       s->columns);
    const size_t row_size = (size_t)s->columns * sizeof *s->cell;
    char **cell = sp_array_reserve(s->cell, (size_t)s->rows, row_size);
    s->cell = cell ? cell : s->cell;
    int64_t *lines = sp_array_reserve(s->line, (size_t)s->rows, sizeof *lines);
    s->line = lines ? lines : s->line;
    if (!cell || !lines)
        return sp_fail_memory(err, (size_t)s->rows * (row_size + sizeof *lines));
    memcpy(s->cell + s->rows * s->columns, word, (size_t)count * sizeof *word);
    s->line[s->rows++] = line;
    return SP_OK;
}

/* Cells of a file .csv are numbers or names; a quote has no meaning there. */
static void tabs_for_commas(char *line) {
    char *to = line;
    for (const char *from = line; *from; from++)
        if (*from != '"')
            *to++ = *from == ',' ? '\t' : *from;
    *to = '\0';
}

/* Adds a line with cells. The first one sets the separator and the number of columns, and may be the header. */
static sp_status take_row(sp_word_table *s, char *line, int64_t number, bool *tabs, sp_error *err) {
    bool first = s->columns == 0;
    if (first && !tabs_separate(line, tabs))
        return sp_fail_memory(err, strlen(line));
    char *word[SP_WORD_COLUMNS];
    int count = *tabs ? tab_cells(line, word, SP_WORD_COLUMNS) : sp_line_words(line, word, SP_WORD_COLUMNS);
    if (!first)
        return add_row(s, word, count, number, err);
    if (count > SP_WORD_COLUMNS)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: more than %d columns", s->file, (long long)number, SP_WORD_COLUMNS);
    s->columns = count;
    if (all_numbers(word, count))
        return add_row(s, word, count, number, err);
    memcpy(s->name, word, (size_t)count * sizeof *word);
    return SP_OK;
}

sp_status sp_word_table_read(const char *path, sp_word_table *out, sp_error *err) {
    sp_word_table s = {.file = path};
    size_t size = 0;
    sp_locale locale = sp_locale_enter();
    sp_status status = sp_file_read_text(path, &s.text, &size, err);
    const char *dot = strrchr(path, '.');
    const bool commas = dot && strcasecmp(dot, ".csv") == 0;
    bool tabs = false;
    sp_lines lines = sp_lines_of(path, s.text, size);
    while (status == SP_OK) {
        char *line;
        status = sp_lines_next(&lines, &line, err);
        if (status != SP_OK || !line)
            break;
        char *first = line + strspn(line, " \t");
        if (commas && *first != '#')
            tabs_for_commas(line);
        if (*first == '#')
            status = add_comment(&s, first + 1, lines.number, err);
        else if (*first)
            status = take_row(&s, line, lines.number, &tabs, err);
    }
    if (status == SP_OK && s.columns == 0)
        status = sp_fail(err, SP_EFORMAT, "%s: no table: neither a header nor a row", path);
    sp_locale_leave(&locale);
    if (status == SP_OK)
        *out = s;
    else
        sp_word_table_free(&s);
    return status;
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* Reads the line "units: name [unit] name [unit] ...". */
static void take_units(sp_table *t, const char *text) {
    for (;;) {
        text += strspn(text, " ");
        const char *open = strstr(text, " ["), *close = open ? strchr(open, ']') : NULL;
        if (!close)
            return;
        for (int c = 0; c < t->columns; c++) {
            sp_column *column = &t->column[c];
            if (strlen(column->name) == (size_t)(open - text) && memcmp(column->name, text, strlen(column->name)) == 0)
                snprintf(column->unit, sizeof column->unit, "%.*s", (int)(close - open - 2), open + 2);
        }
        text = close + 1;
    }
}

static bool numeric_column(const sp_word_table *s, int column) {
    double value;
    for (int64_t k = 0; k < s->rows; k++)
        if (!sp_word_number(sp_word_table_cell(s, k, column), &value))
            return false;
    return true;
}

static sp_status add_columns(const sp_word_table *s, sp_table *t, sp_error *err) {
    for (int c = 0; c < s->columns; c++) {
        char name[sizeof t->column[0].name];
        snprintf(name, sizeof name, "c%d", c + 1);
        if (s->name[c] && strlen(s->name[c]) >= sizeof name)
            return sp_fail(err, SP_EFORMAT, "%s: the name of column %d has %zu characters; at most %zu", s->file, c + 1,
                           strlen(s->name[c]), sizeof name - 1);
        sp_status status = sp_table_add_column(t, s->name[c] ? s->name[c] : name, "",
                                               numeric_column(s, c) ? SP_COLUMN_NUMBER : SP_COLUMN_TEXT, err);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

static sp_status add_cells(const sp_word_table *s, sp_table *t, sp_error *err) {
    size_t cells = (size_t)s->rows * (size_t)s->columns;
    t->cells = sp_alloc(cells, sizeof *t->cells);
    if (!t->cells)
        return sp_fail_memory(err, cells * sizeof *t->cells);
    t->capacity = t->rows = s->rows;
    for (size_t k = 0; k < cells; k++) {
        const char *word = s->cell[k];
        if (t->column[k % (size_t)s->columns].kind == SP_COLUMN_NUMBER)
            sp_word_number(word, &t->cells[k].number);
        else if (!(t->cells[k].text = sp_strdup(word)))
            return sp_fail_memory(err, strlen(word));
    }
    return SP_OK;
}

static sp_status add_comments(const sp_word_table *s, sp_table *t, sp_error *err) {
    for (int c = 0; c < s->comments; c++) {
        sp_status status = SP_OK;
        if (strncmp(s->comment[c], "units:", 6) == 0)
            take_units(t, s->comment[c] + 6);
        else
            status = sp_table_add_comment(t, err, "%s", s->comment[c]);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

sp_status sp_table_read(const char *path, sp_table *out, sp_error *err) {
    sp_word_table s = {0};
    sp_table t = sp_table_none();
    sp_locale locale = sp_locale_enter();
    sp_status status = sp_word_table_read(path, &s, err);
    if (status == SP_OK)
        status = add_columns(&s, &t, err);
    if (status == SP_OK)
        status = add_cells(&s, &t, err);
    if (status == SP_OK)
        status = add_comments(&s, &t, err);
    sp_locale_leave(&locale);
    sp_word_table_free(&s);
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}
