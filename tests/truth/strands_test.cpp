// Proves: moving curves and points cover pixels as integrals over the shutter say, within 0.3 %; deforming meshes
// with uneven keys and shutters that open slowly too; nothing of a curve or point shades itself; parameters and
// primvars are where they belong. Misses: curved pieces seen from close by (their outline is Embree's).
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = 3.14159265358979;
const char* const kGlowing = "Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [1 1 1]\n";

// A window of 4 x 2 that parallel rays cover, shutter 0..1; `more` goes before the world.
std::string window(int samples, const std::string& more = "") {
  return "Format 32 16 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" +
         std::to_string(samples) + "]\nScreenWindow -2 2 -1 1\nShutter 0 1\nProjection \"orthographic\"\n" + more;
}
struct Covered {
  double area = 0, first = 0, second = 0;  // in the window's units; moments of x
};
Covered covered(const std::string& rib, const char* name) {
  RenderRequest r;
  r.rib = rib;
  SceneRender render(r);
  EXPECT_TRUE(render.ok()) << name;
  Covered c;
  if (!render.ok()) return c;
  const image::Image alpha = render.channel("a");
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      const double a = alpha.at(x, y)[0] / 64, at = -2 + (x + 0.5) / 8;
      c.area += a;
      c.first += a * at;
      c.second += a * at * at;
    }
  c.first /= c.area;
  c.second /= c.area;
  return c;
}
// `still` moving along x from -1 to 1 as deformation: {P} is replaced by points.
std::string moved(const std::string& before, const std::vector<double>& points, const std::string& after) {
  std::string out = "MotionBegin [0 1]\n";
  for (const double shift : {-1.0, 1.0}) {
    out += before + " \"P\" [";
    for (size_t i = 0; i < points.size(); ++i) out += std::to_string(points[i] + (i % 3 == 0 ? shift : 0)) + " ";
    out += "] " + after + "\n";
  }
  return out + "MotionEnd\n";
}

// Shapes that move 2 to the side: the area stays, the mean is in the middle, the second moment is 2^2 / 12 and the
// shape's own.
TEST(MovingStrands, CoverTheirAreaOverTheirWay) {
  const std::string ribbon = "Attribute \"dice\" \"int roundcurve\" [0]\n";
  const std::vector<double> line = {0, -0.5, 3, 0, 0.5, 3};
  const std::vector<double> cubic = {0, -0.5, 3, 0, -1.0 / 6, 3, 0, 1.0 / 6, 3, 0, 0.5, 3};
  const double w = 0.4, cap = kPi * 0.2 * 0.2, disc = kPi * 0.5 * 0.5;
  const std::string width = "\"constantwidth\" [0.4]", whole = "\"constantwidth\" [1]";
  struct Case {
    const char* name;
    std::string body;
    double area, own;  // second moment of x about the middle
  };
  const double bar = w * w / 12, round = 0.2 * 0.2 / 4, large = 0.5 * 0.5 / 4;
  const Case cases[] = {
      {"linear tube with round ends", moved("Curves \"linear\" [2] \"nonperiodic\"", line, width), w + cap,
       (w * bar + cap * round) / (w + cap)},
      {"cubic tube", moved("Curves \"cubic\" [4] \"nonperiodic\"", cubic, width), w, bar},
      {"cubic ribbon", ribbon + moved("Curves \"cubic\" [4] \"nonperiodic\"", cubic, width), w, bar},
      {"oriented ribbon",
       moved("Curves \"cubic\" [4] \"nonperiodic\"", cubic, width + " \"constant normal N\" [0 0 -1]"), w, bar},
      {"oriented ribbon, turned by 60 degrees",
       moved("Curves \"linear\" [2] \"nonperiodic\"", line, whole + " \"constant normal N\" [0.8660254 0 -0.5]"), 0.5,
       0.25 / 12},
      {"disc", moved("Points", {0, 0, 3}, whole), disc, large},
      {"sphere", moved("Points", {0, 0, 3}, whole + " \"uniform string type\" \"sphere\""), disc, large},
      {"oriented disc", moved("Points", {0, 0, 3}, whole + " \"vertex normal N\" [0 0.8660254 0.5]"), disc / 2,
       large},
      {"tube by transform motion",
       "MotionBegin [0 1]\nTranslate -1 0 0\nTranslate 1 0 0\nMotionEnd\n"
       "Curves \"cubic\" [4] \"nonperiodic\" \"P\" [0 -0.5 3 0 -0.2 3 0 0.2 3 0 0.5 3] \"constantwidth\" [0.4]\n",
       w, bar},
  };
  for (const Case& c : cases) {
    const Covered got = covered(window(1024) + "WorldBegin\n" + kGlowing + c.body + "WorldEnd\n", c.name);
    EXPECT_NEAR(got.area, c.area, 0.003 * c.area) << c.name;
    EXPECT_NEAR(got.first, 0, 0.006) << c.name;
    const double second = 4.0 / 12 + c.own + 1.0 / 64 / 12;  // pixels spread it by theirs
    EXPECT_NEAR(got.second, second, 0.01 * second) << c.name;
  }
}

