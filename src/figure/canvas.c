/* Opens a canvas for PNG, SVG or PDF and writes its file. */
#include "figure/canvas.h"

#include "base/base.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <errno.h>
#include <sonopack/study/store.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#define DPI 300.0

/* ---- bytes in memory ------------------------------------------------------------------------------------------ */

static void bytes_add(bytes *b, const void *data, size_t size) {
    if (b->failed)
        return;
    if (size > b->capacity - b->size) {
        size_t capacity = 2 * (b->size + size) + 4096;
        char *grown = sp_alloc(capacity, 1);
        if (!grown) {
            b->failed = 1;
            return;
        }
        if (b->size > 0)
            memcpy(grown, b->data, b->size);
        sp_free(b->data);
        b->data = grown;
        b->capacity = capacity;
    }
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void bytes_text(bytes *b, const char *text) { bytes_add(b, text, strlen(text)); }

static void bytes_free(bytes *b) {
    sp_free(b->data);
    *b = (bytes){0};
}

static cairo_status_t take(void *closure, const unsigned char *data, unsigned int length) {
    bytes *b = closure;
    bytes_add(b, data, length);
    return b->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

/* ---- where it goes -------------------------------------------------------------------------------------------- */

static const char *const endings[] = {[CANVAS_PNG] = ".png", [CANVAS_SVG] = ".svg", [CANVAS_PDF] = ".pdf"};

static sp_status kind_of(const char *path, canvas_kind *kind, sp_error *err) {
    size_t length = strlen(path);
    for (int k = 0; k < 3; k++) {
        size_t e = strlen(endings[k]);
        if (length > e && path[length - e - 1] != '/' && strcasecmp(path + length - e, endings[k]) == 0) {
            *kind = (canvas_kind)k;
            return SP_OK;
        }
    }
    return sp_fail(err, SP_EINVAL, "%s: a figure's name ends in .png, .svg or .pdf", *path ? path : "(no name)");
}

sp_status sp_canvas_check(const char *path, sp_error *err) {
    canvas_kind kind;
    if (!path)
        return sp_fail(err, SP_EINVAL, "a figure needs a file name that ends in .png, .svg or .pdf");
    sp_status status = kind_of(path, &kind, err);
    if (status != SP_OK)
        return status;
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return sp_fail(err, SP_EIO, "%s: not a plain file, a figure does not replace it", path);
    char *folder = sp_strdup(path);
    if (!folder)
        return sp_fail_memory(err, strlen(path) + 1);
    char *slash = strrchr(folder, '/');
    if (slash)
        slash[slash == folder] = '\0';
    const char *where = slash ? folder : ".";
    if (stat(where, &info) != 0)
        status = sp_fail(err, SP_EIO, "%s: folder %s: %s", path, where, strerror(errno));
    else if (!S_ISDIR(info.st_mode))
        status = sp_fail(err, SP_EIO, "%s: %s is not a folder", path, where);
    else if (access(where, W_OK | X_OK) != 0)
        status = sp_fail(err, SP_EIO, "%s: folder %s may not be written to: %s", path, where, strerror(errno));
    sp_free(folder);
    return status;
}

/* ---- drawing -------------------------------------------------------------------------------------------------- */

static sp_status cairo_failed(const canvas *c, cairo_status_t status, sp_error *err) {
    if (status == CAIRO_STATUS_NO_MEMORY)
        return sp_fail(err, SP_ENOMEM, "%s: no memory for the figure", c->path);
    return sp_fail(err, SP_EFAILED, "%s: drawing failed: %s", c->path, cairo_status_to_string(status));
}

static void open_surface(canvas *c) {
    switch (c->kind) {
    case CANVAS_PNG:
        c->surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)(c->width * DPI / 72.0 + 0.5),
                                                (int)(c->height * DPI / 72.0 + 0.5));
        break;
    case CANVAS_SVG: c->surface = cairo_svg_surface_create_for_stream(take, &c->file, c->width, c->height); break;
    case CANVAS_PDF:
        c->surface = cairo_pdf_surface_create_for_stream(take, &c->file, c->width, c->height);
        cairo_pdf_surface_set_metadata(c->surface, CAIRO_PDF_METADATA_TITLE, c->title);
        cairo_pdf_surface_set_metadata(c->surface, CAIRO_PDF_METADATA_CREATE_DATE, "");
        break;
    }
}

sp_status sp_canvas_open(canvas *c, const char *path, const char *title, double width, double height, sp_error *err) {
    *c = (canvas){.path = path, .title = title, .width = width, .height = height};
    c->plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!c->plain)
        return sp_fail_memory(err, 0);
    c->before = uselocale(c->plain);
    sp_status status = kind_of(path, &c->kind, err);
    if (status != SP_OK)
        return status;
    open_surface(c);
    if (cairo_surface_status(c->surface) != CAIRO_STATUS_SUCCESS)
        return cairo_failed(c, cairo_surface_status(c->surface), err);
    c->cr = cairo_create(c->surface);
    if (c->kind == CANVAS_PNG)
        cairo_scale(c->cr, DPI / 72.0, DPI / 72.0);
    /* the same text metrics in all three formats */
    cairo_font_options_t *font = cairo_font_options_create();
    cairo_font_options_set_hint_style(font, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(font, CAIRO_HINT_METRICS_OFF);
    cairo_font_options_set_antialias(font, CAIRO_ANTIALIAS_GRAY);
    cairo_set_font_options(c->cr, font);
    cairo_font_options_destroy(font);
    sp_canvas_colour(c, (colour){1, 1, 1});
    cairo_paint(c->cr);
    sp_canvas_colour(c, (colour){0, 0, 0});
    cairo_set_line_join(c->cr, CAIRO_LINE_JOIN_ROUND);
    if (cairo_status(c->cr) != CAIRO_STATUS_SUCCESS)
        return cairo_failed(c, cairo_status(c->cr), err);
    return SP_OK;
}

