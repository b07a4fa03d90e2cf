/* Calls every function of the interface once, where RIB allows its request. */
#include <kinora/ri.h>
#include <stdlib.h>

RtPointer ConvertParameters(char* data) {
  (void)data;
  return NULL;
}
RtVoid Free(RtPointer data) { (void)data; }

static RtFloat numbers[256];
static RtMatrix unit = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};

static void options(void) {
  RtFloat one = 1, fov = 40;
  RtInt samples = 4;
  RtFloat toRgb[3] = {1, 1, 1};
  RiBegin(RI_NULL);
  RiContext(RiGetContext());
  RiErrorHandler(RiErrorPrint);
  RiErrorIgnore(0, 0, "");
  RiDeclare("mine", "uniform float");
  RiArchiveRecord(RI_COMMENT, " %d words", 2);
  RiArchiveRecord(RI_STRUCTURE, "%s", "RenderMan RIB-Structure 1.1");
  RiOption("user", "float a", (RtPointer)&one, RI_NULL);
  RiFormat(64, 48, 1);
  RiFrameAspectRatio(4.f / 3);
  RiScreenWindow(-1, 1, -.75f, .75f);
  RiCropWindow(0, 1, 0, 1);
  RiProjection(RI_PERSPECTIVE, RI_FOV, (RtPointer)&fov, RI_NULL);
  RiClipping(.1f, 1000);
  RiClippingPlane(0, 0, -9, 0, 0, 1);
  RiDepthOfField(RI_INFINITY, 1, 1);
  RiShutter(0, 1);
  RiPixelVariance(.01f);
  RiPixelSamples(2, 2);
  RiPixelFilter(RiGaussianFilter, 2, 2);
  RiPixelFilter(RiBoxFilter, 1, 1);
  RiPixelFilter(RiTriangleFilter, 2, 2);
  RiPixelFilter(RiSincFilter, 4, 4);
  RiPixelFilter(RiCatmullRomFilter, 4, 4);
  RiExposure(1, 1);
  RiImager("background", RI_NULL);
  RiQuantize("rgba", 255, 0, 255, .5f);
  RiDisplay("every.exr", "openexr", RI_RGBA, RI_NULL);
  RiHider("raytrace", "int maxsamples", (RtPointer)&samples, RI_NULL);
  RiColorSamples(1, toRgb, toRgb);
  RiRelativeDetail(1);
}

static void attributes(void) {
  RtFloat intensity = 2, x = 1;
  RtColor white = {1, 1, 1};
  RtBound bound = {-1, 1, -1, 1, -1, 1};
  RtLightHandle light = RiLightSource("distantlight", RI_INTENSITY, (RtPointer)&intensity, RI_NULL);
  RiIlluminate(light, RI_TRUE);
  RiAttribute("user", "float b", (RtPointer)&x, RI_NULL);
  RiAttributeBegin();
  RiAreaLightSource("arealight", RI_INTENSITY, (RtPointer)&intensity, RI_NULL);
  RiSphere(.1f, -.1f, .1f, 360, RI_NULL);
  RiAttributeEnd();
  RiColor(white);
  RiOpacity(white);
  RiTextureCoordinates(0, 0, 1, 0, 0, 1, 1, 1);
  RiSurface(RI_MATTE, "float Kd", (RtPointer)&x, RI_NULL);
  RiDisplacement("bumps", RI_NULL);
  RiAtmosphere(RI_FOG, RI_NULL);
  RiInterior("inside", RI_NULL);
  RiExterior("outside", RI_NULL);
  RiPattern("PxrVary", "pattern", RI_NULL);
  RiBxdf("PxrDiffuse", "bxdf", "color diffuseColor", (RtPointer)white, RI_NULL);
  RiDisplace("PxrDisplace", "displace", RI_NULL);
  RiShadingRate(1);
  RiShadingInterpolation(RI_SMOOTH);
  RiMatte(RI_FALSE);
  RiBound(bound);
  RiDetail(bound);
  RiDetailRange(0, 0, 1e30f, 1e30f);
  RiGeometricApproximation(RI_FLATNESS, .5f);
  RiOrientation(RI_OUTSIDE);
  RiReverseOrientation();
  RiReverseOrientation();
  RiSides(2);
  RiBasis(RiHermiteBasis, 2, RiPowerBasis, 4);
  RiBasis(RiCatmullRomBasis, 1, RiBSplineBasis, 1);
  RiBasis(RiBezierBasis, 3, RiBezierBasis, 3);
  RiResourceBegin();
  RiResource("kept", "attributes", "string operation", (RtPointer) & (RtString){"save"}, RI_NULL);
  RiResourceEnd();
  RiIfBegin("1 == 1", RI_NULL);
  RiElseIf("1 == 2", RI_NULL);
  RiElse();
  RiIfEnd();
}

