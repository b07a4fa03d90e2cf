/* The RenderMan Interface in C, for shared objects that Procedural "DynamicLoad" names (docs/procedurals.md). Such an
 * object is run by kinora-procedural, in a process of its own: what it calls here becomes the RIB of the archive that the
 * procedural stands for.
 *
 * An object defines three functions with C linkage:
 *
 *   RtPointer ConvertParameters(char* data);               the data of the request, as an object of its own
 *   RtVoid    Subdivide(RtPointer data, RtFloat detail);   calls of the interface
 *   RtVoid    Free(RtPointer data);
 *
 * One for Procedural2 "DynamicLoad2" defines
 *
 *   RtVoid Subdivide2(RtContextHandle context, RtFloat detail, RtInt n, RtToken tokens[], RtPointer values[]);
 *
 * which is given the parameters of the request: tokens "type name" or "type[n] name" without a class, and arrays of
 * RtInt, RtFloat or RtString. Without it the first three are called, with the request's "string data".
 *
 * detail: 1000000 always, all there is: how large the bound is seen is not known when it is read. Each function with a
 * parameter list exists twice: with pairs of token and pointer that end with RI_NULL, and, with a V at the end of its
 * name, with arrays of n of them. Values are in the space of the request, as in RIB. Names and types are those of the RenderMan Interface Specification
 * 3.2 (2000); the requests of later versions follow its rules.
 */
#ifndef KINORA_RI_H
#define KINORA_RI_H

