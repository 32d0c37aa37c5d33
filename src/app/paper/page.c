/* Writes a report as HTML and Markdown, and checks its folder. */
#include "paper/page.h"
#include "base/base.h"
#include "base/file.h"

#include "paper/reproduce.h"
#include <dirent.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* ---- the folder ------------------------------------------------------------------------------------------------- */

/* First lines of a report, and of an unfinished one. */
#define MARK       "<!-- sonopack reproduce -->"
#define UNFINISHED "This report is not finished."

/* Reads the beginning of report.md in a folder; "" without the file. */
static void read_head(const char *folder, char head[256]) {
    char path[SP_PATH_MAX];
    head[0] = '\0';
    snprintf(path, sizeof path, "%.3900s/report.md", folder);
    FILE *file = fopen(path, "rb");
    if (!file)
        return;
    head[fread(head, 1, 255, file)] = '\0';
    fclose(file);
}

static bool is_empty(const char *folder) {
    DIR *open = opendir(folder);
    int files = 0;
    for (struct dirent *entry; open && (entry = readdir(open));)
        files += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    if (open)
        closedir(open);
    return files == 0;
}

sp_status sp_paper_check_folder(const char *folder, bool replace, sp_error *err) {
    struct stat info;
    char head[256];
    if (!*folder || strlen(folder) > 3800)
        return sp_fail(err, SP_EINVAL, "folder '%.100s': a path of 1 to 3800 characters", folder);
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return sp_fail(err, SP_EIO, "cannot make the folder %s: %s", folder, strerror(errno));
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode))
        return sp_fail(err, SP_EINVAL, "%s: is no folder: must be one for the report and its figures", folder);
    sp_status status = sp_folder_probe(folder, err);
    if (status != SP_OK || is_empty(folder))
        return status;
    read_head(folder, head);
    if (strncmp(head, MARK, strlen(MARK)) != 0)
        return sp_fail(err, SP_EINVAL, "%s: has other files in it and no report: must be a new or an empty folder",
                       folder);
    if (!strstr(head, UNFINISHED) && !replace)
        return sp_fail(err, SP_EINVAL, "%s: has a report already: must be another folder, or give --force", folder);
    return SP_OK;
}

static sp_status save(const char *folder, const char *ending, const sp_text *text, sp_error *err) {
    char path[SP_PATH_MAX];
    if (text->failed)
        return sp_fail_memory(err, text->capacity);
    snprintf(path, sizeof path, "%.3900s/report.%s", folder, ending);
    return sp_text_save(path, text->data, text->size, err);
}

sp_status sp_paper_page_unfinished(const char *folder, sp_error *err) {
    sp_text text = {0};
    sp_text_add(&text, "%s\n\n%s The same command goes on with it.\n", MARK, UNFINISHED);
    sp_status status = save(folder, "md", &text, err);
    sp_text_free(&text);
    return status;
}

/* ---- two forms -------------------------------------------------------------------------------------------------- */

static void escape(sp_text *t, const char *text) {
    for (; *text; text++) {
        if (*text == '<')
            sp_text_add(t, "&lt;");
        else if (*text == '>')
            sp_text_add(t, "&gt;");
        else if (*text == '&')
            sp_text_add(t, "&amp;");
        else if (*text == '"')
            sp_text_add(t, "&quot;");
        else if (*text == '+' && text[1] == '-') {
            sp_text_add(t, "±");
            text++;
        } else
            sp_text_bytes(t, text, 1);
    }
}

/* Escapes the characters that are special in Markdown. */
static void escape_md(sp_text *t, const char *text) {
    for (; *text; text++) {
        if (*text == '+' && text[1] == '-') {
            sp_text_add(t, "±");
            text++;
            continue;
        }
        if (strchr("*_|<>\\", *text))
            sp_text_add(t, "\\");
        sp_text_bytes(t, text, 1);
    }
}

static const char *const style =
    "body{font:16px/1.45 Georgia,serif;max-width:46em;margin:1em auto;padding:0 1em;color:#111;background:#fff}"
    "h1{font-size:1.5em;line-height:1.2}h2{font-size:1.2em;margin-top:2em;border-top:1px solid #bbb;padding-top:.6em}"
    ".wide{overflow-x:auto}table{border-collapse:collapse;font:13px/1.35 sans-serif;margin:.8em 0}"
    "th,td{padding:.15em .6em;text-align:right;white-space:nowrap;border-bottom:1px solid #ddd}"
    "td.sentence{white-space:normal;text-align:left;min-width:16em}th:first-child,td:first-child{text-align:left}tr."
    "deviates td{background:#fdebd3}tr.missing td{color:#777}"
    "figure{margin:1.2em 0;text-align:center}img{max-width:100%;height:auto}"
    "figcaption{font-size:.9em;color:#333;text-align:left}"
    "@media print{body{max-width:none;font-size:11pt}figure,table{break-inside:avoid}}";

