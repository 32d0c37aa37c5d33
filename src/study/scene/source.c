/* Loads the text of a scene, and rewrites what libconfig would misread. */
#include "scene/source.h"

#include "base/base.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_BYTES = 32 << 20, MAX_DEPTH = 32, MAX_SETTINGS = 10000 };

sp_status sp_source_load(const char *path, const char *what, char **text, sp_error *err) {
    sp_status status = SP_OK;
    char *data = NULL;
    size_t size = 0, capacity = 1 << 16;
    FILE *file = fopen(path, "rb");
    if (!file)
        return sp_fail(err, SP_EINVAL, "%s: %s", path, strerror(errno));
    for (;;) { /* a pipe has no known size */
        char *more = sp_alloc(capacity + 1, 1);
        if (!more) {
            status = sp_fail_memory(err, capacity);
            goto out;
        }
        if (size > 0)
            memcpy(more, data, size);
        sp_free(data);
        data = more;
        size += fread(data + size, 1, capacity - size, file);
        if (ferror(file)) {
            status = sp_fail(err, SP_EINVAL, "%s: %s", path, strerror(errno));
            goto out;
        }
        if (size < capacity)
            break;
        if (capacity >= MAX_BYTES) {
            status =
                sp_fail(err, SP_EINVAL, "%s: too large for a %s: must be below %d MB", path, what, MAX_BYTES >> 20);
            goto out;
        }
        capacity *= 2;
    }
    if (memchr(data, 0, size)) {
        status = sp_fail(err, SP_EINVAL, "%s: binary data, not a %s: must be text", path, what);
        goto out;
    }
    *text = data;
    data = NULL;
out:
    sp_free(data);
    fclose(file);
    return status;
}

typedef struct scanner {
    const char *at;
    char *to;
    const char *name;
    int line, depth, settings;
    char open[MAX_DEPTH]; /* brackets that are not closed yet */
    char last;            /* first letter of the last token, comments and blanks aside */
    sp_error *err;
} scanner;

static sp_status fault(const scanner *s, int line, const char *what) {
    return sp_fail(s->err, SP_EINVAL, "%s:%d: %s", s->name, line, what);
}

static void copy(scanner *s) {
    s->line += *s->at == '\n';
    *s->to++ = *s->at++;
}

/* libconfig leaks a string where it does not expect one. Such strings are therefore refused here. */
static bool may_be_string(const scanner *s) {
    const bool in_list = s->depth > 0 && s->open[s->depth - 1] != '{';
    return s->last && (strchr("=:([\"", s->last) || (s->last == ',' && in_list));
}

static sp_status copy_string(scanner *s) {
    const int begun = s->line;
    if (!may_be_string(s))
        return fault(s, begun, "syntax error: a string must follow = or stand in a list");
    copy(s);
    while (*s->at && *s->at != '"') {
        if (s->at[0] == '\\' && s->at[1])
            copy(s);
        copy(s);
    }
    if (!*s->at)
        return fault(s, begun, "a string without end begins here: must be closed with \"");
    copy(s);
    return SP_OK;
}

static sp_status copy_block_comment(scanner *s) {
    const int begun = s->line;
    copy(s);
    copy(s);
    while (*s->at && !(s->at[0] == '*' && s->at[1] == '/'))
        copy(s);
    if (!*s->at)
        return fault(s, begun, "a comment without end begins here: must be closed");
    copy(s);
    copy(s);
    return SP_OK;
}

