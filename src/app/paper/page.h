#ifndef SP_PAPER_PAGE_H
#define SP_PAPER_PAGE_H
/* A report in two forms with the same content, report.html and report.md, in a folder of its own. Texts are plain:
 * special characters are escaped, and +- becomes ±. */

#include "base/text.h"

#include <stdbool.h>

typedef struct paper_page {
    sp_text html, md;
} paper_page;

/* Writes the report.md of an unfinished report. */
sp_status sp_paper_page_unfinished(const char *folder, sp_error *err);

void sp_paper_page_open(paper_page *p, const char *title);
void sp_paper_page_heading(paper_page *p, const char *id, const char *text);
/* lead: words in bold before the text; "" for none. */
void sp_paper_page_paragraph(paper_page *p, const char *lead, const char *text);
void sp_paper_page_format(paper_page *p, const char *lead, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Writes each line of a text as a paragraph, the first with the lead. text may be NULL. */
void sp_paper_page_paragraphs(paper_page *p, const char *lead, const char *text);

void sp_paper_page_table(paper_page *p, int cells, const char *const *head);
/* class: style of the row. sentence: index of the cell that holds a sentence and may be broken into lines; -1: none. */
void sp_paper_page_row(paper_page *p, int cells, const char *const *cell, const char *class, int sentence);
void sp_paper_page_table_end(paper_page *p);

/* Refers to a file in the folder. shown: as an image, otherwise as a link. */
void sp_paper_page_figure(paper_page *p, const char *file, bool shown, const char *caption);
/* Ends the page and writes both forms. */
sp_status sp_paper_page_save(paper_page *p, const char *folder, sp_error *err);
void sp_paper_page_free(paper_page *p);

#endif
