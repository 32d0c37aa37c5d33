#ifndef SP_MARKUP_H
#define SP_MARKUP_H
/* Texts with style. Markup: |c| italic, _{tof} subscript, ^{-4} superscript; a backslash in front of any sign takes it
 * as it is. */

#include <stddef.h>

/* The minus sign of print, in UTF-8. */
#define MINUS "\xe2\x88\x92"

/* A user's text (a file name, say) as markup: signs escaped, what is not valid UTF-8 replaced by "?", control
 * characters by spaces, and more than `most` characters shortened in the middle. */
void sp_figure_text_escape(char *out, size_t size, const char *raw, int most);
/* value as markup, a x 10^b where that is shorter to read. */
void sp_figure_text_number(char *out, size_t size, double value, int digits);
/* value(error in its last digits), 0.166(4); without the error where it is not a positive number. */
void sp_figure_text_measured(char *out, size_t size, double value, double error);

#endif