// Widths that change along a curve and over time: means of the integrals.
TEST(MovingStrands, WidthsAreIntegrated) {
  const std::string p = "\"P\" [0 -0.5 3 0 0.5 3] ", q = "\"P\" [0 -0.5 3 0 -0.1666667 3 0 0.1666667 3 0 0.5 3] ";
  const std::string ribbon = "Attribute \"dice\" \"int roundcurve\" [0]\n";
  const auto twice = [](const std::string& a, const std::string& b) {
    return "MotionBegin [0 1]\n" + a + "\n" + b + "\nMotionEnd\n";
  };
  const std::string curve = "Curves \"cubic\" [4] \"nonperiodic\" " + q;
  struct Case {
    const char* name;
    std::string body;
    double area;
  };
  const Case cases[] = {
      {"varying", ribbon + curve + "\"varying float width\" [0.6 0.2]\n", 0.4},
      {"vertex: a Bezier curve of widths", curve + "\"vertex float width\" [0.2 0.8 0.8 0.2]\n", 0.5},
      {"uniform on two linear curves with round ends",
       ribbon + "Curves \"linear\" [2 2] \"nonperiodic\" \"P\" [-1 -0.5 3 -1 0.5 3 1 -0.5 3 1 0.5 3] "
                "\"uniform float width\" [0.2 0.6]\n",
       0.8 + kPi * (0.1 * 0.1 + 0.3 * 0.3)},
      {"growing ribbon", ribbon + twice(curve + "\"constantwidth\" [0.2]", curve + "\"constantwidth\" [0.8]"), 0.5},
      {"growing disc",
       twice("Points \"P\" [0 0 3] \"constantwidth\" [0.4]", "Points \"P\" [0 0 3] \"constantwidth\" [1.2]"),
       kPi / 4 * (0.4 * 0.4 + 0.4 * 1.2 + 1.2 * 1.2) / 3},
  };
  for (const Case& c : cases) {
    const Covered got = covered(window(1024) + "WorldBegin\n" + kGlowing + c.body + "WorldEnd\n", c.name);
    EXPECT_NEAR(got.area, c.area, 0.003 * c.area) << c.name;
  }
}

