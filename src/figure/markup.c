/* Writes numbers and user texts as markup. */
#include "figure/markup.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- users' texts --------------------------------------------------------------------------------------------- */

/* Length of the UTF-8 character at s [bytes]; 0 at the end of the text. Invalid bytes have length 1 and set *valid =
 * false. Like cairo and XML, this rejects overlong forms, surrogates and noncharacters. */
static int character(const char *s, bool *valid) {
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *u = (const unsigned char *)s;
    *valid = true;
    if (u[0] < 0x80)
        return u[0] != 0;
    int length = u[0] >= 0xf5 ? 0 : u[0] >= 0xf0 ? 4 : u[0] >= 0xe0 ? 3 : u[0] >= 0xc2 ? 2 : 0;
    uint32_t code = length == 4 ? u[0] & 0x07u : length == 3 ? u[0] & 0x0fu : u[0] & 0x1fu;
    for (int k = 1; k < length; k++) {
        if ((u[k] & 0xc0) != 0x80)
            length = 0;
        code = code << 6 | (u[k] & 0x3fu);
    }
    *valid = length > 0 && code >= least[length] && code < 0x110000 && (code & 0xfffff800u) != 0xd800 &&
             (code < 0xfdd0 || code > 0xfdef) && (code & 0xfffe) != 0xfffe;
    return *valid ? length : 1;
}

void sp_figure_text_escape(char *out, size_t size, const char *raw, int most) {
    int characters = 0;
    bool valid;
    for (const char *s = raw; *s; s += character(s, &valid))
        characters++;
    int head = characters > most ? most / 2 : characters, tail = characters > most ? most - head - 1 : 0;
    size_t n = 0;
    int k = 0;
    for (const char *s = raw; *s && n + 8 < size; k++) {
        int length = character(s, &valid);
        if (k == head && characters > most) {
            memcpy(out + n, "\xe2\x80\xa6", 3);
            n += 3;
        }
        if (k < head || k >= characters - tail) {
            unsigned char first = (unsigned char)*s;
            if (strchr("|_^{}\\", *s))
                out[n++] = '\\';
            if (!valid || first < ' ' || first == 127)
                out[n++] = valid ? ' ' : '?';
            else
                for (int b = 0; b < length; b++)
                    out[n++] = s[b];
        }
        s += length;
    }
    out[n] = '\0';
}

/* ---- numbers -------------------------------------------------------------------------------------------------- */

/* Copies a printed number with a typographic minus. */
static void typeset(char *out, size_t size, const char *number) {
    size_t n = 0;
    for (; *number && n + 4 < size; number++) {
        if (*number == '-') {
            memcpy(out + n, MINUS, 3);
            n += 3;
        } else {
            out[n++] = *number;
        }
    }
    out[n] = '\0';
}

void sp_figure_text_number(char *out, size_t size, double value, int digits) {
    char plain[64], exponent[32], mantissa[64], power[64];
    double magnitude = fabs(value);
    if (!isfinite(value) || value == 0.0 || (magnitude >= 1e-3 && magnitude < 1e5)) {
        snprintf(plain, sizeof plain, "%.*g", digits < 5 && magnitude >= 1e3 ? 5 : digits, value);
        typeset(out, size, plain);
        return;
    }
    snprintf(plain, sizeof plain, "%.*e", digits - 1, value);
    char *e = strchr(plain, 'e');
    *e = '\0';
    snprintf(exponent, sizeof exponent, "%d", atoi(e + 1)); /* without leading zeros */
    for (char *last = e - 1; strchr(plain, '.') && (*last == '0' || *last == '.'); last--) {
        bool point = *last == '.';
        *last = '\0';
        if (point)
            break;
    }
    typeset(mantissa, sizeof mantissa, plain);
    typeset(power, sizeof power, exponent);
    if (strcmp(plain, "1") == 0)
        snprintf(out, size, "10^{%s}", power);
    else
        snprintf(out, size,
                 "%s"
                 "\xc3\x97"
                 "10^{%s}",
                 mantissa, power);
}

void sp_figure_text_measured(char *out, size_t size, double value, double error) {
    char plain[64];
    if (!(error >= 1e-9) || error >= 1.0) {
        snprintf(plain, sizeof plain, fabs(value) < 1e3 ? "%.3f" : "%.3g", value);
    } else {
        int decimals = (int)ceil(-log10(error) - 1e-9);
        double shift = pow(10.0, decimals);
        if (error * shift < 1.95) { /* two digits if the error begins with 1 */
            decimals++;
            shift *= 10.0;
        }
        snprintf(plain, sizeof plain, "%.*f(%.0f)", decimals, value, error * shift);
    }
    typeset(out, size, plain);
}