void sp_paper_page_open(paper_page *p, const char *title) {
    sp_text_add(&p->html,
                "<!DOCTYPE html>\n%s\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                "<title>%s</title>\n<style>%s</style></head>\n<body>\n<h1>%s</h1>\n",
                MARK, title, style, title);
    sp_text_add(&p->md, "%s\n\n# %s\n\n", MARK, title);
}

void sp_paper_page_heading(paper_page *p, const char *id, const char *text) {
    sp_text_add(&p->html, "<h2 id=\"%s\">", id);
    escape(&p->html, text);
    sp_text_add(&p->html, "</h2>\n");
    sp_text_add(&p->md, "## ");
    escape_md(&p->md, text);
    sp_text_add(&p->md, "\n\n");
}

void sp_paper_page_paragraph(paper_page *p, const char *lead, const char *text) {
    sp_text_add(&p->html, "<p>");
    if (*lead)
        sp_text_add(&p->html, "<b>%s</b> ", lead);
    escape(&p->html, text);
    sp_text_add(&p->html, "</p>\n");
    if (*lead)
        sp_text_add(&p->md, "**%s** ", lead);
    escape_md(&p->md, text);
    sp_text_add(&p->md, "\n\n");
}

void sp_paper_page_format(paper_page *p, const char *lead, const char *format, ...) {
    char line[1300];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    sp_paper_page_paragraph(p, lead, line);
}

void sp_paper_page_paragraphs(paper_page *p, const char *lead, const char *text) {
    char line[1300];
    while (text && *text) {
        const size_t length = strcspn(text, "\n");
        snprintf(line, sizeof line, "%.*s", (int)length, text);
        sp_paper_page_paragraph(p, lead, line);
        lead = "";
        text += length + (text[length] == '\n');
    }
}

/* ---- tables and figures ----------------------------------------------------------------------------------------- */

static void row(paper_page *p, int cells, const char *const *cell, const char *tag, int sentence) {
    sp_text_add(&p->md, "|");
    for (int k = 0; k < cells; k++) {
        sp_text_add(&p->html, "<%s%s>", tag, k == sentence ? " class=\"sentence\"" : "");
        escape(&p->html, cell[k]);
        sp_text_add(&p->html, "</%s>", tag);
        sp_text_add(&p->md, " ");
        escape_md(&p->md, cell[k]);
        sp_text_add(&p->md, " |");
    }
    sp_text_add(&p->html, "</tr>\n");
    sp_text_add(&p->md, "\n");
}

void sp_paper_page_table(paper_page *p, int cells, const char *const *head) {
    sp_text_add(&p->html, "<div class=\"wide\"><table>\n<tr>");
    row(p, cells, head, "th", -1);
    sp_text_add(&p->md, "|");
    for (int k = 0; k < cells; k++)
        sp_text_add(&p->md, "---|");
    sp_text_add(&p->md, "\n");
}

void sp_paper_page_row(paper_page *p, int cells, const char *const *cell, const char *class, int sentence) {
    sp_text_add(&p->html, "<tr class=\"%s\">", class);
    row(p, cells, cell, "td", sentence);
}

void sp_paper_page_table_end(paper_page *p) {
    sp_text_add(&p->html, "</table></div>\n");
    sp_text_add(&p->md, "\n");
}

void sp_paper_page_figure(paper_page *p, const char *file, bool shown, const char *caption) {
    sp_text_add(&p->html, "<figure>");
    if (shown) {
        sp_text_add(&p->html, "<img src=\"%s\" alt=\"", file);
        escape(&p->html, caption);
        sp_text_add(&p->html, "\">");
    } else {
        sp_text_add(&p->html, "<a href=\"%s\">%s</a>", file, file);
    }
    sp_text_add(&p->html, "<figcaption>");
    escape(&p->html, caption);
    sp_text_add(&p->html, "</figcaption></figure>\n");
    sp_text_add(&p->md, shown ? "![" : "[");
    escape_md(&p->md, caption);
    sp_text_add(&p->md, "](%s)\n\n", file);
    if (shown) {
        sp_text_add(&p->md, "*");
        escape_md(&p->md, caption);
        sp_text_add(&p->md, "*\n\n");
    }
}

sp_status sp_paper_page_save(paper_page *p, const char *folder, sp_error *err) {
    sp_text_add(&p->html, "</body></html>\n");
    sp_status status = save(folder, "html", &p->html, err);
    return status == SP_OK ? save(folder, "md", &p->md, err) : status;
}

void sp_paper_page_free(paper_page *p) {
    sp_text_free(&p->html);
    sp_text_free(&p->md);
}
