#ifndef SP_MARKUP_H
#define SP_MARKUP_H
/* Markup of texts: |c| italic, _{tof} subscript, ^{-4} superscript. A backslash takes the next character literally. */

#include <stddef.h>

/* The typographic minus sign in UTF-8. */
#define MINUS "\xe2\x88\x92"

/* Turns a user's text (such as a file name) into markup. Special characters are escaped, invalid UTF-8 becomes "?",
 * control characters become spaces. A text longer than `most` characters is shortened in the middle. */
void sp_figure_text_escape(char *out, size_t size, const char *raw, int most);
/* Writes a value as markup, as a x 10^b if that is shorter. */
void sp_figure_text_number(char *out, size_t size, double value, int digits);
/* Writes a value with the error of its last digits, such as 0.166(4). The error is left out unless it is positive. */
void sp_figure_text_measured(char *out, size_t size, double value, double error);

#endif
