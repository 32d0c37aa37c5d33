/* The functions and identifiers of HDF5 that the command uses, loaded when a function is first called. */
#include "late/late.h"

#include <hdf5.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

/* The identifiers behind H5T_NATIVE_DOUBLE and its like are variables, which nothing can load when they are read. But
 * the macros call H5open() before they read them: by then these have been filled. */
hid_t H5E_PLIST_g, H5E_RESOURCE_g, H5P_CLS_DATASET_CREATE_ID_g, H5P_CLS_FILE_ACCESS_ID_g, H5P_CLS_FILE_CREATE_ID_g,
    H5P_CLS_GROUP_CREATE_ID_g, H5T_C_S1_g, H5T_IEEE_F64LE_g, H5T_NATIVE_DOUBLE_g, H5T_NATIVE_INT32_g,
    H5T_NATIVE_INT64_g, H5T_NATIVE_UINT64_g, H5T_NATIVE_UINT8_g, H5T_STD_I32LE_g, H5T_STD_I64LE_g, H5T_STD_REF_OBJ_g,
    H5T_STD_U64LE_g, H5T_STD_U8LE_g;

static void fill_identifiers(void);

static late_library hdf5 = {LATE_HDF5, fill_identifiers, PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP, NULL};

#define HDF5(type, name, parameters, arguments) LATE_FUNCTION(&hdf5, type, name, parameters, arguments)

HDF5(herr_t, H5Aclose, (hid_t a), (a))
HDF5(hid_t, H5Acreate_by_name, (hid_t a, const char *b, const char *c, hid_t d, hid_t e, hid_t f, hid_t g, hid_t h),
     (a, b, c, d, e, f, g, h))
HDF5(htri_t, H5Aexists_by_name, (hid_t a, const char *b, const char *c, hid_t d), (a, b, c, d))
HDF5(hid_t, H5Aget_space, (hid_t a), (a))
HDF5(hid_t, H5Aget_type, (hid_t a), (a))
HDF5(hid_t, H5Aopen_by_name, (hid_t a, const char *b, const char *c, hid_t d, hid_t e), (a, b, c, d, e))
HDF5(herr_t, H5Aread, (hid_t a, hid_t b, void *c), (a, b, c))
HDF5(herr_t, H5Awrite, (hid_t a, hid_t b, const void *c), (a, b, c))
HDF5(herr_t, H5Dclose, (hid_t a), (a))
HDF5(hid_t, H5Dcreate2, (hid_t a, const char *b, hid_t c, hid_t d, hid_t e, hid_t f, hid_t g), (a, b, c, d, e, f, g))
HDF5(hid_t, H5Dget_create_plist, (hid_t a), (a))
HDF5(hid_t, H5Dget_space, (hid_t a), (a))
HDF5(hsize_t, H5Dget_storage_size, (hid_t a), (a))
HDF5(hid_t, H5Dget_type, (hid_t a), (a))
HDF5(hid_t, H5Dopen2, (hid_t a, const char *b, hid_t c), (a, b, c))
HDF5(herr_t, H5Dread, (hid_t a, hid_t b, hid_t c, hid_t d, hid_t e, void *f), (a, b, c, d, e, f))
HDF5(herr_t, H5Dvlen_reclaim, (hid_t a, hid_t b, hid_t c, void *d), (a, b, c, d))
HDF5(herr_t, H5Dwrite, (hid_t a, hid_t b, hid_t c, hid_t d, hid_t e, const void *f), (a, b, c, d, e, f))
HDF5(herr_t, H5Eclear2, (hid_t a), (a))
HDF5(herr_t, H5Eget_auto2, (hid_t a, H5E_auto2_t *b, void **c), (a, b, c))
HDF5(herr_t, H5Eset_auto2, (hid_t a, H5E_auto2_t b, void *c), (a, b, c))
HDF5(herr_t, H5Ewalk2, (hid_t a, H5E_direction_t b, H5E_walk2_t c, void *d), (a, b, c, d))
HDF5(hid_t, H5FDregister, (const H5FD_class_t *a), (a))
HDF5(herr_t, H5FDunregister, (hid_t a), (a))
HDF5(herr_t, H5Fclose, (hid_t a), (a))
HDF5(hid_t, H5Fcreate, (const char *a, unsigned b, hid_t c, hid_t d), (a, b, c, d))
HDF5(herr_t, H5Fflush, (hid_t a, H5F_scope_t b), (a, b))
HDF5(ssize_t, H5Fget_file_image, (hid_t a, void *b, size_t c), (a, b, c))
HDF5(herr_t, H5Fget_filesize, (hid_t a, hsize_t *b), (a, b))
HDF5(hid_t, H5Fopen, (const char *a, unsigned b, hid_t c), (a, b, c))
HDF5(herr_t, H5Gclose, (hid_t a), (a))
HDF5(hid_t, H5Gcreate2, (hid_t a, const char *b, hid_t c, hid_t d, hid_t e), (a, b, c, d, e))
HDF5(htri_t, H5Lexists, (hid_t a, const char *b, hid_t c), (a, b, c))
HDF5(herr_t, H5Lget_info, (hid_t a, const char *b, H5L_info_t *c, hid_t d), (a, b, c, d))
HDF5(herr_t, H5Pclose, (hid_t a), (a))
HDF5(hid_t, H5Pcreate, (hid_t a), (a))
HDF5(const void *, H5Pget_driver_info, (hid_t a), (a))
HDF5(int, H5Pget_external_count, (hid_t a), (a))
HDF5(int, H5Pget_chunk, (hid_t a, int b, hsize_t c[]), (a, b, c))
HDF5(H5Z_filter_t, H5Pget_filter2,
     (hid_t a, unsigned b, unsigned *c, size_t *d, unsigned *e, size_t f, char *g, unsigned *i),
     (a, b, c, d, e, f, g, i))