#ifdef __cplusplus
extern "C" {
#endif
#ifdef __GNUC__
#pragma GCC visibility push(default)
#endif

typedef short RtBoolean;
typedef int RtInt;
typedef float RtFloat;
typedef char* RtToken;
typedef char* RtString;
typedef void* RtPointer;
typedef void RtVoid;
typedef RtFloat RtColor[3];
typedef RtFloat RtPoint[3];
typedef RtFloat RtVector[3];
typedef RtFloat RtNormal[3];
typedef RtFloat RtHpoint[4];
typedef RtFloat RtMatrix[4][4];
typedef RtFloat RtBasis[4][4];
typedef RtFloat RtBound[6]; /* x, x, y, y, z, z */
typedef RtPointer RtObjectHandle;
typedef RtPointer RtLightHandle;
typedef RtPointer RtContextHandle;
typedef RtFloat (*RtFilterFunc)(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth);
typedef RtVoid (*RtErrorHandler)(RtInt code, RtInt severity, char* message);
typedef RtVoid (*RtProcSubdivFunc)(RtPointer data, RtFloat detail);
typedef RtVoid (*RtProcFreeFunc)(RtPointer data);
typedef RtVoid (*RtArchiveCallback)(RtToken type, char* format, ...);

#define RI_FALSE 0
#define RI_TRUE 1
#define RI_INFINITY 1.0e38f
#define RI_EPSILON 1.0e-10f
#define RI_NULL ((RtToken)0)

/* NAME, "text" */
#define KINORA_RI_TOKENS(T)                                                                                      \
  T(RI_A, "a") T(RI_ABORT, "abort") T(RI_AMBIENTLIGHT, "ambientlight") T(RI_AMPLITUDE, "amplitude")              \
  T(RI_AZ, "az") T(RI_BACKGROUND, "background") T(RI_BEAMDISTRIBUTION, "beamdistribution")                       \
  T(RI_BICUBIC, "bicubic") T(RI_BILINEAR, "bilinear") T(RI_BLACK, "black") T(RI_BUMPY, "bumpy")                  \
  T(RI_CAMERA, "camera") T(RI_CATMULLCLARK, "catmull-clark") T(RI_CLAMP, "clamp") T(RI_COMMENT, "comment")       \
  T(RI_CONEANGLE, "coneangle") T(RI_CONEDELTAANGLE, "conedeltaangle") T(RI_CONSTANT, "constant")                 \
  T(RI_CONSTANTWIDTH, "constantwidth") T(RI_CORNER, "corner") T(RI_CREASE, "crease") T(RI_CS, "Cs")              \
  T(RI_CUBIC, "cubic") T(RI_CURRENT, "current") T(RI_DEPTHCUE, "depthcue") T(RI_DIFFERENCE, "difference")        \
  T(RI_DISTANCE, "distance") T(RI_DISTANTLIGHT, "distantlight") T(RI_EYE, "eye") T(RI_FILE, "file")              \
  T(RI_FLATNESS, "flatness") T(RI_FOG, "fog") T(RI_FOV, "fov") T(RI_FRAMEBUFFER, "framebuffer")                  \
  T(RI_FROM, "from") T(RI_HANDLER, "handler") T(RI_HIDDEN, "hidden") T(RI_HOLE, "hole")                          \
  T(RI_IDENTIFIER, "identifier") T(RI_IGNORE, "ignore") T(RI_INSIDE, "inside") T(RI_INTENSITY, "intensity")      \
  T(RI_INTERPOLATEBOUNDARY, "interpolateboundary") T(RI_INTERSECTION, "intersection") T(RI_KA, "Ka")             \
  T(RI_KD, "Kd") T(RI_KR, "Kr") T(RI_KS, "Ks") T(RI_LH, "lh") T(RI_LIGHTCOLOR, "lightcolor")                     \
  T(RI_LINEAR, "linear") T(RI_MATTE, "matte") T(RI_MAXDISTANCE, "maxdistance") T(RI_METAL, "metal")              \
  T(RI_MINDISTANCE, "mindistance") T(RI_N, "N") T(RI_NAME, "name") T(RI_NDC, "NDC")                              \
  T(RI_NONPERIODIC, "nonperiodic") T(RI_NP, "Np") T(RI_OBJECT, "object") T(RI_ORIGIN, "origin")                  \
  T(RI_ORTHOGRAPHIC, "orthographic") T(RI_OS, "Os") T(RI_OUTSIDE, "outside") T(RI_P, "P")                        \
  T(RI_PAINT, "paint") T(RI_PAINTEDPLASTIC, "paintedplastic") T(RI_PERIODIC, "periodic")                         \
  T(RI_PERSPECTIVE, "perspective") T(RI_PLASTIC, "plastic") T(RI_POINTLIGHT, "pointlight")                       \
  T(RI_PRIMITIVE, "primitive") T(RI_PRINT, "print") T(RI_PW, "Pw") T(RI_PZ, "Pz") T(RI_RASTER, "raster")         \
  T(RI_RGB, "rgb") T(RI_RGBA, "rgba") T(RI_RGBAZ, "rgbaz") T(RI_RGBZ, "rgbz") T(RI_RH, "rh")                     \
  T(RI_ROUGHNESS, "roughness") T(RI_S, "s") T(RI_SCREEN, "screen") T(RI_SHADER, "shader")                        \
  T(RI_SHINYMETAL, "shinymetal") T(RI_SMOOTH, "smooth") T(RI_SPECULARCOLOR, "specularcolor")                     \
  T(RI_SPOTLIGHT, "spotlight") T(RI_ST, "st") T(RI_STRUCTURE, "structure") T(RI_T, "t")                          \
  T(RI_TEXTURENAME, "texturename") T(RI_TO, "to") T(RI_UNION, "union") T(RI_VERBATIM, "verbatim")                \
  T(RI_WIDTH, "width") T(RI_WORLD, "world") T(RI_Z, "z")

#define KINORA_RI_TOKEN(NAME, TEXT) extern RtToken NAME;
KINORA_RI_TOKENS(KINORA_RI_TOKEN)
#undef KINORA_RI_TOKEN

extern RtInt RiLastError;
extern RtBasis RiBezierBasis, RiBSplineBasis, RiCatmullRomBasis, RiHermiteBasis, RiPowerBasis;

/* Standard filters, error handlers and procedurals: they are recognised where they are given. */
RtFloat RiBoxFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth);
RtFloat RiTriangleFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth);
RtFloat RiCatmullRomFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth);
RtFloat RiGaussianFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth);
RtFloat RiSincFilter(RtFloat x, RtFloat y, RtFloat xwidth, RtFloat ywidth);
RtVoid RiErrorIgnore(RtInt code, RtInt severity, char* message);
RtVoid RiErrorPrint(RtInt code, RtInt severity, char* message);
RtVoid RiErrorAbort(RtInt code, RtInt severity, char* message);
RtVoid RiProcDelayedReadArchive(RtPointer data, RtFloat detail); /* data: one string */
RtVoid RiProcRunProgram(RtPointer data, RtFloat detail);         /* two */
RtVoid RiProcDynamicLoad(RtPointer data, RtFloat detail);        /* two */
RtVoid RiProcFree(RtPointer data);

