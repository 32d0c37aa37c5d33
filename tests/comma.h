#ifndef SP_COMMA_H
#define SP_COMMA_H
/* A locale with a decimal comma, made of that of C with two bytes changed, since hardly any machine for tests has one
 * installed. */
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static inline bool comma_write(const char *folder) {
    enum { POINT = 0x20, WIDE = 0x24, SIZE = 256 }; /* places of the decimal point, and of the wide one */
    char bytes[SIZE], path[SIZE];
    FILE *in = fopen("/usr/lib/locale/C.utf8/LC_NUMERIC", "rb");
    const size_t size = in ? fread(bytes, 1, sizeof bytes, in) : 0;
    if (in)
        fclose(in);
    if (size <= WIDE || size == SIZE || bytes[POINT] != '.' || bytes[WIDE] != '.')
        return false;
    bytes[POINT] = bytes[WIDE] = ',';
    snprintf(path, sizeof path, "%s/comma", folder);
    mkdir(path, 0700);
    snprintf(path, sizeof path, "%s/comma/LC_NUMERIC", folder);
    FILE *out = fopen(path, "wb");
    const bool good = out && fwrite(bytes, 1, size, out) == size;
    return out && fclose(out) == 0 && good;
}

/* Sets it, as a host program may; false if this C library has its locales elsewhere. */
static inline bool comma_set(const char *folder) {
    const bool set = comma_write(folder) && setenv("LOCPATH", folder, 1) == 0 && setlocale(LC_NUMERIC, "comma") != NULL;
    return set && strcmp(localeconv()->decimal_point, ",") == 0;
}

#endif
