// Proves: moving and defocused shapes cover pixels as integrals over shutter and lens say; presence lets through what
// it should, to the eye and to light; visibility attributes; absorption by Beer and Lambert between the faces of
// glass. Misses: curved motion paths, shaped apertures, presence from textures.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

std::string wide(int width, int height, const std::string& screen, int samples) {
  return "Format " + std::to_string(width) + " " + std::to_string(height) +
         " 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" + std::to_string(samples) +
         "]\nScreenWindow " + screen + "\n";
}
const char* const kGlowing = "Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [1 1 1]\n";
// A disk at z, seen from both sides, as Disk of radius r.
std::string sheet(double z) {
  return "AttributeBegin Translate 0 0 " + std::to_string(z) +
         "\nPolygon \"vertex point P\" [-50 -50 0  -50 50 0  50 50 0  50 -50 0]\nAttributeEnd\n";
}

// Time in 0..1 that a bar of half width `half`, its centre going from `from` to `to`, covers x, averaged over [x0,
// x1].
double barCoverage(double x0, double x1, double from, double to, double half) {
  double sum = 0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double x = x0 + (x1 - x0) * (i + 0.5) / n;
    const double a = (x - half - from) / (to - from), b = (x + half - from) / (to - from);
    sum += std::max(0.0, std::min(1.0, std::max(a, b)) - std::max(0.0, std::min(a, b)));
  }
  return sum / n;
}

TEST(MotionBlur, MovingSquareCoversWhatTheIntegralSays) {
  // each of transform motion, deformation and a moving camera
  const std::string square = "Polygon \"vertex point P\" [-0.5 -0.5 0  -0.5 0.5 0  0.5 0.5 0  0.5 -0.5 0]\n";
  const std::string head = wide(32, 16, "-2 2 -1 1", 256) + "Shutter 0 1\n";
  const std::pair<const char*, std::string> scenes[] = {
      {"transform", head + "Projection \"orthographic\"\nWorldBegin\n" + kGlowing +
                        "Translate 0 0 3\nMotionBegin [0 1]\nTranslate -1 0 0\nTranslate 1 0 0\nMotionEnd\n" +
                        square + "WorldEnd\n"},
      {"transform, keys beyond the shutter",
       head + "Projection \"orthographic\"\nWorldBegin\n" + kGlowing +
           "Translate 0 0 3\nMotionBegin [-1 3]\nTranslate -3 0 0\nTranslate 5 0 0\nMotionEnd\n" + square +
           "WorldEnd\n"},
      {"deformation", head + "Projection \"orthographic\"\nWorldBegin\n" + kGlowing + R"(Translate 0 0 3
MotionBegin [0 1]
Polygon "vertex point P" [-1.5 -0.5 0  -1.5 0.5 0  -0.5 0.5 0  -0.5 -0.5 0]
Polygon "vertex point P" [0.5 -0.5 0  0.5 0.5 0  1.5 0.5 0  1.5 -0.5 0]
MotionEnd
WorldEnd
)"},
      {"camera", head +
                     "Projection \"orthographic\"\nMotionBegin [0 1]\nTranslate -1 0 3\nTranslate 1 0 "
                     "3\nMotionEnd\nWorldBegin\n" +
                     kGlowing + square + "WorldEnd\n"},
      // there and back, in half the time each and not
      {"camera, three keys", head +
                                 "Projection \"orthographic\"\nMotionBegin [0 .5 1]\nTranslate -1 0 3\nTranslate 1 0 "
                                 "3\nTranslate -1 0 3\nMotionEnd\nWorldBegin\n" +
                                 kGlowing + square + "WorldEnd\n"},
      {"camera, uneven keys",
       head +
           "Projection \"orthographic\"\nMotionBegin [0 .25 1]\nTranslate -1 0 3\nTranslate 1 0 "
           "3\nTranslate -1 0 3\nMotionEnd\nWorldBegin\n" +
           kGlowing + square + "WorldEnd\n"},
  };
  for (const auto& [name, rib] : scenes) {
    RenderRequest r;
    r.rib = rib;
    SceneRender render(r);
    ASSERT_TRUE(render.ok()) << name;
    const image::Image alpha = render.channel("a");
    double worst = 0, mean = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 32; ++x) {
        const bool inside = y >= 4 && y < 12;
        const double expected = inside ? barCoverage(-2 + x / 8.0, -2 + (x + 1) / 8.0, -1, 1, 0.5) : 0;
        worst = std::max(worst, std::abs(alpha.at(x, y)[0] - expected));
        mean += alpha.at(x, y)[0] / 512;
      }
    // what strata of time are strata of is half as even on the way there and back
    EXPECT_NEAR(mean, 1.0 / 8, std::string_view(name).starts_with("camera, ") ? 4e-4 : 2e-4)
        << name << ": area of the square over that of the window";
    // 256 samples, stratified over pixel and time
    EXPECT_LT(worst, 0.05) << name << "; picture: " << SceneRender::keep(alpha, "motion");
  }
}

