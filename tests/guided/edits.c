/* Edits of HDF5 files in memory. */
#include "edits.h"
#include "guided.h"

#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What an edit says. */
typedef struct edit {
    int what;
    const char *path;
    unsigned a, b, c, d;
} edit;

static const double value[] = {0,      -1,     1,    2,   3,   0.5,      1e-3,      1e300,
                               -1e300, 1e-310, -0.0, 6.5, NAN, INFINITY, -INFINITY, 2147483648.0,
                               9e18,   12,     1e-4, 7,   255, 100,      -2,        -7};
enum { VALUES = sizeof value / sizeof *value };

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static herr_t note(hid_t object, const char *path, const H5O_info_t *info, void *user) {
    edited_file *f = user;
    must(object >= 0 && info != NULL && f->objects < EDITED_OBJECTS);
    snprintf(f->path[f->objects++], EDITED_PATH, "%s", path);
    return 0;
}

static hid_t open_image(const void *image, size_t size) {
    hid_t fapl = H5Pcreate(H5P_FILE_ACCESS);
    must(fapl >= 0 && H5Pset_fapl_core(fapl, 65536, false) >= 0 && H5Pset_fclose_degree(fapl, H5F_CLOSE_STRONG) >= 0);
    must(H5Pset_libver_bounds(fapl, H5F_LIBVER_V18, H5F_LIBVER_V18) >= 0);
    must(H5Pset_file_image(fapl, (void *)(uintptr_t)image, size) >= 0);
    hid_t file = H5Fopen("edited", H5F_ACC_RDWR, fapl);
    must(file >= 0);
    H5Pclose(fapl);
    return file;
}

edited_file edited_read(const char *path) {
    edited_file f = {0};
    FILE *in = fopen(path, "rb");
    must(in != NULL && fseek(in, 0, SEEK_END) == 0);
    f.size = (size_t)ftell(in);
    f.image = malloc(f.size);
    must(f.image != NULL && fseek(in, 0, SEEK_SET) == 0 && fread(f.image, 1, f.size, in) == f.size);
    fclose(in);
    hid_t file = open_image(f.image, f.size);
    must(H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, note, &f) >= 0);
    must(H5Fclose(file) >= 0 && f.objects > 1);
    return f;
}

/* ---- edits ------------------------------------------------------------------------------------------------------- */