HDF5(H5D_layout_t, H5Pget_layout, (hid_t a), (a))
HDF5(int, H5Pget_nfilters, (hid_t a), (a))
HDF5(herr_t, H5Pset_chunk, (hid_t a, int b, const hsize_t c[]), (a, b, c))
HDF5(herr_t, H5Pset_driver, (hid_t a, hid_t b, const void *c), (a, b, c))
HDF5(herr_t, H5Pset_fapl_core, (hid_t a, size_t b, hbool_t c), (a, b, c))
HDF5(herr_t, H5Pset_fclose_degree, (hid_t a, H5F_close_degree_t b), (a, b))
HDF5(herr_t, H5Pset_file_locking, (hid_t a, hbool_t b, hbool_t c), (a, b, c))
HDF5(herr_t, H5Pset_fill_value, (hid_t a, hid_t b, const void *c), (a, b, c))
HDF5(herr_t, H5Pset_fletcher32, (hid_t a), (a))
HDF5(herr_t, H5Pset_layout, (hid_t a, H5D_layout_t b), (a, b))
HDF5(herr_t, H5Pset_libver_bounds, (hid_t a, H5F_libver_t b, H5F_libver_t c), (a, b, c))
HDF5(herr_t, H5Pset_link_phase_change, (hid_t a, unsigned b, unsigned c), (a, b, c))
HDF5(herr_t, H5Pset_obj_track_times, (hid_t a, hbool_t b), (a, b))
HDF5(herr_t, H5Rcreate, (void *a, hid_t b, const char *c, H5R_type_t d, hid_t e), (a, b, c, d, e))
HDF5(herr_t, H5Sclose, (hid_t a), (a))
HDF5(hid_t, H5Screate, (H5S_class_t a), (a))
HDF5(herr_t, H5Sselect_hyperslab,
     (hid_t a, H5S_seloper_t b, const hsize_t c[], const hsize_t d[], const hsize_t e[], const hsize_t f[]),
     (a, b, c, d, e, f))
