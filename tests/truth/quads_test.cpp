// Proves: place and primvars on quads follow the bilinear (u, v) of the whole quad, not its two triangles: polygons,
// patches and subdivision faces, baked, placed and moving, against closed forms; diced surfaces follow their own
// parameters; no pixel falls between triangles when samples do not jitter. Misses: quads that are not flat, whose
// places have no closed form along the facets (geometry/surface_test.cpp holds continuity).
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

constexpr int kSize = 48;

// A primvar shown as it is, one sample at the middle of each pixel.
image::Image shown(const std::string& geometry, const std::string& name, const std::string& type,
                   const std::string& head = "") {
  RenderRequest r;
  r.rib =
      "Format " + std::to_string(kSize) + " " + std::to_string(kSize) +
      " 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [1] \"int minsamples\" [1] \"int jitter\" "
      "[0]\nShutter 0 1\nScreenWindow -1 1 -1 1\nProjection \"orthographic\"\n" +
      head + "WorldBegin\nTranslate 0 0 2\nPattern \"PxrPrimvar\" \"p\" \"string varname\" [\"" + name +
      "\"] \"string type\" [\"" + type +
      "\"]\nBxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"p:resultRGB\"]\n" + geometry + "WorldEnd\n";
  SceneRender s(r);
  EXPECT_TRUE(s.ok()) << geometry;
  return s.ok() ? s.channel("Ci") : image::Image();
}

// Calls `visit` with each pixel's place on the plane and its colour; says how many it met.
int pixels(const image::Image& picture, const std::function<void(double, double, const float*)>& visit) {
  int n = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x, ++n)
      visit(2 * (x + 0.5) / kSize - 1, 1 - 2 * (y + 0.5) / kSize, picture.at(x, y));
  return n;
}

// Bottom from -0.9 to 0.9 at y = -0.8, top from -0.2 to 0.3 at 0.8: (u, v) of a point inside.
struct Trapezoid {
  static constexpr const char* kPoints = "[-.9 -.8 0  .9 -.8 0  .3 .8 0  -.2 .8 0]";
  static bool place(double x, double y, double& u, double& v) {
    v = (y + 0.8) / 1.6;
    const double left = -0.9 + 0.7 * v, right = 0.9 - 0.6 * v;
    u = (x - left) / (right - left);
    return u > 0.03 && u < 0.97 && v > 0.03 && v < 0.97;
  }
};

void expectTrapezoid(const image::Image& picture, const std::string& what, double swapped = 0) {
  int inside = 0;
  pixels(picture, [&](double x, double y, const float* c) {
    double u, v;
    if (!Trapezoid::place(x, y, u, v)) return;
    ++inside;
    const double wantU = swapped ? v : u, wantV = swapped ? u : v;
    ASSERT_NEAR(double(c[0]), wantU, 2e-5) << what << " at " << x << ", " << y;
    ASSERT_NEAR(double(c[1]), wantV, 2e-5) << what << " at " << x << ", " << y;
  });
  EXPECT_GT(inside, 500) << what;
}

TEST(Quads, TextureCoordinatesOfATrapezoid) {
  const std::string points = Trapezoid::kPoints;
  const std::string st = " \"facevarying float[2] st\" [0 0 1 0 1 1 0 1]\n";
  const std::string polygon = "Polygon \"P\" " + points + st;
  expectTrapezoid(shown(polygon, "st", "float2"), "a polygon");
  // among other kinds of faces, without any st, and by s and t
  expectTrapezoid(
      shown("PointsPolygons [3 4 5] [4 5 6  0 1 2 3  4 5 6 7 8] \"P\" [-.9 -.8 0  .9 -.8 0  .3 .8 0  -.2 .8 0  "
            "5 5 0  6 5 0  6 6 0  5.5 6 0  5 5.5 0]\n",
            "st", "float2"),
      "a quad of a mixed mesh, by its own parameters");
  expectTrapezoid(shown("Polygon \"P\" " + points + " \"s\" [0 1 1 0] \"t\" [0 0 1 1]\n", "st", "float2"), "s and t");
  expectTrapezoid(shown("Patch \"bilinear\" \"P\" [-.9 -.8 0  .9 -.8 0  -.2 .8 0  .3 .8 0]\n", "st", "float2"),
                  "a patch");
  expectTrapezoid(
      shown("SubdivisionMesh \"bilinear\" [4] [0 1 2 3] [] [] [] [] \"P\" " + points + st, "st", "float2"),
      "a subdivision face");
  // placed by an instance, and turned
  expectTrapezoid(
      shown("ObjectBegin \"q\"\n" + polygon + "ObjectEnd\nScale -1 1 1\nScale -1 1 1\nObjectInstance \"q\"\n", "st",
            "float2"),
      "an instance");
  expectTrapezoid(shown("Polygon \"P\" [-.9 -.8 0  -.2 .8 0  .3 .8 0  .9 -.8 0]" + st, "st", "float2"),
                  "the other way round", 1);
  // s = .652 came out here, on the triangles
  const image::Image picture = shown("Polygon \"P\" [-1 -1 0 1 -1 0 .2 1 0 -.2 1 0]" + st, "st", "float2");
  int found = 0;
  pixels(picture, [&](double x, double y, const float* c) {
    const double v = (y + 1) / 2, half = 1 - 0.8 * v, u = (x + half) / (2 * half);
    if (u < 0.02 || u > 0.98 || v > 0.98) return;
    ++found;
    EXPECT_NEAR(double(c[0]), u, 3e-5);
  });
  EXPECT_GT(found, 500);
}

