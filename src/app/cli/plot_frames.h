#ifndef SP_CLI_PLOT_FRAMES_H
#define SP_CLI_PLOT_FRAMES_H
/* Names of the frames of a movie. */

#include "base/file.h"
#include "cli/cli.h"

enum { PLOT_FRAMES_MAX = 100000 };

/* The file of frame k, counted from 0: "wave-%03d.png" becomes wave-001.png, "wave.png" wave-0001.png. SP_EINVAL names
 * -o and what is wrong. */
sp_status plot_frame_path(const char *output, int64_t k, char path[SP_PATH_MAX], sp_error *err);
/* The files of all frames in one block, which sp_free frees. */
sp_status plot_frame_paths(const char *output, int frames, char ***out, sp_error *err);
/* Whether all frames may be written, as cli_may_write. */
sp_status plot_frames_may_write(const cli_common *common, int64_t frames, sp_error *err);

#endif
