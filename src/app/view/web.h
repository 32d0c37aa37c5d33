#ifndef SP_VIEW_WEB_H
#define SP_VIEW_WEB_H
/* The page without its data: src/app/view/web and third_party/three put together by cmake/web.cmake at build time. */

/* Ends with a zero. */
extern const unsigned char view_web_page[];

/* What stands in it where the title and the data belong. */
#define VIEW_TITLE "@VIEW_TITLE@"
#define VIEW_DATA  "@VIEW_DATA@"

#endif
