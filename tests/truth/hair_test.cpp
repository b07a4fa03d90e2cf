// Fibres in whole pictures. Proves: white ones vanish in a white furnace, as tubes and as ribbons, which no part of them does
// that meets itself; curves that are drawn wider than they are cover what they should, with less noise; the same bits for
// any group; path tracing from the eye and from both ends agree on a tuft. Misses: what hair should look like.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

const char* const kTubes = "Attribute \"dice\" \"int roundcurve\" [1]\n";
const char* const kRibbons = "Attribute \"dice\" \"int roundcurve\" [0]\n";
const char* const kWhiteHair =
    "Bxdf \"PxrMarschnerHair\" \"h\" \"color specularColorTT\" [1 1 1] \"color specularColorTRT\" [1 1 1]\n";
// A few bent curves, thick enough to be looked at.
const char* const kBent = R"(Basis "bezier" 3 "bezier" 3
Curves "cubic" [4 4 4] "nonperiodic" "P" [-1 -1 3  -0.6 0.4 2.6  -0.4 0.6 3.4  -0.7 1 3
  0 -1 3.2  0.3 -0.3 2.7  -0.3 0.3 3.3  0.1 1 3   0.6 -1 3  1.1 0 3.4  0.4 0.3 2.8  0.8 1 3] "varying float width" [0.5 0.2 0.3 0.4 0.4 0.1]
)";

TEST(Hair, WhiteFibresVanishInAFurnace) {
  for (const char* kind : {kTubes, kRibbons})
    for (const char* what : {"hair", "diffuse", "chiang"}) {
      const bool isDiffuse = *what == 'd';
      RenderRequest r;
      r.rib = orthographic(32, 1, 256) + unbiased(isDiffuse ? 60 : 30) +
              "WorldBegin\nLight \"PxrDomeLight\" \"sky\"\n" + kind +
              (isDiffuse      ? "Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [1 1 1]\n"
               : *what == 'c' ? "Bxdf \"LamaHairChiang\" \"c\" \"color colorTT\" [1 1 1]\n"
                              : kWhiteHair) +
              kBent + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      const image::Image picture = render.channel("Ci"), alpha = render.channel("a");
      double covered = 0, sum = 0, squares = 0;
      int pixels = 0;
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
          covered += alpha.at(x, y)[0] / 1024;
          if (alpha.at(x, y)[0] < 0.999f) continue;
          const double v = picture.at(x, y)[1];
          sum += v;
          squares += v * v;
          ++pixels;
        }
      ASSERT_GT(pixels, 100);
      const double mean = sum / pixels, error = std::sqrt((squares / pixels - mean * mean) / pixels);
      EXPECT_GT(covered, 0.2);
      EXPECT_NEAR(mean, 1, 4 * error + 0.002) << kind << what << " error " << error;
    }
}

struct Seen {
  double area = 0, deviation = 0;  // in the window's units; of a pixel's value from frame to frame
};
Seen seen(const std::string& curve, const std::string& attributes, int samples, int seeds) {
  Seen s;
  std::vector<double> sums(32 * 32), squares(32 * 32);
  for (int seed = 0; seed < seeds; ++seed) {
    RenderRequest r;
    r.rib =
        orthographic(32, 1, samples) + "WorldBegin\nBxdf \"PxrConstant\" \"c\"\n" + attributes + curve + "WorldEnd\n";
    r.settings.seed = uint32_t(seed);
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    if (!render.ok()) return s;
    const image::Image alpha = render.channel("a");
    for (int i = 0; i < 32 * 32; ++i) {
      const double a = alpha.at(i % 32, i / 32)[0];
      s.area += a / (16.0 * 16) / seeds;
      sums[size_t(i)] += a / seeds;
      squares[size_t(i)] += a * a / seeds;
    }
  }
  for (int i = 0; i < 32 * 32; ++i)
    s.deviation += std::max(0.0, squares[size_t(i)] - sums[size_t(i)] * sums[size_t(i)]);
  s.deviation = std::sqrt(s.deviation);
  return s;
}

// A pixel is 1/16 wide.
TEST(Hair, CurvesThinnerThanAPixelCoverTheirArea) {
  const std::string line =
      "Basis \"bezier\" 3 \"bezier\" 3\nCurves \"cubic\" [4] \"nonperiodic\" \"P\" "
      "[-0.83 -0.8 3  -0.3 -0.27 3  0.23 0.26 3  0.77 0.8 3] ";
  const double length = std::hypot(1.6, 1.6);
  struct Case {
    const char* width;
    double mean;
  };
  const Case cases[] = {{"\"constantwidth\" [0.004]", 0.004},
                        {"\"varying float width\" [0.006 0]", 0.003},
                        {"\"vertex float width\" [0.001 0.2 0.001 0.001]", 0.25 * 0.203}};
  for (const char* kind : {kTubes, kRibbons})
    for (const Case& c : cases) {
      const Seen plain = seen(line + c.width, kind, 16, 24),
                 wide =
                     seen(line + c.width, std::string(kind) + "Attribute \"hair\" \"float minwidth\" [1]\n", 16, 24);
      const double area = c.mean * length;
      // each frame's area has an error of its deviation, in the window's units
      for (const Seen* s : {&plain, &wide})
        EXPECT_NEAR(s->area, area, 4 * s->deviation / 256 / std::sqrt(24.0) + 0.01 * area) << kind << c.width;
      if (c.mean < 0.01) {
        EXPECT_LT(wide.deviation, 0.85 * plain.deviation) << kind << c.width;
      }
    }
}