TEST(MotionBlur, MovingSphereConservesItsArea) {
  RenderRequest r;
  r.rib = wide(32, 16, "-2 2 -1 1", 64) + "Shutter 0.25 0.75\nProjection \"orthographic\"\nWorldBegin\n" + kGlowing +
          "Translate 0 0 3\nMotionBegin [0 1]\nTranslate -2 0 0\nTranslate 2 0 0\nMotionEnd\nSphere 0.5 -0.5 0.5 "
          "360\nWorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  const image::Image alpha = render.channel("a");
  double mean = 0, first = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x) {
      mean += alpha.at(x, y)[0] / 512;
      first += alpha.at(x, y)[0] / 512 * std::pow(-2 + (x + 0.5) / 8.0, 2);
    }
  // pi/4 of 8; the polygon inscribed in the circle may lose 0.2 %
  EXPECT_NEAR(mean, 3.14159265 / 4 / 8, 0.004 * mean);
  // second moment about the middle: travel 2 between the shutter's ends, 2^2 / 12, plus the disk's own r^2 / 4
  EXPECT_NEAR(first / mean, 4.0 / 12 + 0.25 / 4 + 1.0 / 64 / 12, 0.01 * first / mean);
}

// A disk of radius r at z through a lens of radius R focused at f: on the screen at unit distance it stays r / z
// wide, spread by a disk of radius R |1 / z - 1 / f|. Area is conserved; the second moment is (a^2 + b^2) / 2.
TEST(DepthOfField, DiskOutOfFocusSpreadsByTheCircleOfConfusion) {
  for (const double z : {2.0, 4.0, 8.0}) {
    const double focus = 4, lens = 0.2, radius = 0.1 * z;
    RenderRequest r;
    r.rib = wide(32, 32, "-0.4 0.4 -0.4 0.4", 256) +
            "DepthOfField 2 0.8 4\nProjection \"perspective\" \"fov\" [90]\nWorldBegin\n" + kGlowing +
            "Attribute \"dice\" \"float micropolygonlength\" [0.1]\nTranslate 0 0 " + std::to_string(z) +
            "\nDisk 0 " + std::to_string(radius) + " 360\nWorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const image::Image alpha = render.channel("a");
    double area = 0, second = 0;
    const double pixel = 0.8 / 32;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const double sx = -0.4 + (x + 0.5) * pixel, sy = -0.4 + (y + 0.5) * pixel,
                     a = alpha.at(x, y)[0] * pixel * pixel;
        area += a;
        second += a * (sx * sx + sy * sy);
      }
    const double a = 0.1, b = lens * std::abs(1 / z - 1 / focus);
    EXPECT_NEAR(area, 3.14159265 * a * a, 0.005 * area) << "z " << z;
    EXPECT_NEAR(second / area, (a * a + b * b) / 2 + pixel * pixel / 6, 0.01 * (a * a + b * b) / 2) << "z " << z;
  }
}

