/* Recognises the form of a file, and calls its reader. */
#include "foreign/forms.h"

#include "base/base.h"
#include "base/file.h"
#include "base/text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const sp_form_names[] = {[SP_FORM_AUTO] = "auto",
                                     [SP_FORM_LAMMPS_DATA] = "lammps-data",
                                     [SP_FORM_LAMMPS_DUMP] = "lammps-dump",
                                     [SP_FORM_LIGGGHTS] = "liggghts",
                                     [SP_FORM_YADE] = "yade",
                                     [SP_FORM_MERCURY] = "mercury",
                                     [SP_FORM_XYZ] = "xyz",
                                     [SP_FORM_CSV] = "csv",
                                     [SP_FORM_PHOTOELASTIC] = "photoelastic",
                                     NULL};

static bool contains(const char *line, size_t length, const char *text) {
    const size_t n = strlen(text);
    for (size_t k = 0; k + n <= length; k++)
        if (memcmp(line + k, text, n) == 0)
            return true;
    return false;
}

/* ---- recognition ----------------------------------------------------------------------------------------------- */

static bool all_numbers(const char *line, size_t length, int *count) {
    char word[SP_SHEET_NAME];
    double value;
    const char *from = line;
    for (*count = 0; sp_next_cell(&from, line + length, ' ', word); ++*count)
        if (!sp_word_number(word, &value))
            return false;
    return *count > 0;
}

/* Our text form begins with a header that has N, Lx and p. */
static bool is_ours(const char *line, size_t length) {
    return sp_begins(line, length, "\211HDF") ||
           (sp_begins(line, length, "N ") && contains(line, length, " Lx ") && contains(line, length, " mu "));
}

static bool has_column(const char *line, size_t length, char separator, const char *name) {
    char word[SP_SHEET_NAME];
    const char *from = line;
    while (sp_next_cell(&from, line + length, separator, word))
        if (strcmp(word, name) == 0)
            return true;
    return false;
}

static sp_form form_of_header(const char *line, size_t length) {
    if (contains(line, length, ",")) {
        const bool frames = has_column(line, length, ',', "frame") && has_column(line, length, ',', "radius");
        return frames && has_column(line, length, ',', "boundary") ? SP_FORM_PHOTOELASTIC : SP_FORM_CSV;
    }
    char word[SP_SHEET_NAME];
    double value;
    const char *from = line;
    const bool named = sp_next_cell(&from, line + length, ' ', word) && !sp_word_number(word, &value);
    return named && has_column(line, length, ' ', "x") ? SP_FORM_CSV : SP_FORM_AUTO;
}

/* The form by the first lines. */
static sp_form form_of_text(const char *text, size_t size) {
    sp_cursor at = {.next = text, .end = text + size};
    size_t length, second;
    const char *line = sp_cursor_words(&at, &length);
    int count;
    while (line && sp_begins(line, length, "#") && !sp_begins(line, length, "#format")) {
        if (sp_begins(line, length, "# packing"))
            return SP_FORM_OURS;
        if (at.number == 1) { /* the first line of LAMMPS data is a comment of any kind */
            sp_cursor ahead = at;
            const char *counts = sp_cursor_words(&ahead, &second);
            if (counts && contains(counts, second, " atoms"))
                return SP_FORM_LAMMPS_DATA;
        }
        line = sp_cursor_words(&at, &length);
    }
    if (!line)
        return SP_FORM_AUTO;
    if (is_ours(line, length))
        return SP_FORM_OURS;
    if (sp_begins(line, length, "ITEM:"))
        return SP_FORM_LAMMPS_DUMP;
    if (sp_begins(line, length, "#format"))
        return SP_FORM_YADE;
    const bool numbers = all_numbers(line, length, &count);
    const char *next = sp_cursor_line(&at, &second);
    if (numbers && count == 1 && next && (contains(next, second, "Lattice=") || contains(next, second, "Properties=")))
        return SP_FORM_XYZ;
    if (numbers && (count == 8 || count == 6) && next && all_numbers(next, second, &count) &&
        (count == 14 || count == 8))
        return SP_FORM_MERCURY;
    for (sp_cursor ahead = {.next = line, .end = text + size}; next; next = sp_cursor_words(&ahead, &second))
        if (contains(next, second, " atoms") || contains(next, second, " xlo xhi"))
            return SP_FORM_LAMMPS_DATA;
        else if (ahead.number > 40)
            break;
    return form_of_header(line, length);
}

sp_status sp_form_of_file(const char *path, sp_form *out, sp_error *err) {
    char start[8192];
    FILE *file = fopen(path, "rb");
    if (!file)
        return sp_fail(err, SP_EIO, "%s: cannot be opened", path);
    const size_t size = fread(start, 1, sizeof start - 1, file);
    fclose(file);
    start[size] = '\0';
    sp_locale locale = sp_locale_enter();
    *out = size >= 8 && memcmp(start, "\211HDF\r\n\032\n", 8) == 0 ? SP_FORM_OURS : form_of_text(start, size);
    sp_locale_leave(&locale);
    return SP_OK;
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

static sp_form_reader *reader_of(sp_form form, bool contacts) {
    switch (form) {
    case SP_FORM_LAMMPS_DATA: return sp_read_lammps_data;
    case SP_FORM_LAMMPS_DUMP:
    case SP_FORM_LIGGGHTS: return sp_read_dump;
    case SP_FORM_YADE: return sp_read_yade;
    case SP_FORM_MERCURY: return contacts ? sp_read_mercury_fstat : sp_read_mercury_data;
    case SP_FORM_XYZ: return sp_read_xyz;
    default: return sp_read_table;
    }
}

/* Contacts are in a dump or a table, whatever the form of the grains. */
static sp_status form_of_contacts(const char *path, sp_form *form, sp_error *err) {
    sp_form found;
    sp_status status = sp_form_of_file(path, &found, err);
    if (status == SP_OK && *form != SP_FORM_MERCURY)
        *form = found == SP_FORM_LAMMPS_DUMP ? SP_FORM_LAMMPS_DUMP : SP_FORM_CSV;
    return status;
}

sp_status sp_read_form(const char *path, sp_form form, bool contacts, sp_frame_choice frame, sp_number_sheet *s,
                       sp_error *err) {
    sp_cursor at;
    sp_status status = contacts ? form_of_contacts(path, &form, err) : SP_OK;
    *s = (sp_number_sheet){0};
    if (status == SP_OK)
        status = sp_sheet_open(path, s, &at, err);
    if (status == SP_OK)
        status = reader_of(form, contacts)(s, &at, frame, err);
    if (status != SP_OK)
        sp_sheet_free(s);
    return status;
}