/* Calls of Begin, End and contexts do nothing: there is one stream, and it is open. */
RtVoid RiBegin(RtToken name);
RtVoid RiEnd(void);
RtContextHandle RiGetContext(void);
RtVoid RiContext(RtContextHandle context);
RtToken RiDeclare(char* name, char* declaration);
RtVoid RiErrorHandler(RtErrorHandler handler);

RtVoid RiFrameBegin(RtInt frame);
RtVoid RiFrameEnd(void);
RtVoid RiWorldBegin(void);
RtVoid RiWorldEnd(void);
RtVoid RiAttributeBegin(void);
RtVoid RiAttributeEnd(void);
RtVoid RiTransformBegin(void);
RtVoid RiTransformEnd(void);
RtVoid RiSolidBegin(RtToken operation);
RtVoid RiSolidEnd(void);
RtVoid RiMotionBegin(RtInt n, ...); /* n times, as double or float */
RtVoid RiMotionBeginV(RtInt n, RtFloat times[]);
RtVoid RiMotionEnd(void);
RtObjectHandle RiObjectBegin(void);
RtVoid RiObjectEnd(void);
RtVoid RiObjectInstance(RtObjectHandle object);
RtVoid RiArchiveRecord(RtToken type, char* format, ...); /* printf */
RtVoid RiReadArchive(RtToken name, RtArchiveCallback callback, ...);
RtVoid RiReadArchiveV(RtToken name, RtArchiveCallback callback, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiArchiveBegin(RtToken name, ...);
RtVoid RiArchiveBeginV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiArchiveEnd(void);

RtVoid RiIdentity(void);
RtVoid RiTransform(RtMatrix m);
RtVoid RiConcatTransform(RtMatrix m);
RtVoid RiPerspective(RtFloat fov);
RtVoid RiTranslate(RtFloat dx, RtFloat dy, RtFloat dz);
RtVoid RiRotate(RtFloat angle, RtFloat dx, RtFloat dy, RtFloat dz); /* degrees */
RtVoid RiScale(RtFloat sx, RtFloat sy, RtFloat sz);
RtVoid RiSkew(RtFloat angle, RtFloat dx1, RtFloat dy1, RtFloat dz1, RtFloat dx2, RtFloat dy2, RtFloat dz2);
RtVoid RiCoordinateSystem(RtToken space);
RtVoid RiScopedCoordinateSystem(RtToken space);
RtVoid RiCoordSysTransform(RtToken space);
/* Spaces are not known before the archive is read: null, and the points stay as they are. */
RtPoint* RiTransformPoints(RtToken from, RtToken to, RtInt n, RtPoint points[]);

RtVoid RiFormat(RtInt xresolution, RtInt yresolution, RtFloat pixelaspect);
RtVoid RiFrameAspectRatio(RtFloat aspect);
RtVoid RiScreenWindow(RtFloat left, RtFloat right, RtFloat bottom, RtFloat top);
RtVoid RiCropWindow(RtFloat xmin, RtFloat xmax, RtFloat ymin, RtFloat ymax);
RtVoid RiProjection(RtToken name, ...);
RtVoid RiProjectionV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiClipping(RtFloat hither, RtFloat yon);
RtVoid RiClippingPlane(RtFloat x, RtFloat y, RtFloat z, RtFloat nx, RtFloat ny, RtFloat nz);
RtVoid RiDepthOfField(RtFloat fstop, RtFloat focallength, RtFloat focaldistance);
RtVoid RiShutter(RtFloat opening, RtFloat closing);
RtVoid RiPixelVariance(RtFloat variance);
RtVoid RiPixelSamples(RtFloat x, RtFloat y);
RtVoid RiPixelFilter(RtFilterFunc filter, RtFloat xwidth, RtFloat ywidth);
RtVoid RiExposure(RtFloat gain, RtFloat gamma);
RtVoid RiImager(RtToken name, ...);
RtVoid RiImagerV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiQuantize(RtToken type, RtInt one, RtInt min, RtInt max, RtFloat dither);
RtVoid RiDisplay(RtToken name, RtToken type, RtToken mode, ...);
RtVoid RiDisplayV(RtToken name, RtToken type, RtToken mode, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiHider(RtToken type, ...);
RtVoid RiHiderV(RtToken type, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiColorSamples(RtInt n, RtFloat nRGB[], RtFloat RGBn[]);
RtVoid RiRelativeDetail(RtFloat factor);
RtVoid RiOption(RtToken name, ...);
RtVoid RiOptionV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);

RtVoid RiColor(RtColor color);
RtVoid RiOpacity(RtColor opacity);
RtVoid RiTextureCoordinates(RtFloat s1, RtFloat t1, RtFloat s2, RtFloat t2, RtFloat s3, RtFloat t3, RtFloat s4,
                            RtFloat t4);
RtLightHandle RiLightSource(RtToken name, ...);
RtLightHandle RiLightSourceV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtLightHandle RiAreaLightSource(RtToken name, ...);
RtLightHandle RiAreaLightSourceV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiIlluminate(RtLightHandle light, RtBoolean on);
RtVoid RiSurface(RtToken name, ...);
RtVoid RiSurfaceV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiDisplacement(RtToken name, ...);
RtVoid RiDisplacementV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiAtmosphere(RtToken name, ...);
RtVoid RiAtmosphereV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiInterior(RtToken name, ...);
RtVoid RiInteriorV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiExterior(RtToken name, ...);
RtVoid RiExteriorV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
/* Plug-ins by name, each with a handle that others name it by. */
RtVoid RiPattern(RtToken name, RtToken handle, ...);
RtVoid RiPatternV(RtToken name, RtToken handle, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiBxdf(RtToken name, RtToken handle, ...);
RtVoid RiBxdfV(RtToken name, RtToken handle, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiDisplace(RtToken name, RtToken handle, ...);
RtVoid RiDisplaceV(RtToken name, RtToken handle, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiShadingRate(RtFloat size);
RtVoid RiShadingInterpolation(RtToken type);
RtVoid RiMatte(RtBoolean on);
RtVoid RiBound(RtBound bound);
RtVoid RiDetail(RtBound bound);
RtVoid RiDetailRange(RtFloat minvisible, RtFloat lower, RtFloat upper, RtFloat maxvisible);
RtVoid RiGeometricApproximation(RtToken type, RtFloat value);
RtVoid RiOrientation(RtToken orientation);
RtVoid RiReverseOrientation(void);
RtVoid RiSides(RtInt sides);
RtVoid RiBasis(RtBasis ubasis, RtInt ustep, RtBasis vbasis, RtInt vstep);
RtVoid RiTrimCurve(RtInt nloops, RtInt ncurves[], RtInt order[], RtFloat knot[], RtFloat min[], RtFloat max[],
                   RtInt n[], RtFloat u[], RtFloat v[], RtFloat w[]);
RtVoid RiAttribute(RtToken name, ...);
RtVoid RiAttributeV(RtToken name, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiResource(RtToken handle, RtToken type, ...);
RtVoid RiResourceV(RtToken handle, RtToken type, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiResourceBegin(void);
RtVoid RiResourceEnd(void);
RtVoid RiIfBegin(RtToken expression, ...);
RtVoid RiIfBeginV(RtToken expression, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiElseIf(RtToken expression, ...);
RtVoid RiElseIfV(RtToken expression, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiElse(void);
RtVoid RiIfEnd(void);

RtVoid RiSphere(RtFloat radius, RtFloat zmin, RtFloat zmax, RtFloat thetamax, ...);
RtVoid RiSphereV(RtFloat radius, RtFloat zmin, RtFloat zmax, RtFloat thetamax, RtInt n, RtToken tokens[],
                 RtPointer values[]);
RtVoid RiCone(RtFloat height, RtFloat radius, RtFloat thetamax, ...);
RtVoid RiConeV(RtFloat height, RtFloat radius, RtFloat thetamax, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiCylinder(RtFloat radius, RtFloat zmin, RtFloat zmax, RtFloat thetamax, ...);
RtVoid RiCylinderV(RtFloat radius, RtFloat zmin, RtFloat zmax, RtFloat thetamax, RtInt n, RtToken tokens[],
                   RtPointer values[]);
RtVoid RiHyperboloid(RtPoint point1, RtPoint point2, RtFloat thetamax, ...);
RtVoid RiHyperboloidV(RtPoint point1, RtPoint point2, RtFloat thetamax, RtInt n, RtToken tokens[],
                      RtPointer values[]);
RtVoid RiParaboloid(RtFloat rmax, RtFloat zmin, RtFloat zmax, RtFloat thetamax, ...);
RtVoid RiParaboloidV(RtFloat rmax, RtFloat zmin, RtFloat zmax, RtFloat thetamax, RtInt n, RtToken tokens[],
                     RtPointer values[]);
RtVoid RiDisk(RtFloat height, RtFloat radius, RtFloat thetamax, ...);
RtVoid RiDiskV(RtFloat height, RtFloat radius, RtFloat thetamax, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiTorus(RtFloat majorradius, RtFloat minorradius, RtFloat phimin, RtFloat phimax, RtFloat thetamax, ...);
RtVoid RiTorusV(RtFloat majorradius, RtFloat minorradius, RtFloat phimin, RtFloat phimax, RtFloat thetamax, RtInt n,
                RtToken tokens[], RtPointer values[]);
RtVoid RiPolygon(RtInt nvertices, ...);
RtVoid RiPolygonV(RtInt nvertices, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiGeneralPolygon(RtInt nloops, RtInt nverts[], ...);
RtVoid RiGeneralPolygonV(RtInt nloops, RtInt nverts[], RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiPointsPolygons(RtInt npolys, RtInt nverts[], RtInt verts[], ...);
RtVoid RiPointsPolygonsV(RtInt npolys, RtInt nverts[], RtInt verts[], RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiPointsGeneralPolygons(RtInt npolys, RtInt nloops[], RtInt nverts[], RtInt verts[], ...);
RtVoid RiPointsGeneralPolygonsV(RtInt npolys, RtInt nloops[], RtInt nverts[], RtInt verts[], RtInt n,
                                RtToken tokens[], RtPointer values[]);
RtVoid RiSubdivisionMesh(RtToken scheme, RtInt nfaces, RtInt nverts[], RtInt verts[], RtInt ntags, RtToken tags[],
                         RtInt nargs[], RtInt intargs[], RtFloat floatargs[], ...);
RtVoid RiSubdivisionMeshV(RtToken scheme, RtInt nfaces, RtInt nverts[], RtInt verts[], RtInt ntags, RtToken tags[],
                          RtInt nargs[], RtInt intargs[], RtFloat floatargs[], RtInt n, RtToken tokens[],
                          RtPointer values[]);
RtVoid RiPatch(RtToken type, ...);
RtVoid RiPatchV(RtToken type, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiPatchMesh(RtToken type, RtInt nu, RtToken uwrap, RtInt nv, RtToken vwrap, ...);
RtVoid RiPatchMeshV(RtToken type, RtInt nu, RtToken uwrap, RtInt nv, RtToken vwrap, RtInt n, RtToken tokens[],
                    RtPointer values[]);
RtVoid RiNuPatch(RtInt nu, RtInt uorder, RtFloat uknot[], RtFloat umin, RtFloat umax, RtInt nv, RtInt vorder,
                 RtFloat vknot[], RtFloat vmin, RtFloat vmax, ...);
RtVoid RiNuPatchV(RtInt nu, RtInt uorder, RtFloat uknot[], RtFloat umin, RtFloat umax, RtInt nv, RtInt vorder,
                  RtFloat vknot[], RtFloat vmin, RtFloat vmax, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiCurves(RtToken type, RtInt ncurves, RtInt nvertices[], RtToken wrap, ...);
RtVoid RiCurvesV(RtToken type, RtInt ncurves, RtInt nvertices[], RtToken wrap, RtInt n, RtToken tokens[],
                 RtPointer values[]);
RtVoid RiPoints(RtInt npoints, ...);
RtVoid RiPointsV(RtInt npoints, RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiBlobby(RtInt nleaf, RtInt ncode, RtInt code[], RtInt nfloats, RtFloat floats[], RtInt nstrings,
                RtToken strings[], ...);
RtVoid RiBlobbyV(RtInt nleaf, RtInt ncode, RtInt code[], RtInt nfloats, RtFloat floats[], RtInt nstrings,
                 RtToken strings[], RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiVolume(RtToken type, RtBound bound, RtInt nvertices[3], ...);
RtVoid RiVolumeV(RtToken type, RtBound bound, RtInt nvertices[3], RtInt n, RtToken tokens[], RtPointer values[]);
RtVoid RiGeometry(RtToken type, ...);
RtVoid RiGeometryV(RtToken type, RtInt n, RtToken tokens[], RtPointer values[]);
/* Where subdivide is none of RiProc..., it is called at once, with the share of the detail that this bound has of that of
 * the object, down to 64 calls within each other. */
RtVoid RiProcedural(RtPointer data, RtBound bound, RtProcSubdivFunc subdivide, RtProcFreeFunc release);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif
#ifdef __cplusplus
}
#endif
#endif