TEST(Presence, StackedHalvesLetAQuarterThrough) {
  RenderRequest r;
  r.rib = orthographic(32, 1, 64) + unbiased(0) + "WorldBegin\n" + kGlowing + sheet(5) +
          "Bxdf \"PxrConstant\" \"dark\" \"color emitColor\" [0 0 0] \"float presence\" [0.5]\n" + sheet(2) +
          sheet(3) + "WorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  EXPECT_MEAN(overPixels(render.channel("Ci")), 0.25, 0.01);
  EXPECT_MEAN(overPixels(render.channel("a")), 1, 1e-6);
  // without the glowing wall behind: alpha is what the sheets cover
  r.rib = orthographic(32, 1, 64) + unbiased(0) +
          "WorldBegin\nBxdf \"PxrConstant\" \"dark\" \"color emitColor\" [0 0 0] \"float presence\" [0.5]\n" +
          sheet(2) + sheet(3) + "WorldEnd\n";
  SceneRender open(r);
  ASSERT_TRUE(open.ok());
  EXPECT_MEAN(overPixels(open.channel("a")), 0.75, 0.01);
}

// Light from behind the camera through two half present sheets onto a white wall seen through none.
TEST(Presence, StackedHalvesShadowAQuarter) {
  const std::string lights[] = {
      "Light \"PxrDistantLight\" \"l\" \"float intensity\" [1000] \"float angleExtent\" [1]\n",
      "AttributeBegin Translate 0 0 -1 Scale 3 3 1 Light \"PxrRectLight\" \"l\" \"float intensity\" [10] "
      "AttributeEnd\n",
      "Light \"PxrDomeLight\" \"l\" \"float intensity\" [1]\n"};
  for (const std::string& light : lights)
    for (const char* samples : {"", "\"int numLightSamples\" [0]"}) {
      // a dome or rectangle can be found by bxdf samples alone; a distant light of 1 degree too rarely
      if (*samples && light.find("Distant") != std::string::npos) continue;
      const auto at = [&](const std::string& sheets) {
        RenderRequest r;
        r.rib = orthographic(16, 1e-3, 64) + unbiased(0, samples) + "WorldBegin\n" + light +
                "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n" + sheet(1) +
                "Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"dark\" \"color diffuseColor\" [0 "
                "0 0] \"float presence\" [0.5]\n" +
                sheets + "WorldEnd\n";
        return overSeeds(r, 8);
      };
      const auto open = at(""), shaded = at(sheet(0.7) + sheet(0.9));
      const double error = std::sqrt(std::pow(shaded.standardError(), 2) + std::pow(0.25 * open.standardError(), 2));
      EXPECT_NEAR(shaded.mean(), 0.25 * open.mean(), 4 * error + 2e-4 * shaded.mean()) << light << samples;
      EXPECT_LT(error, 0.01 * open.mean()) << light << samples;
    }
}

// Light found behind a half present sheet is weighed by both techniques as seen from where the ray began.
TEST(Presence, LightBehindSheetsIsWeighedRight) {
  const auto at = [](const std::string& samples) {
    RenderRequest r;
    r.rib = orthographic(16, 1e-3, 64) + unbiased(0, samples) +
            "WorldBegin\nAttributeBegin Translate 0 0 -0.2 Light \"PxrRectLight\" \"l\" \"float intensity\" [10] "
            "AttributeEnd\n"
            "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n" +
            sheet(1) +
            "Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"dark\" \"color diffuseColor\" [0 0 "
            "0] \"float presence\" [0.5]\n" +
            sheet(0.1) + "WorldEnd\n";
    return overSeeds(r, 12);
  };
  const auto both = at("");
  EXPECT_SAME_MEAN(both, at("\"int numLightSamples\" [0]"), 0.01);
  // a = 0.5, h = 1.2: E = 4 L (a / q) atan(a / q), half of it arrives
  const double q = std::sqrt(0.25 + 1.44), e = 0.5 * 10 * 4 * 0.5 / q * std::atan(0.5 / q);
  EXPECT_NEAR(both.mean(), e / 3.14159265, 4 * both.standardError() + 0.003 * both.mean());
}