// Every primitive that can deform, with keys at uneven times: half the way in the first quarter of the shutter, the
// rest in what remains. The mean of x over time is the integral of that way, (0.25 * 0.5 + 0.75 * 1.5) / 2 - 0.5 ...
// in code.
TEST(MovingMeshes, UnevenKeysOfEveryPrimitive) {
  const auto keys = [](const std::string& before, const std::vector<double>& points, const std::string& after) {
    std::string out = "MotionBegin [0 0.25 1]\n";
    for (const double shift : {-1.0, 0.0, 1.0}) {
      out += before + " \"P\" [";
      for (size_t i = 0; i < points.size(); ++i) out += std::to_string(points[i] + (i % 3 == 0 ? shift : 0)) + " ";
      out += "] " + after + "\n";
    }
    return out + "MotionEnd\n";
  };
  const std::vector<double> square = {-0.2, -0.3, 3, -0.2, 0.3, 3, 0.2, 0.3, 3, 0.2, -0.3, 3};
  const std::vector<double> grid = {-0.2, -0.3, 3, 0.2, -0.3, 3, -0.2, 0.3, 3, 0.2, 0.3, 3};
  std::vector<double> bicubic;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) bicubic.insert(bicubic.end(), {-0.2 + 0.4 * i / 3, -0.3 + 0.6 * j / 3, 3});
  struct Case {
    const char* name;
    std::string body;
  };
  const Case cases[] = {
      {"polygon", keys("Polygon", square, "")},
      {"mesh", keys("PointsPolygons [4] [0 1 2 3]", square, "")},
      {"subdivision",
       keys("SubdivisionMesh \"bilinear\" [4] [0 1 2 3] [\"interpolateboundary\"] [1 0] [1] []", square, "")},
      {"bilinear patch", keys("Patch \"bilinear\"", grid, "")},
      {"bicubic patch", keys("Patch \"bicubic\"", bicubic, "")},
      {"patch mesh", keys("PatchMesh \"bilinear\" 2 \"nonperiodic\" 2 \"nonperiodic\"", grid, "")},
      {"NURBS", keys("NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1", grid, "")},
      {"ribbon", keys("Attribute \"dice\" \"int roundcurve\" [0]\nCurves \"cubic\" [4] \"nonperiodic\"",
                      {0, -0.3, 3, 0, -0.1, 3, 0, 0.1, 3, 0, 0.3, 3}, "\"constantwidth\" [0.4]")},
      {"transform",
       "MotionBegin [0 0.25 1]\nTranslate -1 0 0\nTranslate 0 0 0\nTranslate 1 0 0\nMotionEnd\n"
       "Polygon \"P\" [-0.2 -0.3 3 -0.2 0.3 3 0.2 0.3 3 0.2 -0.3 3]\n"},
      {"instance",
       "ObjectBegin \"o\"\nPolygon \"P\" [-0.2 -0.3 3 -0.2 0.3 3 0.2 0.3 3 0.2 -0.3 3]\nObjectEnd\n"
       "MotionBegin [0 0.25 1]\nTranslate -1 0 0\nTranslate 0 0 0\nTranslate 1 0 0\nMotionEnd\nObjectInstance "
       "\"o\"\n"},
  };
  // x(t) = -1 + 4 t until 0.25, then 4/3 (t - 0.25)
  const double mean = 0.25 * -0.5 + 0.75 * 0.5;
  const double second = 0.25 * (1.0 / 3) + 0.75 * (1.0 / 3) + 0.4 * 0.4 / 12 + 1.0 / 64 / 12;
  for (const Case& c : cases) {
    std::string body = c.body;
    // an attribute cannot stand between MotionBegin and MotionEnd
    const std::string attribute = "Attribute \"dice\" \"int roundcurve\" [0]\n";
    if (body.find(attribute) != std::string::npos) {
      for (size_t at; (at = body.find(attribute)) != std::string::npos;) body.erase(at, attribute.size());
      body = attribute + body;
    }
    const Covered got = covered(window(1024) + "WorldBegin\n" + kGlowing + body + "WorldEnd\n", c.name);
    EXPECT_NEAR(got.area, 0.24, 0.003 * 0.24) << c.name;
    EXPECT_NEAR(got.first, mean, 0.006) << c.name;
    EXPECT_NEAR(got.second, second, 0.01 * second) << c.name;
  }
  // quadrics move by their arguments: a disk whose radius grows
  const Covered disk =
      covered(window(256) + "WorldBegin\n" + kGlowing +
                  "MotionBegin [0 0.25 1]\nDisk 3 0.2 360\nDisk 3 0.4 360\nDisk 3 0.8 360\nMotionEnd\nWorldEnd\n",
              "disk");
  const double area = kPi * (0.25 * (0.04 + 0.08 + 0.16) / 3 + 0.75 * (0.16 + 0.32 + 0.64) / 3);
  EXPECT_NEAR(disk.area, area, 0.005 * area) << "the polygon in the circle loses up to 0.2 %";
}