/* A number as it is in memory of type double or int64_t. */
static void set_number(hid_t set, hid_t memory, size_t at, size_t count, double number) {
    uint64_t *data = calloc(count + 1, sizeof *data);
    must(data != NULL);
    if (count > 0 && H5Dread(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0) {
        const int64_t whole = fabs(number) < 9e18 ? (int64_t)number : number > 0 ? INT64_MAX : INT64_MIN;
        if (memory == H5T_NATIVE_DOUBLE)
            memcpy(&data[at % count], &number, sizeof number);
        else
            memcpy(&data[at % count], &whole, sizeof whole);
        H5Dwrite(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    }
    free(data);
}

static void change_value(hid_t file, const edit *e) {
    const hid_t set = H5Dopen2(file, e->path, H5P_DEFAULT);
    if (set < 0)
        return;
    const hid_t type = H5Dget_type(set), space = H5Dget_space(set);
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    const H5T_class_t class = H5Tget_class(type);
    const double number = e->c < 192 ? value[e->c % VALUES] : ldexp((double)e->d + 1, (int)e->c - 224);
    if (count > 0 && count < 100000 && (class == H5T_FLOAT || class == H5T_INTEGER))
        set_number(set, class == H5T_FLOAT ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, e->a << 8 | e->b, (size_t)count,
                   number);
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(set);
}

/* A data type that readers must expect: of any class, and of any size. */
static hid_t any_type(const edit *e) {
    hid_t type = H5I_INVALID_HID;
    switch (e->c % 12) {
    case 0: return H5Tcopy(H5T_IEEE_F32BE);
    case 1: return H5Tcopy(H5T_STD_I8LE);
    case 2: return H5Tcopy(H5T_STD_U64BE);
    case 3: return H5Tcopy(H5T_STD_REF_OBJ);
    case 4:
        type = H5Tcopy(H5T_C_S1);
        H5Tset_size(type, e->d + 1);
        return type;
    case 5:
        type = H5Tcopy(H5T_C_S1);
        H5Tset_size(type, H5T_VARIABLE);
        return type;
    case 6: return H5Tvlen_create(H5T_NATIVE_DOUBLE);
    case 7: return H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, (hsize_t[]){1 + e->d});
    case 8: return H5Tenum_create(H5T_NATIVE_INT);
    case 9:
        type = H5Tcreate(H5T_COMPOUND, 16);
        H5Tinsert(type, "x", 0, H5T_NATIVE_DOUBLE);
        return type;
    case 10:
        type = H5Tcopy(H5T_IEEE_F64LE);
        H5Tset_fields(type, 63, 40 + e->d % 20, 11, 0, 40 + (size_t)e->d % 12);
        return type;
    default:
        type = H5Tcopy(H5T_STD_I64LE);
        H5Tset_precision(type, 1 + e->d % 64);
        return type;
    }
}

/* Layout of a dataset that replaces another. */
static hid_t any_layout(const edit *e, int rank, const hsize_t *dims) {
    static const H5Z_filter_t filters[] = {H5Z_FILTER_DEFLATE,     H5Z_FILTER_SHUFFLE, H5Z_FILTER_FLETCHER32,
                                           H5Z_FILTER_SCALEOFFSET, H5Z_FILTER_NBIT,    32000};
    hid_t dcpl = H5Pcreate(H5P_DATASET_CREATE);
    hsize_t chunk[4];
    for (int k = 0; k < rank; k++)
        chunk[k] = e->a & 1 ? 1 : e->a & 2 ? (hsize_t)1 << (e->d % 31) : dims[k] ? dims[k] : 1;
    if (rank > 0 && e->a & 4 && H5Pset_chunk(dcpl, rank, chunk) >= 0)
        for (unsigned k = 0; k < 6; k++)
            if (e->d >> k & 1)
                H5Pset_filter(dcpl, filters[k], H5Z_FLAG_OPTIONAL, k == 0 ? 1 : 0, (unsigned[]){6});
    if (e->a & 8)
        H5Pset_external(dcpl, "/dev/null", 0, H5F_UNLIMITED);
    return dcpl;
}

/* Another dataset under the same name, of other extents, type and layout, with some of the data in it. */
static void replace(hid_t file, const edit *e) {
    const hid_t old = H5Dopen2(file, e->path, H5P_DEFAULT);
    hsize_t dims[32] = {0}, most[4];
    int rank = 0;
    if (old >= 0) {
        const hid_t space = H5Dget_space(old);
        rank = H5Sget_simple_extent_ndims(space) < 4 ? H5Sget_simple_extent_dims(space, dims, NULL) : 0;
        H5Sclose(space);
    }
    const hid_t type = e->a & 128 && old >= 0 ? H5Dget_type(old) : any_type(e);
    if (old >= 0)
        H5Dclose(old);
    if (e->b & 1 && rank < 3)
        dims[rank++] = e->d;
    if (e->b & 2 && rank > 0)
        rank--;
    if (e->b & 4 && rank > 0)
        dims[e->b % (unsigned)rank] = (hsize_t)1 << (e->d % 32);
    for (int k = 0; k < 4; k++)
        most[k] = H5S_UNLIMITED;
    H5Ldelete(file, e->path, H5P_DEFAULT);
    const hid_t space = e->b & 8   ? H5Screate(H5S_NULL)
                        : rank > 0 ? H5Screate_simple(rank, dims, e->a & 4 ? most : NULL)
                                   : H5Screate(H5S_SCALAR);
    const hid_t dcpl = any_layout(e, rank, dims);
    if (e->b & 16) /* large data that are not there */
        H5Pset_alloc_time(dcpl, H5D_ALLOC_TIME_LATE);
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    const bool narrow = e->a & 4 && e->d & 24; /* with these filters HDF5 1.10 itself writes beyond its memory */
    const bool small = !narrow && count >= 0 && count < 65536 && H5Tget_size(type) < 1024;
    const hid_t set = small || e->a & 4 ? H5Dcreate2(file, e->path, type, space, H5P_DEFAULT, dcpl, H5P_DEFAULT) : -1;
    const H5T_class_t class = H5Tget_class(type);
    if (set >= 0 && small && count > 0 && (class == H5T_FLOAT || class == H5T_INTEGER))
        set_number(set, class == H5T_FLOAT ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, 0, (size_t)count,
                   value[e->d % VALUES]);
    H5Dclose(set);
    H5Pclose(dcpl);
    H5Sclose(space);
    H5Tclose(type);
}

/* What is found under the name is something else. */
static void other_object(hid_t file, const edit *e, const edited_file *of) {
    const char *target = of->path[e->b % (unsigned)of->objects];
    if (e->a % 5 == 4 && H5Lexists(file, target, H5P_DEFAULT) <= 0)
        return;
    if (e->a % 5 != 3)
        H5Ldelete(file, e->path, H5P_DEFAULT);
    switch (e->a % 5) {
    case 0: return;
    case 1: H5Gclose(H5Gcreate2(file, e->path, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)); return;
    case 2: H5Lcreate_soft(target, file, e->path, H5P_DEFAULT, H5P_DEFAULT); return;
    case 3: H5Lcreate_external("/dev/null", "/x", file, "other", H5P_DEFAULT, H5P_DEFAULT); return;
    default: H5Lcreate_hard(file, target, file, e->path, H5P_DEFAULT, H5P_DEFAULT); return;
    }
}

/* Words that mean something in these files. */
static const char *const texts[] = {"rigid",    "grain",     "elastic",  "piston", "periodic", "box",
                                    "none",     "",          "velocity", "dense",  "modal",    "format",
                                    "boundary", "dimension", "sparse",   "force"};

static void change_text(hid_t file, const edit *e) {
    char text[600];
    const char *word = texts[e->a % (sizeof texts / sizeof *texts)];
    memset(text, (int)(e->c | 1u), sizeof text);
    memcpy(text, word, strlen(word) + (e->b < 128));
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, 1 + (e->b * 4) % 599);
    H5Ldelete(file, e->path, H5P_DEFAULT);
    const hid_t set = H5Dcreate2(file, e->path, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text);
    H5Dclose(set);
    H5Sclose(space);
    H5Tclose(type);
}

