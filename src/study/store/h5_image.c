/* Turns a finished HDF5 file into bytes. */
#include "base/base.h"
#include "store/h5.h"

#include <string.h>

/* ---- the superblock's checksum --------------------------------------------------------------------------------- */

static uint32_t rotate(uint32_t x, int bits) { return x << bits | x >> (32 - bits); }

static uint32_t little_endian(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Bob Jenkins' hash "lookup3" (2006, public domain), the checksum of HDF5's metadata, for 44 bytes: three rounds of 12
 * and a last one of 8. */
static uint32_t checksum44(const uint8_t *bytes) {
    static const int mix[6] = {4, 6, 8, 16, 19, 4}, last[7] = {14, 11, 25, 16, 4, 14, 24};
    uint32_t v[3];
    v[0] = v[1] = v[2] = 0xdeadbeefu + 44;
    for (int at = 0; at < 36; at += 12) {
        for (int k = 0; k < 3; k++)
            v[k] += little_endian(bytes + at + 4 * k);
        for (int k = 0; k < 6; k++) {
            v[k % 3] = (v[k % 3] - v[(k + 2) % 3]) ^ rotate(v[(k + 2) % 3], mix[k]);
            v[(k + 2) % 3] += v[(k + 1) % 3];
        }
    }
    v[0] += little_endian(bytes + 36);
    v[1] += little_endian(bytes + 40);
    for (int k = 0; k < 7; k++)
        v[(k + 2) % 3] = (v[(k + 2) % 3] ^ v[(k + 1) % 3]) - rotate(v[(k + 1) % 3], last[k]);
    return v[2];
}

/* H5Fget_file_image clears the flag "open for writing" in the superblock (version 2 or 3, 48 bytes at the start), but
 * leaves the checksum that was computed with it. */
static void renew_checksum(uint8_t *file, size_t size) {
    if (size < 48 || memcmp(file, "\x89HDF\r\n\x1a\n", 8) != 0 || file[8] < 2 || file[9] != 8)
        return;
    uint32_t sum = checksum44(file);
    for (int k = 0; k < 4; k++)
        file[44 + k] = (uint8_t)(sum >> (8 * k));
}

/* ---- the bytes ------------------------------------------------------------------------------------------------- */

sp_status sp_h5_image(sp_h5 *h, void **data, size_t *size, sp_error *err) {
    ssize_t bytes = H5Fflush(h->file, H5F_SCOPE_GLOBAL) < 0 ? -1 : H5Fget_file_image(h->file, NULL, 0);
    if (bytes <= 0)
        return sp_h5_fail(h, err, SP_ENOMEM, "no memory: cannot finish the HDF5 file");
    void *image = sp_alloc((size_t)bytes, 1);
    if (!image)
        return sp_fail_memory(err, (size_t)bytes);
    if (H5Fget_file_image(h->file, image, (size_t)bytes) != bytes) {
        sp_free(image);
        return sp_h5_fail(h, err, SP_ENOMEM, "no memory: cannot copy the HDF5 file");
    }
    renew_checksum(image, (size_t)bytes);
    *data = image;
    *size = (size_t)bytes;
    return SP_OK;
}
