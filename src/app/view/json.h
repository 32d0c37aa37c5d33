#ifndef SP_VIEW_JSON_H
#define SP_VIEW_JSON_H
/* JSON that may stand in a <script> element of a page: numbers are finite or null, and no text ends the element. */

#include "base/text.h"

/* Bytes of the UTF-8 letter at the start of a text that is not empty; 0 if it begins with none. */
size_t view_letter(const char *text);

typedef struct view_json {
    sp_text *text;
    bool follows; /* a value stands before the next one in the same object or array */
} view_json;

/* key: NULL in an array. An object is opened by '{' and closed by '}', an array by '[' and ']'. */
void view_open(view_json *j, const char *key, char bracket);
void view_close(view_json *j, char bracket);
void view_number(view_json *j, const char *key, double value); /* null unless finite */
void view_integer(view_json *j, const char *key, int64_t value);
void view_truth(view_json *j, const char *key, bool value);
void view_text(view_json *j, const char *key, const char *value); /* UTF-8; NULL: null */
void view_numbers(view_json *j, const char *key, int64_t n, const double *value);

/* A binary array: {"type", "shape", "data"}, data in base64, little-endian, the last axis fastest. */
typedef enum view_type { VIEW_UINT8, VIEW_INT8, VIEW_INT16, VIEW_UINT16, VIEW_INT32, VIEW_FLOAT32 } view_type;
/* shape: ended by 0 after at most three sizes; no size may be 0 but the first. */
void view_array(view_json *j, const char *key, view_type type, const int64_t shape[4], const void *data);

#endif
