/* Reads rows of numbers, quickly: files have up to millions of them. */
#include "foreign/sheet.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sp_status sp_sheet_open(const char *path, sp_number_sheet *s, sp_cursor *at, sp_error *err) {
    *s = (sp_number_sheet){.file = path, .separator = ' ', .frame = -1, .periodic = {-1, -1, -1}};
    size_t size;
    sp_status status = sp_file_read_text(path, &s->text, &size, err);
    if (status != SP_OK)
        return status;
    const size_t mark = size >= 3 && memcmp(s->text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    *at = (sp_cursor){.next = s->text + mark, .end = s->text + size};
    return SP_OK;
}

void sp_sheet_free(sp_number_sheet *s) {
    sp_free(s->text);
    sp_free(s->value);
    sp_free(s->line);
    sp_free(s->number);
    *s = (sp_number_sheet){0};
}

/* ---- lines and cells ------------------------------------------------------------------------------------------- */

const char *sp_cursor_line(sp_cursor *at, size_t *length) {
    if (at->next >= at->end)
        return NULL;
    const char *line = at->next;
    const char *stop = memchr(line, '\n', (size_t)(at->end - line));
    if (!stop)
        stop = at->end;
    at->next = stop + 1;
    at->number++;
    if (stop > line && stop[-1] == '\r')
        stop--;
    *length = (size_t)(stop - line);
    return line;
}

static bool is_blank(const char *line, size_t length) {
    for (size_t k = 0; k < length; k++)
        if (line[k] != ' ' && line[k] != '\t')
            return false;
    return true;
}

const char *sp_cursor_words(sp_cursor *at, size_t *length) {
    const char *line = sp_cursor_line(at, length);
    while (line && is_blank(line, *length))
        line = sp_cursor_line(at, length);
    return line;
}

/* Finds the next cell. Blanks around it do not belong to it. False at the end of the line. */
static bool next_cell(const char **from, const char *end, char separator, const char **cell, const char **stop) {
    const char *at = *from;
    while (at < end && (*at == ' ' || (*at == '\t' && separator != '\t')))
        at++;
    if (at >= end && !(separator != ' ' && at > *from))
        return false;
    *cell = at;
    if (separator == ' ') {
        while (at < end && *at != ' ' && *at != '\t')
            at++;
        *stop = at;
        *from = at;
        return true;
    }
    while (at < end && *at != separator)
        at++;
    *from = at < end ? at + 1 : at;
    while (at > *cell && (at[-1] == ' ' || at[-1] == '\t'))
        at--;
    *stop = at;
    return true;
}

bool sp_next_cell(const char **from, const char *end, char separator, char word[SP_SHEET_NAME]) {
    const char *cell, *stop;
    if (!next_cell(from, end, separator, &cell, &stop))
        return false;
    if (stop - cell >= 2 && *cell == '"' && stop[-1] == '"') {
        cell++;
        stop--;
    }
    const size_t length = (size_t)(stop - cell) < SP_SHEET_NAME ? (size_t)(stop - cell) : SP_SHEET_NAME - 1;
    memcpy(word, cell, length);
    word[length] = '\0';
    return true;
}

bool sp_begins(const char *line, size_t length, const char *text) {
    const size_t n = strlen(text);
    return length >= n && memcmp(line, text, n) == 0;
}

int sp_line_numbers(const char *line, size_t length, int count, double *out) {
    char word[SP_SHEET_NAME];
    const char *from = line;
    int k = 0;
    for (; k < count && sp_next_cell(&from, line + length, ' ', word); k++)
        if (!sp_word_number(word, &out[k]) || !isfinite(out[k]))
            return -1;
    return k;
}

/* ---- numbers --------------------------------------------------------------------------------------------------- */

