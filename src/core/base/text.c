/* Text buffers, numbers in text, and lines. */
#include "base/text.h"

#include "base/base.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- writing --------------------------------------------------------------------------------------------------- */

static bool reserve(sp_text *t, size_t more) {
    char *data = t->failed ? NULL : sp_grow(t->data, t->size + more + 1, &t->capacity, 1);
    if (data)
        t->data = data;
    t->failed = !data;
    return data != NULL;
}

void sp_text_bytes(sp_text *t, const char *bytes, size_t size) {
    if (!reserve(t, size))
        return;
    memcpy(t->data + t->size, bytes, size);
    t->size += size;
    t->data[t->size] = '\0';
}

void sp_text_add(sp_text *t, const char *format, ...) {
    char small[1024];
    va_list args;
    va_start(args, format);
    int length = vsnprintf(small, sizeof small, format, args);
    va_end(args);
    if (length < 0 || !reserve(t, (size_t)length)) {
        t->failed = true;
        return;
    }
    if ((size_t)length < sizeof small) {
        sp_text_bytes(t, small, (size_t)length);
        return;
    }
    va_start(args, format);
    vsnprintf(t->data + t->size, (size_t)length + 1, format, args);
    va_end(args);
    t->size += (size_t)length;
}

void sp_text_number(sp_text *t, double value) {
    char text[SP_NUMBER_TEXT];
    sp_text_add(t, "%s", sp_number_text(value, text));
}

void sp_text_free(sp_text *t) {
    sp_free(t->data);
    *t = (sp_text){0};
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

bool sp_word_number(const char *word, double *out) {
    const char *digits = word + (*word == '+' || *word == '-');
    if (!*digits || strpbrk(digits, "xX(") || strchr(" \t\n\v\f\r", *digits))
        return false;
    char *end;
    errno = 0;
    double value = strtod(word, &end);
    if (*end || end == word || (errno == ERANGE && isinf(value)))
        return false;
    *out = value;
    return true;
}

/* Only a sign and digits: refuses what strtoll would skip or stop at. */
static bool plain_integer(const char *word, bool sign) {
    if (sign && (*word == '-' || *word == '+'))
        word++;
    return *word && strspn(word, "0123456789") == strlen(word);
}

bool sp_word_integer(const char *word, int64_t *out) {
    if (!plain_integer(word, true))
        return false;
    errno = 0;
    long long value = strtoll(word, NULL, 10);
    if (errno)
        return false;
    *out = value;
    return true;
}

bool sp_word_unsigned(const char *word, uint64_t *out) {
    if (!plain_integer(word, false))
        return false;
    errno = 0;
    unsigned long long value = strtoull(word, NULL, 10);
    if (errno)
        return false;
    *out = value;
    return true;
}

sp_lines sp_lines_of(const char *file, char *text, size_t size) {
    if (!text)
        return (sp_lines){.file = file};
    size_t mark = size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    return (sp_lines){.file = file, .next = text + mark, .end = text + size};
}

sp_status sp_lines_next(sp_lines *l, char **line, sp_error *err) {
    *line = NULL;
    if (l->next >= l->end)
        return SP_OK;
    l->number++;
    char *start = l->next, *stop = memchr(start, '\n', (size_t)(l->end - start));
    if (!stop)
        stop = l->end;
    if (stop - start > 65536)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: a line of %lld bytes; at most 65536", l->file, (long long)l->number,
                       (long long)(stop - start));
    l->next = stop + 1;
    *stop = '\0';
    while (stop > start && stop[-1] == '\r')
        *--stop = '\0';
    *line = start;
    return SP_OK;
}

sp_status sp_lines_next_data(sp_lines *l, char **line, sp_error *err) {
    for (;;) {
        sp_status status = sp_lines_next(l, line, err);
        if (status != SP_OK || !*line)
            return status;
        const char *first = *line + strspn(*line, " \t");
        if (*first && *first != '#')
            return SP_OK;
    }
}

int sp_line_words(char *line, char **word, int most) {
    int count = 0;
    for (;;) {
        line += strspn(line, " \t");
        if (!*line)
            return count;
        if (count == most)
            return most + 1;
        word[count++] = line;
        line += strcspn(line, " \t");
        if (*line)
            *line++ = '\0';
    }
}