// A light before a half present sheet is seen whole, also by the rays that pass the sheet; one behind it by half.
TEST(Presence, LightsAreSeenBeforeAndBehindSheets) {
  for (const auto& [z, expected] : {std::pair{3.0, 1.0}, std::pair{7.0, 0.5}}) {
    RenderRequest r;
    r.rib = orthographic(32, 0.1, 64) + unbiased(0) + "WorldBegin\nAttributeBegin Translate 0 0 " +
            std::to_string(z) +
            " Light \"PxrSphereLight\" \"l\" \"float intensity\" [1] AttributeEnd\n"
            "Bxdf \"PxrConstant\" \"dark\" \"color emitColor\" [0 0 0] \"float presence\" [0.5]\n" +
            sheet(5) + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    EXPECT_MEAN(overPixels(render.channel("Ci")), expected, 0.01);
    EXPECT_MEAN(overPixels(render.channel("a")), 1, 1e-6);
  }
}

TEST(Visibility, AttributesHideFromWhatTheyName) {
  const auto mean = [](const std::string& attribute) {
    // a glowing wall, a white floor sheet lit by a light, and a black screen with the attribute between
    RenderRequest r;
    r.rib = orthographic(8, 1e-3, 16) + unbiased(1) +
            "WorldBegin\nLight \"PxrDistantLight\" \"l\" \"float intensity\" [1000] \"float angleExtent\" [1]\n"
            "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n" +
            sheet(1) + "AttributeBegin Attribute \"visibility\" \"int camera\" [0] \"int transmission\" [0]\n" +
            kGlowing + sheet(-2) + "AttributeEnd\n" +
            "Bxdf \"PxrDiffuse\" \"dark\" \"color diffuseColor\" [0 0 0]\nAttribute \"visibility\" " + attribute +
            "\n" + sheet(0.5) + "WorldEnd\n";
    SceneRender render(r);
    return overPixels(render.channel("Ci")).mean();
  };
  const double s = std::sin(0.5 * 3.14159265358979 / 180), lit = 1000 * s * s;  // of a wall of albedo 1
  EXPECT_NEAR(mean("\"int camera\" [1]"), 0, 1e-6) << "the screen is seen";
  EXPECT_NEAR(mean("\"int camera\" [0]"), 0, 1e-6) << "unseen, it shadows and blocks";
  EXPECT_NEAR(mean("\"int camera\" [0] \"int transmission\" [0]"), lit, 0.01 * lit)
      << "light passes, the glowing wall is hidden";
  EXPECT_NEAR(mean("\"int camera\" [0]\nAttribute \"render\" \"string casts_shadows\" [\"none\"]"), lit, 0.01 * lit)
      << "the old word for it";
  EXPECT_NEAR(mean("\"int camera\" [0] \"int indirect\" [0]"), 1, 0.02)
      << "the glowing wall is found, light is shadowed";
  EXPECT_NEAR(mean("\"int camera\" [0] \"int indirect\" [0] \"int transmission\" [0]"), 1 + lit, 0.02);
}

