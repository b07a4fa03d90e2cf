/* An object that does what its data say. */
#include <kinora/ri.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void kinoraTestsNobodyDefinesThis(void);

RtPointer ConvertParameters(char* data) { return strdup(data); }
RtVoid Free(RtPointer data) { free(data); }

static RtVoid deeper(RtPointer data, RtFloat detail) {
  RtBound bound = {-1, 1, -1, 1, -1, 1};
  (void)data;
  RiAttribute("user", "float detail", (RtPointer)&detail, RI_NULL);
  RiDisk(0, 1, 360, RI_NULL);
  RiScale(.5f, .5f, .5f);
  RiProcedural(NULL, bound, deeper, NULL);
}

static void grid(const char* wrap) {
  /* values that are their own numbers: a count that is wrong reads past them, or leaves some out */
  static RtFloat numbers[512];
  RtInt i, vertices[2] = {4, 7};
  for (i = 0; i < 512; ++i) numbers[i] = (RtFloat)i;
  RiBasis(RiBezierBasis, 3, RiBezierBasis, 3);
  RiPatchMesh("bicubic", 7, (RtToken)wrap, 4, "nonperiodic", "P", (RtPointer)numbers, "varying float v",
              (RtPointer)numbers, "uniform float[2] u", (RtPointer)numbers, RI_NULL);
  RiAttributeBegin();
  RiBasis(RiBSplineBasis, 1, RiBSplineBasis, 1);
  RiCurves("cubic", 2, vertices, "nonperiodic", "P", (RtPointer)numbers, "width", (RtPointer)numbers, RI_NULL);
  RiAttributeEnd();
  RiCurves("cubic", 2, vertices, "nonperiodic", "P", (RtPointer)numbers, "width", (RtPointer)numbers, RI_NULL);
}

RtVoid Subdivide(RtPointer data, RtFloat detail) {
  const char* what = data;
  RtBound bound = {-1, 1, -1, 1, -1, 1};
  RtColor red = {1, 0, 0};
  if (!strcmp(what, "crash")) {
    RiSphere(.5f, -.5f, .5f, 360, RI_NULL);
    abort();
  }
  if (!strcmp(what, "call what is not there")) kinoraTestsNobodyDefinesThis();
  if (!strcmp(what, "hang")) sleep(1000);
  if (!strcmp(what, "exit")) exit(3);
  if (!strcmp(what, "ball")) {
    printf("Sphere 9 -9 9 360\n"); /* to a user, not to Kinora */
    RiColor(red);
    RiSphere(.5f, -.5f, .5f, 360, RI_NULL);
  }
  if (!strcmp(what, "deeper")) deeper(NULL, detail);
  if (!strcmp(what, "archives")) {
    RtString file[1] = {"inner.rib"}, program[2] = {"echo Sphere .2 -.2 .2 360", "data"};
    RiProcedural(file, bound, RiProcDelayedReadArchive, NULL);
    RiProcedural(program, bound, RiProcRunProgram, NULL);
  }
  if (!strcmp(what, "handles") || !strcmp(what, "handles again")) {
    const RtObjectHandle first = RiObjectBegin();
    RiSphere(strcmp(what, "handles") ? .1f : .3f, -1, 1, 360, RI_NULL);
    RiObjectEnd();
    RiObjectInstance(first);
  }
  if (!strcmp(what, "counts")) grid("nonperiodic");
  if (!strcmp(what, "undeclared")) {
    RtFloat one = 1;
    RiSphere(1, -1, 1, 360, "nobody said", (RtPointer)&one, RI_NULL);
  }
  if (!strcmp(what, "declared")) {
    RtFloat four[4] = {1, 2, 3, 4};
    RiDeclare("mine", "varying float");
    RiSphere(1, -1, 1, 360, "mine", (RtPointer)four, RI_NULL);
  }
}

/* What it is given, as attributes; tokens are split at their space. */
RtVoid Subdivide2(RtContextHandle context, RtFloat detail, RtInt n, RtToken tokens[], RtPointer values[]) {
  RtInt i, seed = 0;
  RtFloat size[2] = {1, 1};
  (void)context;
  for (i = 0; i < n; ++i) {
    RtInt count = (RtInt)strlen(tokens[i]);
    RiAttribute("user", "string token", (RtPointer)&tokens[i], "int length", (RtPointer)&count, RI_NULL);
    if (!strcmp(tokens[i], "string what")) Subdivide(*(RtString*)values[i], detail);
    if (!strcmp(tokens[i], "int seed")) seed = *(RtInt*)values[i];
    if (!strcmp(tokens[i], "float[2] size")) memcpy(size, values[i], sizeof size);
    if (!strcmp(tokens[i], "string[2] names"))
      RiAttribute("user", "string second", (RtPointer)((RtString*)values[i] + 1), RI_NULL);
  }
  for (i = 0; i < seed; ++i) RiDisk(size[0], size[1], 360, RI_NULL);
}