/* Powers of ten that are exact. */
static const double power[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                               1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

typedef struct decimal {
    uint64_t mantissa;
    int digits, places; /* significant digits; digits after the point */
    bool negative;
} decimal;

static const char *read_mantissa(const char *at, const char *end, decimal *d) {
    bool point = false, any = false;
    if (at < end && (*at == '-' || *at == '+'))
        d->negative = *at++ == '-';
    for (; at < end; at++) {
        if (*at == '.' && !point) {
            point = true;
            continue;
        }
        if (*at < '0' || *at > '9')
            break;
        any = true;
        d->places += point;
        if (d->digits > 0 || *at != '0')
            d->digits++;
        if (d->digits <= 19)
            d->mantissa = 10 * d->mantissa + (uint64_t)(*at - '0');
    }
    return any ? at : NULL;
}

static const char *read_exponent(const char *at, const char *end, int *exponent) {
    if (at >= end || (*at != 'e' && *at != 'E'))
        return at;
    const bool sign = ++at < end && (*at == '-' || *at == '+');
    const bool negative = sign && *at == '-';
    at += sign;
    if (at >= end)
        return NULL;
    for (*exponent = 0; at < end; at++) {
        if (*at < '0' || *at > '9' || *exponent > 100000)
            return NULL;
        *exponent = 10 * *exponent + (*at - '0');
    }
    *exponent = negative ? -*exponent : *exponent;
    return at;
}

/* Parses a cell: NAN if it is no finite number. Numbers of up to 15 digits with a small exponent are one exact product
 * or quotient, and rounded as strtod does it. */
static double parse(const char *cell, const char *stop, int *digits) {
    decimal d = {0};
    int exponent = 0;
    const char *at = read_mantissa(cell, stop, &d);
    at = at ? read_exponent(at, stop, &exponent) : NULL;
    if (at != stop)
        return NAN;
    *digits = d.digits > *digits ? d.digits : *digits;
    exponent -= d.places;
    if (d.digits <= 15 && exponent >= -22 && exponent <= 22) {
        const double m = (double)d.mantissa, value = exponent < 0 ? m / power[-exponent] : m * power[exponent];
        return d.negative ? -value : value;
    }
    const double value = strtod(cell, NULL); /* the text ends with a zero, the cell with what is no part of a number */
    return isfinite(value) ? value : NAN;
}

/* ---- rows ------------------------------------------------------------------------------------------------------ */

void sp_sheet_clear(sp_number_sheet *s) {
    s->rows = 0;
    memset(s->digits, 0, sizeof s->digits);
}

static void *enlarge(void *old, size_t used, size_t room, size_t size) {
    void *new = sp_alloc(room, size);
    if (new &&used > 0)
        memcpy(new, old, used * size);
    if (new)
        sp_free(old);
    return new;
}

static sp_status make_room(sp_number_sheet *s, int64_t rows, sp_error *err) {
    if (rows <= s->room)
        return SP_OK;
    const size_t room = (size_t)(rows < 2 * s->room ? 2 * s->room : rows < 64 ? 64 : rows), used = (size_t)s->rows;
    const size_t width = (size_t)s->columns;
    double *value = enlarge(s->value, used * width, room * width, sizeof *value);
    s->value = value ? value : s->value;
    const char **line = enlarge(s->line, used, room, sizeof *line);
    s->line = line ? line : s->line;
    int64_t *number = enlarge(s->number, used, room, sizeof *number);
    s->number = number ? number : s->number;
    if (!value || !line || !number)
        return sp_fail_memory(err, room * (width + 2) * 8);
    s->room = (int64_t)room;
    return SP_OK;
}

static sp_status fail_cells(const sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err) {
    int cells = 0;
    const char *from = line, *cell, *stop;
    while (next_cell(&from, line + length, s->separator, &cell, &stop))
        cells++;
    char names[400];
    const bool commas = s->separator == ' ' && memchr(line, ',', length);
    return sp_fail(err, SP_EFORMAT, "%s:%lld: %d cells; must be %d%s: %s", s->file, (long long)number, cells,
                   s->columns, commas ? ", separated by blanks, not commas" : "",
                   sp_sheet_names(s, names, sizeof names));
}

sp_status sp_sheet_row(sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err) {
    sp_status status = make_room(s, s->rows + 1, err);
    if (status != SP_OK)
        return status;
    double *value = s->value + s->rows * s->columns;
    const char *from = line, *end = line + length, *cell, *stop;
    int k = 0;
    for (; next_cell(&from, end, s->separator, &cell, &stop); k++) {
        if (k == s->columns)
            return fail_cells(s, line, length, number, err);
        value[k] = parse(cell, stop, &s->digits[k]);
    }
    if (k < s->columns)
        return fail_cells(s, line, length, number, err);
    s->line[s->rows] = line;
    s->number[s->rows++] = number;
    return SP_OK;
}

sp_status sp_sheet_rows(sp_number_sheet *s, sp_cursor *at, int64_t count, const char *what, sp_error *err) {
    const int64_t before = s->rows, lines = (int64_t)(at->end - at->next) / (2 * s->columns) + 1;
    /* a wrong count is not worth its memory */
    sp_status status = count <= lines ? make_room(s, before + count, err) : SP_OK;
    while (status == SP_OK && s->rows < before + count) {
        size_t length;
        const char *line = sp_cursor_words(at, &length);
        if (!line)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: the file ends after %lld of %lld %s; must have all of them",
                           s->file, (long long)at->number, (long long)(s->rows - before), (long long)count, what);
        status = sp_sheet_row(s, line, length, at->number, err);
    }
    if (status == SP_OK && count > 0 && at->next > at->end) /* programs end every line: the last number may be cut */
        return sp_fail(err, SP_EFORMAT, "%s:%lld: the file ends inside of this line; must end with a line end", s->file,
                       (long long)at->number);
    return status;
}