void sp_canvas_colour(canvas *c, colour ink) { cairo_set_source_rgb(c->cr, ink.r, ink.g, ink.b); }

void sp_canvas_word(canvas *c, const char *text) {
    bytes_text(&c->words, text);
    bytes_text(&c->words, "\n");
}

/* ---- finishing ------------------------------------------------------------------------------------------------ */

static void add_xml(bytes *out, const char *text, size_t size) {
    for (size_t k = 0; k < size; k++) {
        switch (text[k]) {
        case '&': bytes_text(out, "&amp;"); break;
        case '<': bytes_text(out, "&lt;"); break;
        case '>': bytes_text(out, "&gt;"); break;
        default: bytes_add(out, text + k, 1);
        }
    }
}

static const char *find(const char *from, const char *end, const char *what) {
    return from ? memmem(from, (size_t)(end - from), what, strlen(what)) : NULL;
}

/* Writes title and description, with all texts of the figure, after the opening tag. cairo names the outermost group by
 * the number of surfaces so far; a constant name makes the same figure have the same bytes. */
static void finish_svg(canvas *c) {
    static const char group[] = "id=\"surface";
    bytes out = {0};
    const char *at = c->file.data, *end = at + c->file.size;
    const char *tag = find(find(at, end, "<svg"), end, ">");
    if (tag) {
        bytes_add(&out, at, (size_t)(tag + 1 - at));
        bytes_text(&out, "\n<title>");
        add_xml(&out, c->title, strlen(c->title));
        bytes_text(&out, "</title>\n<desc>");
        add_xml(&out, c->words.data, c->words.size);
        bytes_text(&out, "</desc>");
        at = tag + 1;
    }
    const char *id = find(at, end, group);
    if (id) {
        bytes_add(&out, at, (size_t)(id - at));
        bytes_text(&out, "id=\"figure");
        at = id + strlen(group);
        while (at < end && *at >= '0' && *at <= '9')
            at++;
    }
    bytes_add(&out, at, (size_t)(end - at));
    bytes_free(&c->file);
    c->file = out;
}

/* cairo does not write the resolution. This adds a pHYs chunk of 11811 pixels per metre after the signature (8 bytes)
 * and IHDR (25 bytes). */
static void finish_png(canvas *c) {
    static const unsigned char resolution[] = {0,    0, 0, 9,    'p',  'H', 'Y',  's',  0,    0,   0x2e,
                                               0x23, 0, 0, 0x2e, 0x23, 1,   0x78, 0xa5, 0x3f, 0x76};
    const size_t head = 33;
    bytes out = {0};
    bytes_add(&out, c->file.data, head);
    bytes_add(&out, resolution, sizeof resolution);
    bytes_add(&out, c->file.data + head, c->file.size - head);
    bytes_free(&c->file);
    c->file = out;
}

sp_status sp_canvas_save(canvas *c, sp_error *err) {
    cairo_show_page(c->cr);
    cairo_status_t drawn = cairo_status(c->cr);
    if (drawn == CAIRO_STATUS_SUCCESS && c->kind == CANVAS_PNG)
        drawn = cairo_surface_write_to_png_stream(c->surface, take, &c->file);
    cairo_surface_finish(c->surface);
    if (drawn == CAIRO_STATUS_SUCCESS)
        drawn = cairo_surface_status(c->surface);
    if (drawn == CAIRO_STATUS_SUCCESS && (c->file.failed || c->words.failed))
        drawn = CAIRO_STATUS_NO_MEMORY;
    if (drawn != CAIRO_STATUS_SUCCESS)
        return cairo_failed(c, drawn, err);
    if (c->kind == CANVAS_SVG)
        finish_svg(c);
    if (c->kind == CANVAS_PNG)
        finish_png(c);
    if (c->file.failed)
        return cairo_failed(c, CAIRO_STATUS_NO_MEMORY, err);
    return sp_text_save(c->path, c->file.data, c->file.size, err);
}

void sp_canvas_free(canvas *c) {
    if (c->cr)
        cairo_destroy(c->cr);
    if (c->surface)
        cairo_surface_destroy(c->surface);
    bytes_free(&c->file);
    bytes_free(&c->words);
    if (c->plain) {
        uselocale(c->before);
        freelocale(c->plain);
    }
    *c = (canvas){0};
}

sp_status sp_canvas_close(canvas *c, sp_status status, sp_error *err) {
    if (status == SP_OK)
        status = sp_canvas_save(c, err);
    sp_canvas_free(c);
    return status;
}
