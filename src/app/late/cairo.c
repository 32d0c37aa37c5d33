/* The functions of cairo that the command uses, each loaded when it is first called. */
#include "late/late.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>

static late_library cairo = {LATE_CAIRO, NULL, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};

#define CAIRO(type, name, parameters, arguments) LATE_FUNCTION(&cairo, type, name, parameters, arguments)

CAIRO(void, cairo_arc, (cairo_t * a, double b, double c, double d, double e, double f), (a, b, c, d, e, f))
CAIRO(void, cairo_clip, (cairo_t * a), (a))
CAIRO(void, cairo_close_path, (cairo_t * a), (a))
CAIRO(cairo_t *, cairo_create, (cairo_surface_t * a), (a))
CAIRO(void, cairo_destroy, (cairo_t * a), (a))
CAIRO(void, cairo_fill, (cairo_t * a), (a))
CAIRO(void, cairo_fill_preserve, (cairo_t * a), (a))
CAIRO(cairo_font_options_t *, cairo_font_options_create, (void), ())
CAIRO(void, cairo_font_options_destroy, (cairo_font_options_t * a), (a))
CAIRO(void, cairo_font_options_set_antialias, (cairo_font_options_t * a, cairo_antialias_t b), (a, b))
CAIRO(void, cairo_font_options_set_hint_metrics, (cairo_font_options_t * a, cairo_hint_metrics_t b), (a, b))
CAIRO(void, cairo_font_options_set_hint_style, (cairo_font_options_t * a, cairo_hint_style_t b), (a, b))
CAIRO(cairo_surface_t *, cairo_image_surface_create, (cairo_format_t a, int b, int c), (a, b, c))
CAIRO(unsigned char *, cairo_image_surface_get_data, (cairo_surface_t * a), (a))
CAIRO(int, cairo_image_surface_get_stride, (cairo_surface_t * a), (a))
CAIRO(void, cairo_line_to, (cairo_t * a, double b, double c), (a, b, c))
CAIRO(void, cairo_move_to, (cairo_t * a, double b, double c), (a, b, c))
CAIRO(void, cairo_new_path, (cairo_t * a), (a))
CAIRO(void, cairo_new_sub_path, (cairo_t * a), (a))
CAIRO(void, cairo_paint, (cairo_t * a), (a))
CAIRO(cairo_surface_t *, cairo_pdf_surface_create_for_stream, (cairo_write_func_t a, void *b, double c, double d),
      (a, b, c, d))
CAIRO(void, cairo_pdf_surface_set_metadata, (cairo_surface_t * a, cairo_pdf_metadata_t b, const char *c), (a, b, c))
CAIRO(void, cairo_rectangle, (cairo_t * a, double b, double c, double d, double e), (a, b, c, d, e))
CAIRO(void, cairo_rel_line_to, (cairo_t * a, double b, double c), (a, b, c))
CAIRO(void, cairo_restore, (cairo_t * a), (a))
CAIRO(void, cairo_rotate, (cairo_t * a, double b), (a, b))
CAIRO(void, cairo_save, (cairo_t * a), (a))
CAIRO(void, cairo_scale, (cairo_t * a, double b, double c), (a, b, c))
CAIRO(void, cairo_select_font_face, (cairo_t * a, const char *b, cairo_font_slant_t c, cairo_font_weight_t d),
      (a, b, c, d))
CAIRO(void, cairo_set_dash, (cairo_t * a, const double *b, int c, double d), (a, b, c, d))
CAIRO(void, cairo_set_font_options, (cairo_t * a, const cairo_font_options_t *b), (a, b))
CAIRO(void, cairo_set_font_size, (cairo_t * a, double b), (a, b))
CAIRO(void, cairo_set_line_cap, (cairo_t * a, cairo_line_cap_t b), (a, b))
CAIRO(void, cairo_set_line_join, (cairo_t * a, cairo_line_join_t b), (a, b))
CAIRO(void, cairo_set_line_width, (cairo_t * a, double b), (a, b))
CAIRO(void, cairo_set_source_rgb, (cairo_t * a, double b, double c, double d), (a, b, c, d))
CAIRO(void, cairo_set_source_rgba, (cairo_t * a, double b, double c, double d, double e), (a, b, c, d, e))
CAIRO(void, cairo_set_source_surface, (cairo_t * a, cairo_surface_t *b, double c, double d), (a, b, c, d))
CAIRO(void, cairo_show_page, (cairo_t * a), (a))
CAIRO(void, cairo_show_text, (cairo_t * a, const char *b), (a, b))
CAIRO(cairo_status_t, cairo_status, (cairo_t * a), (a))
CAIRO(const char *, cairo_status_to_string, (cairo_status_t a), (a))
CAIRO(void, cairo_stroke, (cairo_t * a), (a))
CAIRO(void, cairo_surface_destroy, (cairo_surface_t * a), (a))
CAIRO(void, cairo_surface_finish, (cairo_surface_t * a), (a))
CAIRO(void, cairo_surface_mark_dirty, (cairo_surface_t * a), (a))
CAIRO(cairo_status_t, cairo_surface_status, (cairo_surface_t * a), (a))
CAIRO(cairo_status_t, cairo_surface_write_to_png_stream, (cairo_surface_t * a, cairo_write_func_t b, void *c),
      (a, b, c))
CAIRO(cairo_surface_t *, cairo_svg_surface_create_for_stream, (cairo_write_func_t a, void *b, double c, double d),
      (a, b, c, d))
CAIRO(void, cairo_text_extents, (cairo_t * a, const char *b, cairo_text_extents_t *c), (a, b, c))
CAIRO(void, cairo_translate, (cairo_t * a, double b, double c), (a, b, c))
