/* Judges how a dataset is stored, before anything of it is read: what HDF5 would take of memory and time for it must be
 * in proportion to what the file holds. */
#include "store/h5.h"

/* Deflate compresses zeros 1032 to 1, so no valid dataset has more data per byte of its file. */
static const uint64_t packing_limit = 1100;

/* To read a single number HDF5 takes memory for the whole chunk, which may be far larger than the data. Other programs
 * write one chunk a frame: it may be larger if the file holds a good part of it. */
static const uint64_t chunk_limit = (uint64_t)1 << 26, chunk_packing = 16;

/* HDF5 spends up to 0.2 ms on a chunk however small it is. A dataset may have so many, and one more for every so many
 * bytes. That allows for vectors of modes, which have a chunk a row and no more rows than columns. */
enum { CHUNKS_OF_ANY = 1024, BYTES_OF_CHUNK = 1024 };

typedef struct layout {
    H5D_layout_t kind;
    bool inside;      /* the data are in the file itself */
    bool deflated;    /* once */
    bool foreign;     /* uses a filter that nobody here needs, or one twice */
    uint64_t element; /* bytes on the disk */
    uint64_t bytes;   /* of all elements */
    uint64_t chunk;   /* bytes of a chunk; UINT64_MAX: more than a number can count */
    uint64_t chunks;
    uint64_t row;  /* bytes of what no chunk can divide but by columns */
    uint64_t held; /* bytes in the file */
} layout;

static uint64_t product(uint64_t a, uint64_t b) { return __builtin_mul_overflow(a, b, &a) ? UINT64_MAX : a; }

static void judge_chunks(hid_t dcpl, const sp_h5_shape *shape, layout *l) {
    hsize_t chunk[SP_H5_RANK] = {0};
    const int rank = H5Pget_chunk(dcpl, SP_H5_RANK, chunk);
    l->chunk = l->element;
    l->chunks = 1;
    for (int k = 0; k < rank && k < SP_H5_RANK; k++) {
        const uint64_t size = chunk[k] > 0 ? chunk[k] : 1;
        l->chunk = product(l->chunk, size);
        l->chunks = product(l->chunks, ((uint64_t)shape->dim[k] + size - 1) / size);
    }
}

/* An unknown filter would make HDF5 look for a plugin on this machine and load it. */
static void judge_filters(hid_t dcpl, layout *l) {
    unsigned seen = 0;
    const int count = H5Pget_nfilters(dcpl);
    for (int k = 0; k < count; k++) {
        unsigned flags, config;
        size_t values = 0;
        const H5Z_filter_t filter = H5Pget_filter2(dcpl, (unsigned)k, &flags, &values, NULL, 0, NULL, &config);
        const bool known =
            filter == H5Z_FILTER_DEFLATE || filter == H5Z_FILTER_SHUFFLE || filter == H5Z_FILTER_FLETCHER32;
        l->foreign = l->foreign || !known || seen & 1u << filter;
        l->deflated = l->deflated || filter == H5Z_FILTER_DEFLATE;
        seen |= known ? 1u << filter : 0;
    }
}

static layout layout_of(sp_h5 *h, hid_t set, const sp_h5_shape *shape, size_t element) {
    hid_t dcpl = H5Dget_create_plist(set);
    layout l = {.kind = dcpl >= 0 ? H5Pget_layout(dcpl) : H5D_LAYOUT_ERROR, .element = element, .bytes = element};
    l.inside = l.kind == H5D_COMPACT || l.kind == H5D_CHUNKED ||
               (l.kind == H5D_CONTIGUOUS && H5Pget_external_count(dcpl) == 0);
    l.row = element;
    for (int k = 0, split = 0; k < shape->rank; k++) {
        l.bytes = product(l.bytes, (uint64_t)shape->dim[k]);
        l.row = split ? product(l.row, (uint64_t)shape->dim[k]) : l.row;
        split = split || shape->dim[k] != 1;
    }
    const hsize_t kept = l.bytes > 0 ? H5Dget_storage_size(set) : 0;
    l.held = kept < h->size ? kept : h->size;
    if (l.kind == H5D_CHUNKED) {
        judge_chunks(dcpl, shape, &l);
        judge_filters(dcpl, &l);
    }
    if (dcpl >= 0)
        H5Pclose(dcpl);
    return l;
}

static sp_status check_chunks(sp_h5 *h, const char *path, const layout *l, sp_error *err) {
    const uint64_t many = CHUNKS_OF_ANY + l->bytes / BYTES_OF_CHUNK, held = product(chunk_packing, l->held);
    const uint64_t least = l->row > chunk_limit ? l->row : chunk_limit, most = held > least ? held : least;
    if (l->foreign)
        return sp_h5_fail(h, err, SP_EFORMAT,
                          "%s uses a filter that is unknown here, or one twice; must be deflate (gzip), shuffle and "
                          "fletcher32, or none",
                          path);
    if (l->chunk > most)
        return sp_h5_fail(h, err, SP_EFORMAT, "%s has chunks of %.3g MB; must be at most %.3g", path,
                          (double)l->chunk * 1e-6, (double)most * 1e-6);
    if (l->chunks > many)
        return sp_h5_fail(h, err, SP_EFORMAT, "%s has %llu chunks for %.3g MB; must have at most %llu", path,
                          (unsigned long long)l->chunks, (double)l->bytes * 1e-6, (unsigned long long)many);
    return SP_OK;
}

sp_status sp_h5_check_layout(sp_h5 *h, hid_t set, const char *path, const sp_h5_shape *shape, size_t element,
                             sp_error *err) {
    const layout l = layout_of(h, set, shape, element);
    if (l.kind == H5D_LAYOUT_ERROR) /* of a dataset that is open: HDF5 has found no memory for its properties */
        return sp_h5_fail(h, err, SP_ENOMEM, "no memory: cannot read the layout of %s", path);
    if (!l.inside)
        return sp_h5_fail(h, err, SP_EFORMAT, "%s keeps its data elsewhere; must be in the file itself", path);
    sp_status status = l.kind == H5D_CHUNKED ? check_chunks(h, path, &l, err) : SP_OK;
    if (status != SP_OK)
        return status;
    if (l.bytes / (l.deflated ? packing_limit : 1) > l.held || (l.bytes > 0 && l.held == 0))
        return sp_h5_fail(h, err, SP_EFORMAT, "%s claims %.3g MB, which the file does not hold", path,
                          (double)l.bytes * 1e-6);
    return SP_OK;
}
