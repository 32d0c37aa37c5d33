/* Writes tables to stdout or to files, and decides which files may be replaced. */
#include "cli/cli.h"
#include "cli/ranks.h"

#include "base/base.h"
#include "base/file.h"
#include "packing/geometry.h"
#include "store/packing_text.h"

#include <sonopack/study/modes_file.h>

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- kinds of files ---------------------------------------------------------------------------------------------- */

typedef enum file_kind {
    KIND_UNKNOWN,
    KIND_HDF5,
    KIND_JSON,
    KIND_PACKING /* as text */,
    KIND_MAT,
    KIND_SAC,
    KIND_TEXT,
    KIND_OTHER
} file_kind;

static const struct {
    const char *ending;
    file_kind kind;
} endings[] = {{".h5", KIND_HDF5},    {".hdf5", KIND_HDF5},   {".json", KIND_JSON}, {".tsv", KIND_TEXT},
               {".csv", KIND_TEXT},   {".txt", KIND_PACKING}, {".mat", KIND_MAT},   {".sac", KIND_SAC},
               {".slist", KIND_TEXT}, {".png", KIND_OTHER},   {".pdf", KIND_OTHER}, {".svg", KIND_OTHER},
               {".html", KIND_OTHER}, {".vtp", KIND_OTHER},   {".xyz", KIND_OTHER}, {".dump", KIND_OTHER}};

static const char *ending_of(const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    return dot && dot > name ? dot : "";
}

bool cli_has_ending(const char *path, const char *ending) { return strcasecmp(ending_of(path), ending) == 0; }

bool cli_is_foreign_table(const char *path) {
    return cli_has_ending(path, ".mat") || cli_has_ending(path, ".sac") || cli_has_ending(path, ".slist");
}

static file_kind kind_by_ending(const char *path) {
    for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
        if (cli_has_ending(path, endings[k].ending))
            return endings[k].kind;
    return KIND_UNKNOWN;
}

/* A SAC file has no signature, but a version at byte 304, in either byte order. */
static bool is_sac(const char *head, size_t size) {
    return size >= 632 && (memcmp(head + 304, "\6\0\0\0", 4) == 0 || memcmp(head + 304, "\0\0\0\6", 4) == 0);
}

/* head[size] must be 0. */
static file_kind kind_by_content(const char *head, size_t size) {
    static const struct {
        const char *magic;
        file_kind kind;
    } magics[] = {{"\211HDF\r\n\032\n", KIND_HDF5}, {"%PDF-", KIND_OTHER}, {"MATLAB 5", KIND_MAT}};
    for (size_t k = 0; k < sizeof magics / sizeof *magics; k++)
        if (size >= strlen(magics[k].magic) && memcmp(head, magics[k].magic, strlen(magics[k].magic)) == 0)
            return magics[k].kind;
    if (memchr(head, 0, size))
        return is_sac(head, size) ? KIND_SAC : KIND_UNKNOWN;
    if (sp_packing_text_looks(head))
        return KIND_PACKING;
    size_t first = 0;
    while (first < size && isspace((unsigned char)head[first]))
        first++;
    const char c = head[first];
    return c == '<' ? KIND_OTHER : c == '{' || c == '[' ? KIND_JSON : KIND_TEXT;
}

/* Checks that an existing file is of the kind that its name says. */
static sp_status check_kind(const char *path, file_kind kind, sp_error *err) {
    char head[4096];
    FILE *file = fopen(path, "rb");
    if (!file)
        return sp_fail(err, SP_EIO, "%s: %s", path, strerror(errno));
    const size_t size = fread(head, 1, sizeof head - 1, file);
    const bool failed = ferror(file);
    fclose(file);
    head[size] = '\0';
    if (failed)
        return sp_fail(err, SP_EIO, "%s: cannot be read", path);
    if (size > 0 && kind_by_content(head, size) != kind)
        return sp_fail(err, SP_EINVAL,
                       "%s: is a file of another kind than its ending says, and is not replaced: choose another name",
                       path);
    return SP_OK;
}