// A closed slab of glass of index n and thickness d before a glowing wall, seen head on: T = (1-R)^2 k / (1 - R^2
// k^2) with k = exp(-absorption d), R = ((n-1)/(n+1))^2.
TEST(Absorption, GlassSlabFollowsBeerAndLambert) {
  for (const double n : {1.0, 1.5})
    for (const char* roughness : {"0"}) {
      const double d = 0.8, sigma[3] = {0, 0.7, 3};
      RenderRequest r;
      r.rib = orthographic(16, 0.1, 256) + unbiased(20) + "WorldBegin\n" + kGlowing + sheet(8) +
              "Bxdf \"PxrSurface\" \"glass\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float "
              "reflectionGain\" [1] "
              "\"float glassRoughness\" [" +
              roughness + "] \"float glassIor\" [" + std::to_string(n) + "] \"color extinction\" [0 0.7 3]\n" +
              R"(Translate 0 0 2
PointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]
 "vertex point P" [-1 0 -1  1 0 -1  1 0 1  -1 0 1  -1 0.8 -1  1 0.8 -1  1 0.8 1  -1 0.8 1]
WorldEnd
)";
      // the box above lies along y: turn it towards the view
      const size_t at = r.rib.find("Translate 0 0 2\n");
      r.rib.insert(at + 16, "Rotate 90 1 0 0\n");
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      const double reflectance = std::pow((n - 1) / (n + 1), 2);
      for (int c = 0; c < 3; ++c) {
        const double k = std::exp(-sigma[c] * d);
        const double expected = std::pow(1 - reflectance, 2) * k / (1 - reflectance * reflectance * k * k);
        EXPECT_MEAN(overPixels(render.channel("Ci"), c), expected, 0.004 * expected + 1e-5);
      }
    }
}

std::string slab(double from, double to, const std::string& glass, int priority) {
  const std::string a = " " + std::to_string(from), b = " " + std::to_string(to);
  return "AttributeBegin Attribute \"trace\" \"int intersectpriority\" [" + std::to_string(priority) +
         "]\nBxdf \"PxrSurface\" \"glass\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float "
         "reflectionGain\" [1] "
         "\"float glassRoughness\" [0] " +
         glass +
         "\nPointsPolygons [4 4 4 4 4 4] [3 2 1 0  4 5 6 7  1 5 4 0  2 6 5 1  3 7 6 2  0 4 7 3] \"vertex point P\" "
         "[-1 -1" +
         a + " 1 -1" + a + " 1 1" + a + " -1 1" + a + " -1 -1" + b + " 1 -1" + b + " 1 1" + b + " -1 1" + b +
         "]\nAttributeEnd\n";
}

// An opaque sheet inside a medium of any priority is seen, through what lies before it.
TEST(Absorption, PriorityHidesNoOpaqueThing) {
  for (const int priority : {0, 5}) {
    RenderRequest r;
    r.rib = orthographic(8, 0.1, 16) + unbiased(20) + "WorldBegin\n" + kGlowing +
            "AttributeBegin Translate 0 0 2.5\nPolygon \"vertex point P\" [-0.5 -0.5 0  -0.5 0.5 0  0.5 0.5 0  0.5 "
            "-0.5 0]\nAttributeEnd\n" +
            slab(2, 3, "\"float glassIor\" [1] \"color extinction\" [0.9 0.9 0.9]", priority) + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    EXPECT_MEAN(overPixels(render.channel("Ci")), std::exp(-0.45), 0.001);
  }
}

// Two slabs of index 1 that overlap by half a unit: where both are, the one of higher priority absorbs, alone.
TEST(Absorption, OverlappingMediaFollowPriority) {
  const double a = 0.9, b = 1.7;
  for (const bool firstWins : {false, true})
    for (const bool swapped : {false, true}) {
      const std::string one =
          slab(2, 3, "\"float glassIor\" [1] \"color extinction\" [0.9 0.9 0.9]", firstWins ? 2 : 1);
      const std::string two =
          slab(2.5, 3.5, "\"float glassIor\" [1] \"color extinction\" [1.7 1.7 1.7]", firstWins ? 1 : 2);
      RenderRequest r;
      r.rib = orthographic(8, 0.1, 16) + unbiased(20) + "WorldBegin\n" + kGlowing + sheet(8) +
              (swapped ? two + one : one + two) + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      const double expected = std::exp(-(firstWins ? a + b / 2 : a / 2 + b));
      EXPECT_MEAN(overPixels(render.channel("Ci")), expected, 0.002 * expected);
    }
}

}  // namespace
}  // namespace kinora::tests