static void change_attribute(hid_t file, const edit *e) {
    static const char *const names[] = {"format", "boundary", "dimension", "version"};
    const char *name = names[e->a % 4];
    const hid_t type = e->b & 1 ? H5Tcopy(H5T_NATIVE_INT) : any_type(e);
    const hid_t space = e->b & 2 ? H5Screate_simple(1, (hsize_t[]){e->b >> 2}, NULL) : H5Screate(H5S_SCALAR);
    const hid_t object = H5Oopen(file, e->path, H5P_DEFAULT);
    H5Adelete(object, name);
    if (object >= 0 && !(e->b & 128)) {
        const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
        const int numbers[64] = {(int)e->c, (int)e->d};
        if (e->b & 1)
            H5Awrite(attribute, type, numbers);
        H5Aclose(attribute);
    }
    H5Oclose(object);
    H5Sclose(space);
    H5Tclose(type);
}

static void apply(hid_t file, const edit *e, const edited_file *of) {
    switch (e->what) {
    case 0:
    case 1:
    case 2: change_value(file, e); break;
    case 3: replace(file, e); break;
    case 4: other_object(file, e, of); break;
    case 5: change_text(file, e); break;
    case 6: change_attribute(file, e); break;
    default: break; /* of bytes: after all others */
    }
}

uint8_t *edited_apply(const edited_file *of, const uint8_t *data, size_t size, size_t *bytes) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    const hid_t file = open_image(of->image, of->size);
    const size_t edits = size / 8 < 24 ? size / 8 : 24;
    for (size_t k = 0; k < edits; k++) {
        const uint8_t *d = data + 8 * k;
        const edit e = {d[0] % 8, of->path[(d[1] | d[2] << 8) % of->objects], d[3], d[4], d[5], d[6]};
        if (strcmp(e.path, ".") != 0)
            apply(file, &e, of);
    }
    must(H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0);
    const ssize_t length = H5Fget_file_image(file, NULL, 0);
    uint8_t *image = malloc((size_t)length);
    must(length > 0 && image != NULL && H5Fget_file_image(file, image, (size_t)length) == length);
    H5Fclose(file);
    H5Eclear2(H5E_DEFAULT);
    for (size_t k = 0; k < edits; k++)
        if (data[8 * k] % 8 == 7) { /* a byte of the image */
            const size_t at =
                ((size_t)data[8 * k + 3] << 16 | (size_t)data[8 * k + 4] << 8 | data[8 * k + 5]) % (size_t)length;
            image[at] ^= data[8 * k + 6];
        }
    *bytes = (size_t)length;
    return image;
}