bool cli_is_hdf5(const char *path) { return cli_has_ending(path, ".h5") || cli_has_ending(path, ".hdf5"); }

/* HDF5 holds packings, or modes. */
static sp_status check_hdf5(const char *path, bool modes, sp_error *err) {
    if (sp_modes_file_looks(path) == modes)
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "%s: is %s, and is not replaced: choose another name", path,
                   modes ? "no file of modes" : "a file of modes");
}

static sp_status may_write(const cli_common *common, const char *path, bool modes, sp_error *err) {
    file_kind kind = kind_by_ending(path);
    struct stat info;
    if (path[0] == '\0')
        return sp_fail(err, SP_EINVAL, "-o: the file name is empty");
    const bool exists = stat(path, &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        return sp_fail(err, SP_EINVAL, "%s: is a folder, must be a file", path);
    if (exists && !S_ISREG(info.st_mode))
        return SP_OK; /* a device or a pipe */
    if (kind == KIND_UNKNOWN && common->format_given)
        kind = common->format == SP_JSON ? KIND_JSON : KIND_TEXT;
    if (kind == KIND_UNKNOWN)
        return sp_fail(err, SP_EINVAL,
                       "%s: unknown ending \"%s\": must be .tsv, .csv or .json for a table, .h5 or .txt for a packing",
                       path, ending_of(path));
    if (exists) {
        sp_status status = check_kind(path, kind, err);
        if (status == SP_OK && info.st_size > 0 && kind == KIND_HDF5)
            status = check_hdf5(path, modes, err);
        if (status == SP_OK && !common->force)
            status = sp_fail(err, SP_EINVAL, "%s: exists already: choose another name, or use --force", path);
        if (status != SP_OK)
            return status;
    }
    char folder[SP_PATH_MAX];
    const char *slash = strrchr(path, '/');
    const int length = slash ? (int)(slash - path) + 1 : 1;
    if (length >= SP_PATH_MAX)
        return sp_fail(err, SP_EINVAL, "-o: the file name has %zu bytes, must have fewer than %d", strlen(path),
                       SP_PATH_MAX);
    snprintf(folder, sizeof folder, "%.*s", length, slash ? path : ".");
    if (!common->dry_run)
        return sp_file_probe(path, err);
    if (access(folder, W_OK) == 0)
        return SP_OK;
    return sp_fail(err, SP_EIO, "cannot write in %s: %s", folder, strerror(errno));
}

sp_status cli_may_write(const cli_common *common, const char *path, sp_error *err) {
    return may_write(common, path, false, err);
}

sp_status cli_may_write_packing(const cli_common *common, const char *option, const char *path, sp_error *err) {
    if (!cli_has_ending(path, ".txt") && !cli_is_hdf5(path))
        return sp_fail(err, SP_EINVAL, "%s %.200s: the ending of a packing must be .h5 or .txt", option, path);
    return cli_may_write(common, path, err);
}

sp_status cli_save_packing(const sp_packing *p, const char *path, sp_error *err) {
    return cli_has_ending(path, ".txt") ? sp_packing_save_text(p, path, err) : sp_packing_save(p, path, err);
}

sp_status cli_may_write_modes(const cli_common *common, const char *path, sp_error *err) {
    return may_write(common, path, true, err);
}

sp_status cli_load_start(sp_scene *scene, sp_packing *from, sp_error *err) {
    sp_status status = sp_packing_read(scene->from, from, err);
    if (status != SP_OK)
        return sp_fail_prefix(err, "packing.file");
    if (!(scene->material.young > 0))
        scene->material = from->material;
    return sp_pack_spec_from(&scene->pack, from, err);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static sp_status table_format(const cli_common *common, sp_table_format *out, sp_error *err) {
    static const char *const names[] = {[SP_TSV] = ".tsv", [SP_CSV] = ".csv", [SP_JSON] = ".json"};
    *out = common->format;
    if (!common->output)
        return SP_OK;
    if (cli_is_foreign_table(common->output) && !common->format_given)
        return cli_may_save_foreign(err);
    for (unsigned k = 0; k < sizeof names / sizeof *names; k++) {
        if (!cli_has_ending(common->output, names[k]))
            continue;
        if (common->format_given && common->format != (sp_table_format)k)
            return sp_fail(err, SP_EINVAL, "-o %s: --format asks for the ending %s", common->output,
                           names[common->format]);
        *out = (sp_table_format)k;
        return SP_OK;
    }
    if (kind_by_ending(common->output) != KIND_UNKNOWN || !common->format_given)
        return sp_fail(err, SP_EINVAL,
                       "-o %s: the ending of a table must be .tsv, .csv, .json or .mat, of signals also .sac or .slist",
                       common->output);
    return SP_OK;
}

sp_status cli_may_write_table(const cli_common *common, sp_error *err) {
    sp_table_format format;
    sp_status status = table_format(common, &format, err);
    return status == SP_OK && common->output ? cli_may_write(common, common->output, err) : status;
}

static bool output_failed; /* and the failure has been reported */

/* A terminal obeys control characters, which names of files and texts in files may have; a file gets them as they are.
 */
static bool put(const char *text) {
    char *tame = isatty(STDOUT_FILENO) ? sp_strdup(text) : NULL;
    if (tame)
        sp_text_tame(tame, "\n\t");
    const size_t size = strlen(text);
    const bool done = fwrite(tame ? tame : text, 1, size, stdout) == size && fflush(stdout) == 0;
    sp_free(tame);
    return done;
}

sp_status cli_print(const char *text, sp_error *err) {
    cli_watch_end();
    if (put(text))
        return SP_OK;
    output_failed = true;
    return sp_fail(err, SP_EIO, "standard output: %s", strerror(errno));
}

sp_status cli_write_table_to(const cli_common *to, const char *path, sp_table *t, sp_error *err) {
    cli_common there = *to;
    there.output = path;
    return cli_write_table(&there, t, err);
}

/* Somebody reads the standard output. OpenMPI gives the ranks of mpirun terminals of its own. */
static bool is_read(void) { return isatty(STDOUT_FILENO) && !cli_launch_of_environment().mpi; }

sp_status cli_write_table(const cli_common *common, sp_table *t, sp_error *err) {
    sp_table_format format;
    sp_status status = table_format(common, &format, err);
    CLI_THEN(status, sp_table_add_comment(t, err, "sonopack %s", SONOPACK_VERSION));
    CLI_THEN(status, cli_convert_table(common, t, err));
    if (status != SP_OK)
        return status;
    const bool foreign = common->output && cli_is_foreign_table(common->output);
    const bool shown = !common->output && !common->format_given && is_read();
    char *text = shown ? sp_table_aligned(t, common->digits) : sp_table_text(t, foreign ? SP_TSV : format);
    if (!text)
        return sp_fail_memory(err, (size_t)(t->rows * t->columns) * 24);
    status = foreign          ? cli_save_foreign(common, text, err)
             : common->output ? sp_text_save(common->output, text, strlen(text), err)
                              : cli_print(text, err);
    sp_free(text);
    return status;
}

void cli_close_stdout(void) {
    const bool before = ferror(stdout) != 0;
    cli_watch_end();
    errno = 0;
    if (fclose(stdout) == 0 && !before)
        return;
    if (!output_failed) {
        fputs("sonopack: standard output: ", stderr);
        fputs(errno ? strerror(errno) : "could not be written", stderr);
        fputc('\n', stderr);
    }
    _exit(CLI_FAILED);
}

void cli_columns(cli_writer *w, sp_column_kind kind, ...) {
    va_list list;
    va_start(list, kind);
    for (const char *name; w->status == SP_OK && (name = va_arg(list, const char *)) != NULL;)
        w->status = sp_table_add_column(w->table, name, va_arg(list, const char *), kind, w->err);
    va_end(list);
}

void cli_place_columns(cli_writer *w, int dim) {
    static const char *const axes[] = {"x", "y", "z"};
    for (int a = 0; a < dim; a++)
        cli_columns(w, SP_COLUMN_NUMBER, axes[a], "d", NULL);
}

void cli_comment(cli_writer *w, const char *format, ...) {
    char line[2048]; /* as sp_table_add_comment has */
    va_list list;
    va_start(list, format);
    vsnprintf(line, sizeof line, format, list);
    va_end(list);
    CLI_THEN(w->status, sp_table_add_comment(w->table, w->err, "%s", line));
}

void cli_value(cli_writer *w, const char *key, double value) {
    char number[SP_NUMBER_TEXT];
    cli_comment(w, "%s = %s", key, sp_number_text(value, number));
}

void cli_quantity_columns(cli_writer *w, const sp_quantity *all, const char *symbols) {
    const sp_quantity *q;
    while ((q = sp_quantity_next(all, &symbols)))
        cli_columns(w, SP_COLUMN_NUMBER, q->symbol, q->unit, NULL);
}

void cli_put_numbers(cli_writer *w, int n, const double *number) {
    for (int k = 0; k < n && w->status == SP_OK; k++) {
        sp_entry *cell = &w->cell[w->cells];
        if (w->table->column[w->cells++].kind == SP_COLUMN_INTEGER)
            cell->integer = (int64_t)number[k];
        else
            cell->number = number[k];
    }
}

void cli_put_text(cli_writer *w, const char *text) {
    if (w->status == SP_OK)
        w->cell[w->cells++].text = (char *)text;
}

void cli_put_quantities(cli_writer *w, const sp_quantity *all, const char *symbols, const void *of) {
    const sp_quantity *q;
    while ((q = sp_quantity_next(all, &symbols)))
        cli_put(w, sp_quantity_value(q, of));
}

bool cli_lacks_series(const sp_table *t, const sp_packing *p) {
    bool lacks = sp_table_find_column(t, "frame") < 0;
    for (int k = 0; k < SP_SERIES_STRAINS; k++)
        lacks = lacks || (!isnan(p->strain[k]) && sp_table_find_column(t, sp_strain_names[k]) < 0);
    return lacks && !isnan(p->frame);
}

/* Frame and strain of the packing, if that of the first row has them. */
static void put_series(cli_writer *w) {
    if (!w->of || w->status != SP_OK || strcmp(w->table->column[0].name, "file") != 0)
        return;
    if (w->table->rows == 0 && !isnan(w->of->frame)) {
        cli_columns(w, SP_COLUMN_NUMBER, "frame", "", NULL);
        for (int k = 0; k < SP_SERIES_STRAINS; k++)
            if (!isnan(w->of->strain[k]))
                cli_columns(w, SP_COLUMN_NUMBER, sp_strain_names[k], "", NULL);
    }
    if (sp_table_find_column(w->table, "frame") < 0)
        return;
    cli_put(w, w->of->frame);
    for (int k = 0; k < SP_SERIES_STRAINS; k++)
        if (sp_table_find_column(w->table, sp_strain_names[k]) >= 0)
            cli_put(w, isnan(w->of->frame) ? NAN : w->of->strain[k]);
}

void cli_end_row(cli_writer *w) {
    put_series(w);
    CLI_THEN(w->status, sp_table_add_cells(w->table, w->cell, w->err));
    w->cells = 0;
}

sp_status cli_row(cli_writer *w, ...) {
    va_list list;
    va_start(list, w);
    const int series = sp_table_find_column(w->table, "frame"), columns = series < 0 ? w->table->columns : series;
    for (int c = 0; w->status == SP_OK && c < columns; c++)
        switch (w->table->column[c].kind) {
        case SP_COLUMN_INTEGER: w->cell[c].integer = va_arg(list, int64_t); break;
        case SP_COLUMN_NUMBER: w->cell[c].number = va_arg(list, double); break;
        case SP_COLUMN_TEXT: w->cell[c].text = va_arg(list, char *); break;
        }
    va_end(list);
    w->cells = columns;
    cli_end_row(w);
    return w->status;
}
