#ifndef SP_FOREIGN_VTK_H
#define SP_FOREIGN_VTK_H
/* VTK XML PolyData as text: arrays inline, uncompressed, in base64, with a 64-bit size in front. Of the forms that VTK
 * reads, OVITO reads this one alone, with 32- and 64-bit integers and floating-point numbers. */

#include "base/text.h"

typedef enum sp_vtk_type { SP_VTK_F64 = 0, SP_VTK_I64, SP_VTK_I32 } sp_vtk_type;

/* Begins a file and its piece. Every point is a vertex, or every two points are a line. note: a line about units. */
typedef enum sp_vtk_cells { SP_VTK_VERTICES, SP_VTK_LINES } sp_vtk_cells;
void sp_vtk_begin(sp_text *t, const char *note);
void sp_vtk_piece(sp_text *t, sp_vtk_cells cells, int64_t count);
/* A named array of `count` tuples. */
void sp_vtk_array(sp_text *t, const char *name, sp_vtk_type type, int components, int64_t count, const void *data);
/* Points, after the data of points and cells: [count][3] vertices, or [count][2][3] ends of lines. */
void sp_vtk_points(sp_text *t, sp_vtk_cells cells, int64_t count, const double *points);
/* Arrays about the whole: between begin and end, after the piece, for OVITO looks for the piece first. */
void sp_vtk_field(sp_text *t);
void sp_vtk_end(sp_text *t);
/* A file name within XML. */
void sp_vtk_escaped(sp_text *t, const char *name);

#endif
