/* Menger's sponge, and what else a pattern of 3 x 3 x 3 cubes makes when each cube is the pattern again: a shared
 * object for Procedural "DynamicLoad" (docs/command-line.md).
 *
 *     cc -shared -fPIC -I PREFIX/include examples/procedurals/menger.c -o menger.so
 *
 * Data: "level  xmin xmax  ymin ymax  zmin zmax  pattern", 27 ones and zeros, x fastest; what follows is not read.
 * A cube that is smaller than a pixel is drawn as it is: detail is its area on the screen.
 */
#include <kinora/ri.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  int level;
  RtBound bound;
  char isThere[27];
} Sponge;

RtPointer ConvertParameters(char* data) {
  Sponge* s = calloc(1, sizeof *s);
  int read = 0, k, cell;
  if (!s) return NULL;
  if (sscanf(data, "%d %f %f %f %f %f %f%n", &s->level, &s->bound[0], &s->bound[1], &s->bound[2], &s->bound[3],
             &s->bound[4], &s->bound[5], &read) != 7) {
    fprintf(stderr, "menger: the data begin with a level and six numbers\n");
    free(s);
    return NULL;
  }
  for (k = 0; k < 27; ++k) {
    int more = 0;
    if (sscanf(data + read, "%d%n", &cell, &more) != 1) {
      fprintf(stderr, "menger: the pattern has %d numbers in place of 27\n", k);
      free(s);
      return NULL;
    }
    s->isThere[k] = cell != 0;
    read += more;
  }
  return s;
}

static void drawBox(RtBound b) {
  RtInt counts[6] = {4, 4, 4, 4, 4, 4};
  /* corner x + 2 y + 4 z, each face as it is seen from the outside */
  RtInt corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  RtPoint P[8];
  int i;
  for (i = 0; i < 8; ++i) {
    P[i][0] = b[i & 1];
    P[i][1] = b[2 + (i >> 1 & 1)];
    P[i][2] = b[4 + (i >> 2)];
  }
  RiPointsPolygons(6, counts, corners, RI_P, (RtPointer)P, RI_NULL);
}

RtVoid Free(RtPointer data) { free(data); }

RtVoid Subdivide(RtPointer data, RtFloat detail) {
  Sponge* s = data;
  int i, k;
  if (!s) return;
  if (s->level <= 0 || detail < 1) {
    drawBox(s->bound);
    return;
  }
  for (i = 0; i < 27; ++i) {
    const int at[3] = {i % 3, i / 3 % 3, i / 9};
    Sponge* part;
    if (!s->isThere[i] || !(part = malloc(sizeof *part))) continue;
    memcpy(part, s, sizeof *part);
    part->level = s->level - 1;
    for (k = 0; k < 3; ++k) {
      const float low = s->bound[2 * k], width = s->bound[2 * k + 1] - low;
      part->bound[2 * k] = low + width * at[k] / 3;
      part->bound[2 * k + 1] = low + width * (at[k] + 1) / 3;
    }
    RiProcedural(part, part->bound, Subdivide, Free);
  }
}