HDF5(hid_t, H5Screate_simple, (int a, const hsize_t b[], const hsize_t c[]), (a, b, c))
HDF5(int, H5Sget_simple_extent_dims, (hid_t a, hsize_t b[], hsize_t c[]), (a, b, c))
HDF5(int, H5Sget_simple_extent_ndims, (hid_t a), (a))
HDF5(hssize_t, H5Sget_simple_extent_npoints, (hid_t a), (a))
HDF5(H5S_class_t, H5Sget_simple_extent_type, (hid_t a), (a))
HDF5(htri_t, H5Sis_simple, (hid_t a), (a))
HDF5(herr_t, H5Tclose, (hid_t a), (a))
HDF5(hid_t, H5Tcopy, (hid_t a), (a))
HDF5(H5T_class_t, H5Tget_class, (hid_t a), (a))
HDF5(size_t, H5Tget_size, (hid_t a), (a))
HDF5(htri_t, H5Tis_variable_str, (hid_t a), (a))
HDF5(herr_t, H5Tset_cset, (hid_t a, H5T_cset_t b), (a, b))
HDF5(herr_t, H5Tset_size, (hid_t a, size_t b), (a, b))
HDF5(herr_t, H5Tset_strpad, (hid_t a, H5T_str_t b), (a, b))
HDF5(herr_t, H5check_version, (unsigned a, unsigned b, unsigned c), (a, b, c))
HDF5(herr_t, H5dont_atexit, (void), ())
HDF5(herr_t, H5open, (void), ())

static void fill_identifiers(void) {
    static const struct {
        hid_t *ours;
        const char *name;
    } identifier[] = {{&H5E_PLIST_g, "H5E_PLIST_g"},
                      {&H5E_RESOURCE_g, "H5E_RESOURCE_g"},
                      {&H5P_CLS_DATASET_CREATE_ID_g, "H5P_CLS_DATASET_CREATE_ID_g"},
                      {&H5P_CLS_FILE_ACCESS_ID_g, "H5P_CLS_FILE_ACCESS_ID_g"},
                      {&H5P_CLS_FILE_CREATE_ID_g, "H5P_CLS_FILE_CREATE_ID_g"},
                      {&H5P_CLS_GROUP_CREATE_ID_g, "H5P_CLS_GROUP_CREATE_ID_g"},
                      {&H5T_C_S1_g, "H5T_C_S1_g"},
                      {&H5T_IEEE_F64LE_g, "H5T_IEEE_F64LE_g"},
                      {&H5T_NATIVE_DOUBLE_g, "H5T_NATIVE_DOUBLE_g"},
                      {&H5T_NATIVE_INT32_g, "H5T_NATIVE_INT32_g"},
                      {&H5T_NATIVE_INT64_g, "H5T_NATIVE_INT64_g"},
                      {&H5T_NATIVE_UINT64_g, "H5T_NATIVE_UINT64_g"},
                      {&H5T_NATIVE_UINT8_g, "H5T_NATIVE_UINT8_g"},
                      {&H5T_STD_I32LE_g, "H5T_STD_I32LE_g"},
                      {&H5T_STD_I64LE_g, "H5T_STD_I64LE_g"},
                      {&H5T_STD_REF_OBJ_g, "H5T_STD_REF_OBJ_g"},
                      {&H5T_STD_U64LE_g, "H5T_STD_U64LE_g"},
                      {&H5T_STD_U8LE_g, "H5T_STD_U8LE_g"}};
    H5dont_atexit();
    if (H5open() < 0) { /* half of it would call sound files damaged */
        fputs("sonopack: HDF5 cannot begin: no memory\n", stderr);
        exit(EXIT_FAILURE);
    }
    for (size_t k = 0; k < sizeof identifier / sizeof *identifier; k++)
        *identifier[k].ours = *(const hid_t *)late_find(&hdf5, identifier[k].name);
}
