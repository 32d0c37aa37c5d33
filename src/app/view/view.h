#ifndef SP_APP_VIEW_H
#define SP_APP_VIEW_H
/* The page of `sonopack view': one HTML file that shows packings, modes and waves in a browser. The page is
 * src/app/view/ web, made one text at build time; this room computes what it shows and writes it into the page. */

#include "base/text.h"

#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <sonopack/signal.h>

/* What is shown of a packing besides its grains and contacts. */
typedef struct view_options {
    sp_network_options network;
    sp_signal_options signal; /* of the wave: source, until (0: sp_signal_window), points, tolerance, threads */
    bool modes, wave;         /* computed and shown */
    /* A part that cannot be computed is an error; otherwise the page says why it is missing. */
    bool need_modes, need_wave;
    int64_t first, last; /* the modes shown; 0 is the softest that is no zero mode */
    int32_t frames;      /* of the wave; 0: view_frames */
} view_options;

enum { VIEW_FRAMES_MAX = 2000, VIEW_MODES = 10 /* shown by default */ };

/* Called before each part is computed, and for each part that is left out; both may be NULL. */
typedef struct view_report {
    void (*stage)(void *user, const char *what);
    void (*missing)(void *user, const char *reason);
    void *user;
} view_report;

/* The page while it is filled. Begin with zeros, and free it even after a failure. */
typedef struct view_page {
    sp_text data; /* the packings, as JSON */
    int packings;
    bool si; /* opens in SI units, where the material of a packing is known */
} view_page;

/* Adds a packing to the page under this name. Messages do not name the file. SP_EINVAL for modes that do not exist,
 * SP_EREFUSED and others from what is computed. */
sp_status view_add(view_page *page, const char *name, const sp_packing *p, const view_options *options,
                   const view_report *report, sp_error *err);
/* The complete page as text; free it with sp_text_free. */
sp_status view_finish(const view_page *page, const char *title, sp_text *out, sp_error *err);
void view_free(view_page *page);

/* Number of frames for so many degrees of freedom, with which the frames stay below 12 MB in the page. */
int32_t view_frames(int64_t dofs);

#endif