static void transforms(void) {
  RiTransformBegin();
  RiIdentity();
  RiTransform(unit);
  RiConcatTransform(unit);
  RiPerspective(90);
  RiIdentity();
  RiTranslate(0, 0, 5);
  RiRotate(30, 0, 1, 0);
  RiScale(1, 2, 1);
  RiSkew(10, 0, 1, 0, 1, 0, 0);
  RiCoordinateSystem("here");
  RiScopedCoordinateSystem("there");
  RiCoordSysTransform("here");
  RiTransformPoints("here", "there", 1, (RtPoint*)numbers);
  RiTransformEnd();
  RiMotionBegin(2, 0., 1.);
  RiTranslate(0, 0, 0);
  RiTranslate(0, 0, 1);
  RiMotionEnd();
}

static void primitives(void) {
  RtPoint square[4] = {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, one = {1, 0, 0}, two = {1, 0, 1};
  RtPoint flat[16];
  RtInt four[2] = {4, 4}, corners[8] = {0, 1, 2, 3, 3, 2, 1, 0}, loops[2] = {1, 1}, segments[2] = {4, 4};
  RtFloat knots[4] = {0, 0, 1, 1}, width[2] = {.1f, .1f},
          ball[16] = {.3f, 0, 0, 0, 0, .3f, 0, 0, 0, 0, .3f, 0, 0, 0, 0, 1};
  RtFloat low = 0, high = 1, corner = 2, cu[2] = {.2f, .8f}, ck[4] = {0, 0, 1, 1};
  RtFloat w1[2] = {1, 1};
  RtInt code[2] = {1001, 0}, size[3] = {1, 1, 1}, curve = 1, order = 2, points = 2, tagCounts[2] = {1, 1}, tagInt = 0;
  RtToken tags[1] = {RI_CORNER};
  RtBound bound = {-1, 1, -1, 1, -1, 1};
  RtObjectHandle object;
  int i;
  for (i = 0; i < 16; ++i) flat[i][0] = i % 4, flat[i][1] = i / 4, flat[i][2] = 0;
  RiSphere(1, -1, 1, 360, RI_NULL);
  RiCone(1, 1, 360, RI_NULL);
  RiCylinder(1, 0, 1, 360, RI_NULL);
  RiHyperboloid(one, two, 360, RI_NULL);
  RiParaboloid(1, 0, 1, 360, RI_NULL);
  RiDisk(0, 1, 360, RI_NULL);
  RiTorus(1, .2f, 0, 360, 360, RI_NULL);
  RiPolygon(4, RI_P, (RtPointer)square, RI_NULL);
  RiGeneralPolygon(1, four, RI_P, (RtPointer)square, RI_NULL);
  RiPointsPolygons(2, four, corners, RI_P, (RtPointer)square, RI_NULL);
  RiPointsGeneralPolygons(2, loops, four, corners, RI_P, (RtPointer)square, RI_NULL);
  RiSubdivisionMesh(RI_CATMULLCLARK, 1, four, corners, 1, tags, tagCounts, &tagInt, &corner, RI_P, (RtPointer)square,
                    RI_NULL);
  RiPatch(RI_BILINEAR, RI_P, (RtPointer)square, RI_NULL);
  RiPatch(RI_BICUBIC, RI_P, (RtPointer)flat, RI_NULL);
  RiPatchMesh(RI_BICUBIC, 4, RI_NONPERIODIC, 4, RI_NONPERIODIC, RI_P, (RtPointer)flat, RI_NULL);
  RiTrimCurve(1, &curve, &order, ck, &low, &high, &points, cu, cu, w1);
  RiNuPatch(2, 2, knots, low, high, 2, 2, knots, low, high, RI_P, (RtPointer)square, RI_NULL);
  RiCurves(RI_CUBIC, 2, segments, RI_NONPERIODIC, RI_P, (RtPointer)flat, RI_CONSTANTWIDTH, (RtPointer)width, RI_NULL);
  RiPoints(4, RI_P, (RtPointer)square, RI_CONSTANTWIDTH, (RtPointer)width, RI_NULL);
  RiBlobby(1, 2, code, 16, ball, 0, NULL, RI_NULL);
  RiVolume("box", bound, size, RI_NULL);
  RiGeometry("teapot", RI_NULL);
  RiSolidBegin(RI_PRIMITIVE);
  RiSphere(1, -1, 1, 360, RI_NULL);
  RiSolidEnd();
  object = RiObjectBegin();
  RiSphere(1, -1, 1, 360, RI_NULL);
  RiObjectEnd();
  RiObjectInstance(object);
  RiArchiveBegin("inline", RI_NULL);
  RiSphere(1, -1, 1, 360, RI_NULL);
  RiArchiveEnd();
  RiReadArchive("inline", NULL, RI_NULL);
}

RtVoid Subdivide(RtPointer data, RtFloat detail) {
  (void)data;
  (void)detail;
  RiFrameBegin(1);
  options();
  RiWorldBegin();
  attributes();
  transforms();
  primitives();
  RiWorldEnd();
  RiFrameEnd();
  RiEnd();
}