// A square moving at constant speed shows the opening itself: where it passes at time t it is as bright as the
// shutter is open.
TEST(Shutter, OpeningWeighsTimes) {
  const std::string square =
      "MotionBegin [0 1]\nTranslate -1 0 0\nTranslate 1 0 0\nMotionEnd\n"
      "Polygon \"P\" [-0.1 -0.9 3 -0.1 0.9 3 0.1 0.9 3 0.1 -0.9 3]\n";
  struct Case {
    const char* name;
    const char* camera;
    double mean, second;  // of x = 2 t - 1
  };
  // a trapezoid over 0..1 that rises until a and falls from b: moments by integration
  const auto moment = [](double a, double b, int power) {
    double sum = 0, weight = 0;
    for (int i = 0; i < 100000; ++i) {
      const double t = (i + 0.5) / 100000, w = t < a ? t / a : t > b ? (1 - t) / (1 - b) : 1;
      weight += w;
      sum += w * std::pow(2 * t - 1, power);
    }
    return sum / weight;
  };
  const double own = 0.04 / 12 + 1.0 / 64 / 12;
  const Case cases[] = {
      {"at once", "", 0, 1.0 / 3},
      {"trapezoid", "Camera \"c\" \"float shutterOpenTime\" [0.4] \"float shutterCloseTime\" [0.6]\n",
       moment(0.4, 0.6, 1), moment(0.4, 0.6, 2)},
      {"slow opening", "Camera \"c\" \"float shutterOpenTime\" [1]\n", moment(1, 1, 1), moment(1, 1, 2)},
      // control points that make a cubic step 3 s^2 - 2 s^3 of time: weight t^2 (3 - 2 t), mean of t is 7/10
      {"smooth step",
       "Camera \"c\" \"float shutterOpenTime\" [1] \"float[8] shutteropening\" [0.3333333 0 0.6666667 1 1 1 1 1]\n",
       0.4, 4 * (8.0 / 15) - 4 * 0.7 + 1},
  };
  for (const Case& c : cases) {
    const Covered got =
        covered(window(4096, c.camera) + "WorldBegin\n" + std::string(kGlowing) + square + "WorldEnd\n", c.name);
    EXPECT_NEAR(got.area, 0.36, 0.003 * 0.36) << c.name;
    EXPECT_NEAR(got.first, c.mean, 0.006) << c.name;
    EXPECT_NEAR(got.second, c.second + own, 0.012 * (c.second + own)) << c.name;
  }
  RenderRequest bad;
  bad.rib = window(4, "Camera \"c\" \"float shutterOpenTime\" [0.8] \"float shutterCloseTime\" [0.2]\n") +
            "WorldBegin\n" + kGlowing + square + "WorldEnd\n";
  SceneRender render(bad);
  ASSERT_TRUE(render.ok());
  int messages = 0;
  for (const std::string& m : render.messages()) messages += m.find("RENDER-SHUTTER") != std::string::npos;
  EXPECT_EQ(messages, 1);
}

// White strands under a white sky, one bounce of light: convex ones are as bright as the sky. A ray that met the
// strand which it left would darken them.
TEST(Strands, DoNotShadeThemselves) {
  const std::string p = "\"P\" [0 -0.9 3 0 -0.3 3 0 0.3 3 0 0.9 3] ",
                    ribbon = "Attribute \"dice\" \"int roundcurve\" [0]\n";
  for (const double scale : {1.0, 1e-3, 1e3})
    for (const std::string& body :
         {"Curves \"cubic\" [4] \"nonperiodic\" " + p + "\"constantwidth\" [0.8]\n",
          "Curves \"linear\" [4] \"nonperiodic\" " + p + "\"constantwidth\" [0.8]\n",
          ribbon + "Curves \"cubic\" [4] \"nonperiodic\" " + p + "\"constantwidth\" [0.8]\n",
          ribbon + "Curves \"linear\" [4] \"nonperiodic\" " + p + "\"constantwidth\" [0.8]\n",
          "Curves \"cubic\" [4] \"nonperiodic\" " + p + "\"constantwidth\" [0.8] \"constant normal N\" [0.5 0 -1]\n",
          std::string("Points \"P\" [0 0 3] \"constantwidth\" [1.6]\n"),
          std::string("Points \"P\" [0 0 3] \"constantwidth\" [1.6] \"uniform string type\" \"sphere\"\n"),
          std::string("Points \"P\" [0 0 3] \"constantwidth\" [1.6] \"vertex normal N\" [0.5 0 -1]\n")}) {
      RenderRequest r;
      const std::string s = std::to_string(scale);
      r.rib = "Format 16 16 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64]\nScreenWindow " +
              std::to_string(-0.3 * scale) + " " + std::to_string(0.3 * scale) + " " + std::to_string(-0.3 * scale) +
              " " + std::to_string(0.3 * scale) + "\nProjection \"orthographic\"\n" + unbiased(1) +
              "WorldBegin\nScale " + s + " " + s + " " + s +
              "\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\nBxdf \"PxrDiffuse\" \"d\" \"color "
              "diffuseColor\" [1 1 1]\n" +
              body + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      const testing::Moments m = overPixels(render.channel("Ci"));
      EXPECT_NEAR(m.mean(), 1, 0.003) << "scale " << scale << "\n" << body;
      EXPECT_NEAR(overPixels(render.channel("a")).mean(), 1, 1e-6) << body;
    }
}

