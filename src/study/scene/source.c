/* Loads the text of a scene, and hands it to libconfig. */
#include "scene/source.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_BYTES = 32 << 20, MAX_SETTINGS = 10000 };

sp_status sp_source_load(const char *path, const char *what, char **text, sp_error *err) {
    size_t size = 0;
    sp_error why = {0};
    sp_status status = sp_file_read_text(path, text, &size, &why);
    if (status != SP_OK)
        return sp_fail(err, status == SP_ENOMEM ? status : SP_EINVAL, "%s", why.text);
    if (size < MAX_BYTES)
        return SP_OK;
    sp_free(*text);
    return sp_fail(err, SP_EINVAL, "%s: too large for a %s: must be below %d MB", path, what, MAX_BYTES >> 20);
}

typedef struct scanner {
    const char *at;
    sp_text to;
    int line, settings;
} scanner;

static void copy(scanner *s, size_t count) {
    for (size_t k = 0; k < count; k++)
        s->line += s->at[k] == '\n';
    sp_text_bytes(&s->to, s->at, count);
    s->at += count;
}

/* Copies what begins like a number. libconfig cuts integers without the suffix L to 32 bits, and others to 64. */
static const char *copy_number(scanner *s) {
    const size_t n = strspn(s->at, "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_.+-");
    const bool hex = s->at[0] == '0' && (s->at[1] == 'x' || s->at[1] == 'X');
    char *end = NULL;
    errno = 0;
    if (hex)
        (void)strtoull(s->at, &end, 16);
    else
        (void)strtoll(s->at, &end, 10);
    const size_t rest = n - (size_t)(end - s->at);
    const bool integer = end > s->at && (rest == 0 || (rest <= 2 && strspn(end, "L") == rest));
    if (integer && errno == ERANGE)
        return "a number must fit into 64 bits";
    copy(s, n);
    if (integer && rest == 0)
        sp_text_add(&s->to, "L");
    return NULL;
}

static const char *copy_string(scanner *s) {
    size_t n = 1;
    while (s->at[n] && s->at[n] != '"')
        n += s->at[n] == '\\' && s->at[n + 1] ? 2 : 1;
    if (!s->at[n])
        return "a string without end begins here: must be closed with \"";
    copy(s, n + 1);
    return NULL;
}

/* Leaves out a comment but for its new lines. */
static const char *skip_comment(scanner *s) {
    const char *end = s->at[1] == '*' ? strstr(s->at + 2, "*/") : s->at + strcspn(s->at, "\n");
    if (!end)
        return "a comment without end begins here: must be closed";
    end += s->at[1] == '*' && *s->at == '/' ? 2 : 0;
    for (; s->at < end; s->at++)
        if (*s->at == '\n')
            copy(s, 1), s->at--;
    return NULL;
}

/* libconfig's arrays cannot mix 1 and 0.5: they become lists. */
static const char *copy_structure(scanner *s) {
    const char c = *s->at, to = c == '[' ? '(' : c == ']' ? ')' : c;
    if (c == '@')
        return "@include is not supported: a scene must be one file";
    if ((c == '=' || c == ':') && ++s->settings > MAX_SETTINGS)
        return "too many settings: a scene has fewer than a hundred";
    s->line += c == '\n';
    sp_text_bytes(&s->to, &to, 1);
    s->at++;
    return NULL;
}

/* What is wrong with the next token; NULL: nothing. */
static const char *copy_token(scanner *s) {
    const unsigned char c = (unsigned char)*s->at, next = (unsigned char)s->at[1];
    if (c == '"')
        return copy_string(s);
    if (c == '#' || (c == '/' && (next == '/' || next == '*')))
        return skip_comment(s);
    if (isalpha(c) || c == '*')
        copy(s, strspn(s->at, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_*"));
    else if (isdigit(c) || ((c == '-' || c == '+') && isdigit(next)))
        return copy_number(s);
    else
        return copy_structure(s);
    return NULL;
}

sp_status sp_source_parse(const char *text, const char *name, config_t *out, sp_error *err) {
    scanner s = {.at = text + (strncmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0),
                 .line = 1}; /* the mark of some editors */
    const char *fault = NULL;
    while (*s.at && !fault)
        fault = copy_token(&s);
    sp_text_add(&s.to, "%s", "");
    sp_status status = SP_OK;
    if (fault)
        status = sp_fail(err, SP_EINVAL, "%s:%d: %s", name, s.line, fault);
    else if (s.to.failed)
        status = sp_fail_memory(err, s.to.capacity);
    else if (!config_read_string(out, s.to.data))
        status = sp_fail(err, SP_EINVAL, "%s:%d: %s", name, config_error_line(out), config_error_text(out));
    sp_text_free(&s.to);
    return status;
}
