/* The locale of numbers in text. */
#include "base/text.h"

sp_locale sp_locale_enter(void) {
    sp_locale l = {.plain = newlocale(LC_ALL_MASK, "C", (locale_t)0)};
    if (l.plain != (locale_t)0)
        l.before = uselocale(l.plain);
    return l;
}

void sp_locale_leave(sp_locale *l) {
    if (l->plain != (locale_t)0) {
        uselocale(l->before);
        freelocale(l->plain);
    }
}
