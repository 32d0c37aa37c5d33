/* Draws clouds of points as an image: a vector figure of a million dots would be large and slow. */
#include "figure/figure.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

#define DOTS_DPI 600.0
enum { SPAN_MOST = 16384 }; /* largest side of the image [pixels] */

/* Number of dots on each pixel of the frame. */
typedef struct cloud {
    int width, height;
    double scale; /* pixels per point */
    uint16_t *count;
    double radius; /* of a dot [pixels] */
} cloud;

static void stamp(cloud *c, double x, double y) {
    const int from = (int)fmax(0, ceil(y - c->radius)), to = (int)fmin(c->height - 1, floor(y + c->radius));
    for (int row = from; row <= to; row++) {
        const double half = sqrt(fmax(0, c->radius * c->radius - (row - y) * (row - y)));
        const int left = (int)fmax(0, ceil(x - half)), right = (int)fmin(c->width - 1, floor(x + half));
        uint16_t *line = c->count + (size_t)row * (size_t)c->width;
        for (int at = left; at <= right; at++)
            line[at] = (uint16_t)(line[at] + (line[at] < UINT16_MAX));
    }
}

static int64_t stamp_all(cloud *c, const figure *f, const series *s) {
    const axis *ax = &f->axes.x, *ay = &f->axes.y;
    const double slack_x = 1e-9 * (ax->high - ax->low), slack_y = 1e-9 * (ay->high - ay->low);
    int64_t drawn = 0;
    for (int64_t k = 0; k < s->n; k++) {
        if (!(s->x[k] >= ax->low - slack_x && s->x[k] <= ax->high + slack_x && s->y[k] >= ay->low - slack_y &&
              s->y[k] <= ay->high + slack_y))
            continue;
        drawn++;
        stamp(c, (sp_axis_place(ax, s->x[k]) - ax->from) * c->scale, (sp_axis_place(ay, s->y[k]) - ay->to) * c->scale);
    }
    return drawn;
}

/* Colour of a pixel under `count` dots of opacity `cover`, premultiplied by its opacity as cairo requires. */
static uint32_t pixel(colour ink, double cover, int count) {
    const double opaque = 1 - pow(1 - cover, count);
    const uint32_t a = (uint32_t)lrint(255 * opaque), r = (uint32_t)lrint(255 * opaque * ink.r);
    const uint32_t g = (uint32_t)lrint(255 * opaque * ink.g), b = (uint32_t)lrint(255 * opaque * ink.b);
    return a << 24 | r << 16 | g << 8 | b;
}

static void paint(const cloud *c, const figure *f, colour ink, double cover) {
    enum { SHADES = 256 };
    uint32_t shade[SHADES];
    for (int k = 0; k < SHADES; k++)
        shade[k] = pixel(ink, cover, k);
    cairo_surface_t *image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, c->width, c->height);
    unsigned char *data = cairo_image_surface_get_data(image);
    const size_t stride = (size_t)cairo_image_surface_get_stride(image);
    for (int y = 0; data && y < c->height; y++)
        for (int x = 0; x < c->width; x++) {
            const uint16_t count = c->count[(size_t)y * (size_t)c->width + (size_t)x];
            memcpy(data + (size_t)y * stride + 4 * (size_t)x, &shade[count < SHADES ? count : SHADES - 1], 4);
        }
    cairo_surface_mark_dirty(image);
    cairo_t *cr = f->canvas->cr;
    cairo_save(cr);
    cairo_translate(cr, f->axes.x.from, f->axes.y.to);
    cairo_scale(cr, 1 / c->scale, 1 / c->scale);
    cairo_set_source_surface(cr, image, 0,
                             0); /* a failed image sets the error state of the canvas, which sp_canvas_save reports */
    cairo_paint(cr);
    cairo_restore(cr);
    cairo_surface_destroy(image);
}

void sp_figure_dots(const figure *f, const series *s) {
    const double wide = f->axes.x.to - f->axes.x.from, high = f->axes.y.from - f->axes.y.to;
    if (!(wide > 0 && high > 0))
        return;
    cloud c = {.scale = fmin(DOTS_DPI / 72, SPAN_MOST / fmax(wide, high))};
    c.width = (int)ceil(wide * c.scale) + 1;
    c.height = (int)ceil(high * c.scale) + 1;
    c.count = sp_alloc((size_t)c.width * (size_t)c.height, sizeof *c.count);
    /* the covered area grows slowly with the number of points */
    const double crowd = pow(fmax(1, (double)s->n / 2000), -0.22);
    c.radius = fmax(1.8, 0.7 * c.scale * crowd);
    if (!c.count)
        f->canvas->words.failed = 1;
    else if (stamp_all(&c, f, s) > 0)
        paint(&c, f, s->ink, fmax(0.2, 0.8 * crowd));
    sp_free(c.count);
}