sp_status sp_sheet_header(sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err) {
    char word[SP_SHEET_NAME];
    const char *from = line;
    s->columns = 0;
    s->room = 0; /* rows have another length now */
    while (sp_next_cell(&from, line + length, s->separator, word)) {
        if (s->columns == SP_SHEET_COLUMNS)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: more than %d columns", s->file, (long long)number,
                           SP_SHEET_COLUMNS);
        memcpy(s->name[s->columns++], word, SP_SHEET_NAME);
    }
    return SP_OK;
}

/* ---- keys ------------------------------------------------------------------------------------------------------ */

bool sp_line_said(const char *line, size_t length, const char *key, char *value, size_t size) {
    const size_t n = strlen(key);
    for (size_t k = 0; k + n + 1 < length; k++) {
        if ((k > 0 && line[k - 1] != ' ' && line[k - 1] != '\t') || memcmp(line + k, key, n) != 0 || line[k + n] != '=')
            continue;
        const char *from = line + k + n + 1, *end = line + length;
        const char quote = *from == '"' ? '"' : ' ';
        from += *from == '"';
        size_t used = 0;
        for (; from < end && *from != quote && used + 1 < size; from++)
            value[used++] = *from;
        value[used] = '\0';
        return true;
    }
    return false;
}

/* "# key = value" */
static bool comment_said(const char *line, size_t length, const char *key, char *value, size_t size) {
    char word[SP_SHEET_NAME];
    const char *from = line + 1, *end = line + length;
    if (!sp_next_cell(&from, end, ' ', word) || strcmp(word, key) != 0 || !sp_next_cell(&from, end, ' ', word) ||
        strcmp(word, "=") != 0 || !sp_next_cell(&from, end, ' ', word))
        return false;
    snprintf(value, size, "%s", word);
    return true;
}

bool sp_sheet_said(const sp_number_sheet *s, const char *key, char *value, size_t size) {
    if (s->head)
        return sp_line_said(s->head, s->head_length, key, value, size);
    sp_cursor at = {.next = s->text, .end = s->text + strlen(s->text)};
    size_t length;
    for (const char *line = sp_cursor_words(&at, &length); line && line[0] == '#'; line = sp_cursor_words(&at, &length))
        if (comment_said(line, length, key, value, size))
            return true;
    return false;
}

/* ---- access ---------------------------------------------------------------------------------------------------- */

int sp_sheet_find(const sp_number_sheet *s, const char *name) {
    for (int c = 0; c < s->columns; c++)
        if (strcmp(s->name[c], name) == 0)
            return c;
    return -1;
}

char *sp_sheet_word(const sp_number_sheet *s, int64_t row, int column, char word[SP_SHEET_NAME]) {
    const char *from = s->line[row], *end = from + strcspn(from, "\r\n");
    word[0] = '\0';
    for (int c = 0; c <= column; c++)
        if (!sp_next_cell(&from, end, s->separator, word))
            break;
    return word;
}

sp_status sp_sheet_fail(const sp_number_sheet *s, int64_t row, int column, const char *rule, sp_error *err) {
    char word[SP_SHEET_NAME];
    return sp_fail(err, SP_EFORMAT, "%s:%lld: column %s is '%s'; must be %s", s->file, (long long)s->number[row],
                   s->name[column], sp_sheet_word(s, row, column, word), rule);
}

sp_status sp_sheet_number(const sp_number_sheet *s, int64_t row, int column, double *out, sp_error *err) {
    *out = sp_sheet_value(s, row, column);
    return isfinite(*out) ? SP_OK : sp_sheet_fail(s, row, column, "a finite number", err);
}

sp_status sp_sheet_integer(const sp_number_sheet *s, int64_t row, int column, int64_t *out, sp_error *err) {
    const double value = sp_sheet_value(s, row, column);
    if (!(fabs(value) < 9e15) || value != trunc(value))
        return sp_sheet_fail(s, row, column, "a whole number", err);
    *out = (int64_t)value;
    return SP_OK;
}

char *sp_sheet_names(const sp_number_sheet *s, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int c = 0; c < s->columns; c++) {
        const size_t length = strlen(s->name[c]);
        if (used + length + 5 > size) {
            memcpy(text + used, "...", 4);
            break;
        }
        memcpy(text + used, s->name[c], length);
        used += length;
        text[used++] = ' ';
        text[used] = '\0';
    }
    return text;
}

double sp_digits_place(int digits, double largest) {
    return largest > 0 ? pow(10, floor(log10(largest)) + 1 - fmin(digits, 17)) : 0;
}