TEST(Quads, MovingCornersTakePlaceAlong) {
  // Both keys are rectangles; in between the side corners run at their own speed. With the shutter at a moment, place
  // is that of the quad at this moment.
  const std::string st = " \"facevarying float[2] st\" [0 0 1 0 1 1 0 1]\n";
  const std::string moving = "MotionBegin [-1 1]\nPolygon \"P\" [-1.7 -.8 0  1.6 -.8 0  .5 .8 0  -.3 .8 0]" + st +
                             "Polygon \"P\" [-.1 -.8 0  .2 -.8 0  .1 .8 0  -.1 .8 0]" + st + "MotionEnd\n";
  expectTrapezoid(shown(moving, "st", "float2", "Shutter 0 0\n"), "between two keys");
}

TEST(Quads, FourColoursOfASquare) {
  const double colour[4][3] = {{1, 0, 0.2}, {0, 1, 0.8}, {0.9, 0.1, 0.5}, {0.2, 0.7, 0}};
  std::string list;
  for (const auto& c : colour)
    for (const double x : c) list += std::to_string(x) + " ";
  const std::string points = "[-1 -1 0  1 -1 0  1 1 0  -1 1 0]";
  const std::string patch = "[-1 -1 0  1 -1 0  -1 1 0  1 1 0]";
  std::string rows;
  for (const int k : {0, 1, 3, 2})
    for (const double x : colour[k]) rows += std::to_string(x) + " ";
  for (const std::string& geometry :
       {"Polygon \"P\" " + points + " \"varying color tint\" [" + list + "]\n",
        "Polygon \"P\" " + points + " \"facevarying color tint\" [" + list + "]\n",
        "SubdivisionMesh \"bilinear\" [4] [0 1 2 3] [] [] [] [] \"P\" " + points + " \"vertex color tint\" [" + list +
            "]\n",
        "Patch \"bilinear\" \"P\" " + patch + " \"varying color tint\" [" + rows + "]\n"}) {
    pixels(shown(geometry, "tint", "color"), [&](double x, double y, const float* c) {
      const double u = (x + 1) / 2, v = (y + 1) / 2;
      for (int k = 0; k < 3; ++k) {
        const double expected =
            (1 - v) * ((1 - u) * colour[0][k] + u * colour[1][k]) + v * ((1 - u) * colour[3][k] + u * colour[2][k]);
        ASSERT_NEAR(double(c[k]), expected, 1e-5) << geometry;
      }
    });
  }
}