TEST(Hair, WidenedCurvesHaveTheSameBitsInAnyGroup) {
  std::vector<uint64_t> hashes;
  for (const uint32_t group : {64u, 512u})
    for (const int threads : {1, 2})
      for (const int width : {1, 8}) {
        RenderRequest r;
        r.rib = orthographic(32, 1, 8) + unbiased(3) + "WorldBegin\nLight \"PxrDomeLight\" \"sky\"\n" +
                "Attribute \"hair\" \"float minwidth\" [2]\nScale 1 1 1\n" + kWhiteHair +
                "ObjectBegin \"o\"\nBasis \"bezier\" 3 \"bezier\" 3\nCurves \"cubic\" [4 4] \"nonperiodic\" \"P\" "
                "[-1 -1 3  -0.6 "
                "0.4 2.6  -0.4 0.6 3.4  -0.7 1 3  0 -1 3.2  0.3 -0.3 2.7  -0.3 0.3 3.3  0.1 1 3] \"constantwidth\" "
                "[0.02]\nObjectEnd\n"
                "ObjectInstance \"o\"\nTranslate 0.5 0 0.1\nObjectInstance \"o\"\nWorldEnd\n";
        r.settings.groupSize = group;
        r.settings.threads = threads;
        r.settings.width = width;
        SceneRender render(r);
        ASSERT_TRUE(render.ok());
        hashes.push_back(hashOf(render.film()));
      }
  for (const uint64_t h : hashes) EXPECT_EQ(h, hashes[0]);
}

// A tuft over a floor, lit by a small light: from the eye alone, and from both ends.
TEST(Hair, BothEndsSeeTheSameTuft) {
  std::string curves = "Basis \"bezier\" 3 \"bezier\" 3\nCurves \"cubic\" [";
  std::string points;
  const int hairs = 40;
  for (int i = 0; i < hairs; ++i) {
    const double a = i * 2.399963, r = 0.6 * std::sqrt((i + 0.5) / hairs), x = r * std::cos(a), z = r * std::sin(a);
    curves += "4 ";
    for (int k = 0; k < 4; ++k)
      points += std::to_string(x * (1 + 0.3 * k)) + " " + std::to_string(0.4 * k) + " " +
                std::to_string(z * (1 + 0.2 * k)) + " ";
  }
  curves += "] \"nonperiodic\" \"P\" [" + points + "] \"constantwidth\" [0.07]\n";
  RenderRequest eye, both;
  const auto scene = [&](const std::string& integrator, int samples) {
    return "Format 24 24 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" +
           std::to_string(samples) + "]\nProjection \"perspective\" \"fov\" [40]\nTranslate 0 -0.6 4\n" + integrator +
           "WorldBegin\nAttributeBegin Translate 1.5 2.5 1.5 Scale 0.6 0.6 0.6\nLight \"PxrSphereLight\" \"l\" "
           "\"float intensity\" "
           "[30]\nAttributeEnd\nBxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [0.5 0.5 0.5]\n"
           "Polygon \"vertex point P\" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]\n"
           "Bxdf \"PxrMarschnerHair\" \"h\" \"color specularColorTT\" [0.9 0.6 0.3] \"color specularColorTRT\" [0.8 "
           "0.4 0.1] "
           "\"float specularConeAngleR\" [12] \"float specularConeAngleTT\" [14] \"float specularConeAngleTRT\" [16] "
           "\"float diffuseGain\" [0.5]\n" +
           curves + "WorldEnd\n";
  };
  eye.rib = scene(unbiased(4), 256);
  both.rib = scene(
      "Integrator \"PxrVCM\" \"i\" \"int maxIndirectBounces\" [4] \"int mergePaths\" [0] \"float clampLuminance\" "
      "[1e30] "
      "\"float rouletteThreshold\" [0]\n",
      128);
  const auto one = overSeeds(eye, 8), other = overSeeds(both, 8);
  EXPECT_SAME_MEAN(one, other, 0.02);
}

// The way back from a fibre's axis may miss the edge of the light that the path came from.
TEST(Hair, PathsFromMeshLightsAreFinite) {
  RenderRequest r;
  r.rib = R"(Format 24 24 1
PixelFilter "box" 1 1
Hider "raytrace" "int maxsamples" [64]
Projection "perspective" "fov" [50]
Translate 0 0 4
Integrator "PxrVCM" "i" "int maxIndirectBounces" [1] "int mergePaths" [0]
WorldBegin
AttributeBegin
Translate 0 1.63 0.6
Rotate 110 1 0 0
Light "PxrMeshLight" "l" "float intensity" [4]
Polygon "P" [-.3 -.3 0 .3 -.3 0 .3 .3 0 -.3 .3 0]
AttributeEnd
AttributeBegin
Bxdf "PxrMarschnerHair" "h"
Curves "cubic" [4] "nonperiodic" "P" [-.6 0 0 -.2 .5 0 .2 -.5 0 .6 0 0] "constantwidth" [.3]
AttributeEnd
Bxdf "PxrDiffuse" "floor" "color diffuseColor" [.5 .5 .5]
Polygon "P" [-3 -1 -3 3 -1 -3 3 -1 3 -3 -1 3]
WorldEnd
)";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(render.film().counters().nonFinite, 0u);
}

}  // namespace
}  // namespace kinora::tests