/* Copies what begins like a number, and appends L to an integer. Other numbers are left to libconfig. */
static sp_status copy_number(scanner *s) {
    char run[80];
    size_t n = strspn(s->at, "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_.+-");
    snprintf(run, sizeof run, "%.*s", (int)(n < sizeof run ? n : sizeof run - 1), s->at);
    memcpy(s->to, s->at, n);
    s->at += n;
    s->to += n;
    const bool hex = run[0] == '0' && (run[1] == 'x' || run[1] == 'X');
    char *end = NULL;
    errno = 0;
    if (hex)
        (void)strtoull(run, &end, 16);
    else
        (void)strtoll(run, &end, 10);
    const bool integer = end > run && (*end == '\0' || strcmp(end, "L") == 0 || strcmp(end, "LL") == 0);
    if (n < sizeof run && !integer)
        return SP_OK;
    if (n >= sizeof run || errno == ERANGE) {
        if (n > 40)
            snprintf(run + 37, sizeof run - 37, "...");
        char what[160];
        snprintf(what, sizeof what, "number %s: must fit into 64 bits", run);
        return fault(s, s->line, what);
    }
    if (*end == '\0')
        *s->to++ = 'L';
    return SP_OK;
}

static sp_status copy_structure(scanner *s) {
    const char c = *s->at;
    if ((c == '=' || c == ':') && ++s->settings > MAX_SETTINGS)
        return fault(s, s->line, "too many settings: a scene has fewer than a hundred");
    copy(s);
    if (strchr("({[", c)) {
        if (s->depth == MAX_DEPTH)
            return fault(s, s->line, "nested too deep: a scene has four levels");
        s->open[s->depth++] = c;
        s->to[-1] = c == '[' ? '(' : c;
    } else if (strchr(")}]", c)) {
        const char opened = s->depth > 0 ? s->open[--s->depth] : '\0';
        if (c == ']' && opened == '[')
            s->to[-1] = ')';
        else if (c == ')' && opened == '[')
            s->to[-1] = ']'; /* brackets that do not match are left to libconfig, which refuses them */
    }
    return SP_OK;
}

static sp_status copy_token(scanner *s) {
    const unsigned char c = (unsigned char)*s->at, next = (unsigned char)s->at[1];
    if (c == '"')
        return copy_string(s);
    if (c == '/' && next == '*')
        return copy_block_comment(s);
    if (c == '#' || (c == '/' && next == '/')) {
        while (*s->at && *s->at != '\n')
            copy(s);
        return SP_OK;
    }
    if (isalpha(c) || c == '*') {
        do
            copy(s);
        while (isalnum((unsigned char)*s->at) || (*s->at && strchr("-_*", *s->at)));
        return SP_OK;
    }
    if (isdigit(c) || (c == '.' && isdigit(next)) || ((c == '-' || c == '+') && (isdigit(next) || next == '.')))
        return copy_number(s);
    return copy_structure(s);
}

/* libconfig allows @include at the beginning of a line only. It is refused everywhere, even in comments. */
static sp_status refuse_include(const scanner *s) {
    int number = 1;
    for (const char *line = s->at; line; number++) {
        if (strncmp(line + strspn(line, " \t\r\f\v"), "@include", 8) == 0)
            return fault(s, number, "@include is not supported: a scene must be one file");
        const char *end = strchr(line, '\n');
        line = end ? end + 1 : NULL;
    }
    return SP_OK;
}

sp_status sp_source_clean(const char *text, const char *name, char **clean, sp_error *err) {
    if (strncmp(text, "\xef\xbb\xbf", 3) == 0) /* the byte order mark of some editors */
        text += 3;
    const size_t size = strlen(text);
    char *copied = sp_alloc(2 * size + 2, 1); /* at worst, every second character is an integer */
    if (!copied)
        return sp_fail_memory(err, 2 * size);
    scanner s = {.at = text, .to = copied, .name = name, .line = 1, .err = err};
    sp_status status = refuse_include(&s);
    bool comment = false;
    while (status == SP_OK && *s.at) {
        const char first = *s.at;
        comment = first == '#' || (first == '/' && (s.at[1] == '/' || s.at[1] == '*'));
        status = copy_token(&s);
        s.last = comment || isspace((unsigned char)first) ? s.last : first;
    }
    if (status != SP_OK) {
        sp_free(copied);
        return status;
    }
    if (comment) /* libconfig refuses a comment without a new line at the end of the text */
        *s.to = '\n';
    *clean = copied;
    return SP_OK;
}