// A value at a pixel of the window.
const float* at(const image::Image& i, double x, double y) { return i.at(int((x + 2) * 8), int((1 - y) * 8)); }

TEST(Strands, ParametersAndPrimvars) {
  // a bar along x: v along it, u across; colours of every class
  const std::string bar =
      "Curves \"cubic\" [7] \"nonperiodic\" \"P\" [-1.5 0 3 -1 0 3 -0.5 0 3 0 0 3 0.5 0 3 1 0 3 1.5 0 3] "
      "\"constantwidth\" [1.6] ";
  const std::string ribbon = "Attribute \"dice\" \"int roundcurve\" [0]\n";
  const std::string show =
      "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"tint\"] \"string type\" [\"color\"]\n"
      "Bxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"p:resultRGB\"]\n";
  for (const std::string& kind : {ribbon, std::string()}) {
    RenderRequest r;
    r.rib =
        window(16) + "WorldBegin\n" + show + kind + bar + "\"varying color tint\" [1 0 0  0 1 0  0 0 1]\nWorldEnd\n";
    r.channels = "Ci,a,u,v";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const image::Image c = render.channel("Ci"), u = render.channel("u"), v = render.channel("v");
    for (const double x : {-1.2, -0.4, 0.4, 1.2}) {
      const double px = -2 + (std::floor((x + 2) * 8) + 0.5) / 8, along = (px + 1.5) / 3;
      EXPECT_NEAR(at(v, x, 0.1)[0], along, 0.01) << x;
      const double s = px < 0 ? (px + 1.5) / 1.5 : px / 1.5;
      const double expected[3] = {px < 0 ? 1 - s : 0, px < 0 ? s : 1 - s, px < 0 ? 0 : s};
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(at(c, x, 0.1)[k], expected[k], 0.01) << x;
    }
    if (kind.empty()) continue;
    // across the ribbon u runs from edge to edge
    const double low = at(u, 0.5, -0.7)[0], high = at(u, 0.5, 0.7)[0];
    EXPECT_NEAR(std::abs(high - low), 1.5 / 1.6, 0.1);
    EXPECT_NEAR(low + high, 1, 0.15);
  }
  // uniform: one value for each curve, one for all points
  RenderRequest r;
  r.rib = window(16) + "WorldBegin\n" + show +
          "Curves \"cubic\" [4 4] \"nonperiodic\" \"P\" [-1 -0.9 3 -1 -0.3 3 -1 0.3 3 -1 0.9 3 1 -0.9 3 1 -0.3 3 1 "
          "0.3 3 1 0.9 3] "
          "\"constantwidth\" [0.6] \"uniform color tint\" [1 0 0  0 0 1]\n"
          "Points \"P\" [0 0.5 3 0 -0.5 3] \"constantwidth\" [0.6] \"vertex color tint\" [0 1 0  1 1 0]\nWorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  const image::Image c = render.channel("Ci");
  const struct {
    double x, y;
    float rgb[3];
  } expected[] = {{-1, 0, {1, 0, 0}}, {1, 0, {0, 0, 1}}, {0, 0.5, {0, 1, 0}}, {0, -0.5, {1, 1, 0}}};
  for (const auto& e : expected)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(at(c, e.x, e.y)[k], e.rgb[k], 1e-4) << e.x << " " << e.y;
}

}  // namespace
}  // namespace kinora::tests