// A uniform cubic spline through a flat cage of n x n faces with smooth corners: where the cage is even its points
// are at their own places, and a value at the vertices follows the tensor product of B-splines, mirrored beyond the
// border.
TEST(Quads, ValuesOfACatmullClarkCage) {
  const double value[4][4] = {{0, 0.2, 0.9, 0.1}, {0.4, 1, 0.1, 0.6}, {0.7, 0, 0.8, 0.3}, {0.2, 0.5, 0.4, 1}};
  std::string points, values, faces;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      points += std::to_string(-1 + 2.0 * i / 3) + " " + std::to_string(-1 + 2.0 * j / 3) + " 0 ";
      values += std::to_string(value[j][i]) + " ";
      if (i < 3 && j < 3)
        for (const int k : {0, 1, 5, 4}) faces += std::to_string(4 * j + i + k) + " ";
    }
  const image::Image picture = shown("SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4 4 4 4] [" + faces +
                                         "] [\"interpolateboundary\"] [1 0] [1] [] \"P\" [" + points +
                                         "] \"vertex float heat\" [" + values + "]\n",
                                     "heat", "float");
  const auto at = [&](int i, int j) {
    const auto along = [&](int row, int k) {
      if (k < 0) return 2 * value[row][0] - value[row][1];
      if (k > 3) return 2 * value[row][3] - value[row][2];
      return value[row][k];
    };
    if (j < 0) return 2 * along(0, i) - along(1, i);
    if (j > 3) return 2 * along(3, i) - along(2, i);
    return along(j, i);
  };
  const auto weights = [](double t, double w[4]) {
    w[0] = (1 - t) * (1 - t) * (1 - t) / 6;
    w[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    w[2] = (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
    w[3] = t * t * t / 6;
  };
  double worst = 0;
  pixels(picture, [&](double x, double y, const float* c) {
    const double s = (x + 1) * 1.5, t = (y + 1) * 1.5;
    const int i = std::min(2, int(s)), j = std::min(2, int(t));
    double wu[4], wv[4], expected = 0;
    weights(s - i, wu);
    weights(t - j, wv);
    for (int b = 0; b < 4; ++b)
      for (int a = 0; a < 4; ++a) expected += wu[a] * wv[b] * at(i - 1 + a, j - 1 + b);
    worst = std::max(worst, std::abs(expected - double(c[0])));
  });
  EXPECT_LT(worst,
            4 / 256.0);  // .17 as two triangles a face; dicing leaves 1/256 along a line, more where rates change
}

TEST(Quads, FlatPatchesFollowTheirOwnParameters) {
  // x(u) = -1 + 2 (3 u (1 - u)^2 a + 3 u^2 (1 - u) b + u^3) with control points at 0, a = .1, b = .3, 1.
  std::string points;
  for (int j = 0; j < 4; ++j)
    for (const double x : {0.0, 0.1, 0.3, 1.0})
      points += std::to_string(-1 + 2 * x) + " " + std::to_string(-1 + 2.0 * j / 3) + " 0 ";
  double worst = 0;
  pixels(shown("Patch \"bicubic\" \"P\" [" + points + "]\n", "st", "float2"), [&](double x, double y,
                                                                                  const float* c) {
    double low = 0, high = 1;
    for (int k = 0; k < 50; ++k) {
      const double u = (low + high) / 2, p = 3 * u * (1 - u) * (1 - u) * 0.1 + 3 * u * u * (1 - u) * 0.3 + u * u * u;
      (2 * p - 1 < x ? low : high) = u;
    }
    worst = std::max({worst, std::abs(low - double(c[0])), std::abs((y + 1) / 2 - double(c[1]))});
  });
  EXPECT_LT(worst, 0.015);
}

TEST(Quads, NoPixelFallsBetweenTriangles) {
  // Turned by 45 degrees, rays of a regular grid meet shared edges exactly.
  std::string grid;
  for (int j = 0; j < 17; ++j)
    for (int i = 0; i < 17; ++i)
      grid += std::to_string(-6 + 12.0 * i / 16) + " " + std::to_string(-6 + 12.0 * j / 16) + " 0 ";
  for (const char* turn : {"", "Rotate 45 0 0 1\n", "Rotate 45 0 0 1\nRotate 45 0 1 0\n"})
    for (const char* projection : {"Projection \"orthographic\"\n", "Projection \"perspective\" \"fov\" [20]\n"}) {
      RenderRequest r;
      r.rib = std::string(
                  "Format 256 256 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [1] \"int "
                  "minsamples\" "
                  "[1] \"int jitter\" [0]\nScreenWindow -1 1 -1 1\n") +
              projection + "WorldBegin\nTranslate 0 0 5\n" + turn +
              "Bxdf \"PxrConstant\" \"c\"\nPatchMesh \"bilinear\" 17 \"nonperiodic\" 17 \"nonperiodic\" \"P\" [" +
              grid + "]\nWorldEnd\n";
      SceneRender s(r);
      ASSERT_TRUE(s.ok());
      int holes = 0;
      const image::Image alpha = s.channel("a");
      for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x) holes += alpha.at(x, y)[0] < 1;
      EXPECT_EQ(holes, 0) << turn << projection;
    }
  // an eye that lies on a surface looks past it
  const image::Image beyond = shown(
      "Translate 0 0 -2\nPolygon \"P\" [-9 0 -9  9 0 -9  9 0 9  -9 0 9] \"constant float x\" [5]\n"
      "Polygon \"P\" [-9 -9 4  9 -9 4  9 9 4  -9 9 4] \"constant float x\" [7]\n",
      "x", "float", "Projection \"perspective\" \"fov\" [40]\n");
  int past = 0;
  pixels(beyond, [&](double, double, const float* c) { past += c[0] == 7; });
  EXPECT_GT(past, kSize * kSize * 9 / 10);
}

}  // namespace
}  // namespace kinora::tests
