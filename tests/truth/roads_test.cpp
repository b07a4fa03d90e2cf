// Two roads, one answer: the same picture said in two ways. A rectangular light and a glowing polygon; a quadric
// diced coarsely and finely and as a mesh; instances and copies; a scene at the origin and 1e6 away from it; linked
// lights and lights left out. Misses: what both roads have in common.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/teapot_patches.h"
#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

double rmse(const image::Image& a, const image::Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) sum += std::pow(double(a.pixels[i]) - b.pixels[i], 2);
  return std::sqrt(sum / double(a.pixels.size()));
}
double mean(const image::Image& a) {
  double sum = 0;
  for (const float v : a.pixels) sum += v;
  return sum / double(a.pixels.size());
}

std::string head(int samples, const std::string& view = "Translate 0 -0.6 4\n") {
  return "Format 32 32 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" +
         std::to_string(samples) + "]\nProjection \"perspective\" \"fov\" [40]\n" + view;
}
const char* const kFloorAndBall = R"(Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.6 0.5 0.4]
Polygon "vertex point P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]
AttributeBegin
Bxdf "PxrSurface" "ball" "color diffuseColor" [0.3 0.5 0.6] "color specularFaceColor" [0.2 0.2 0.2] "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.4]
Translate 0.2 0.5 0
Sphere 0.5 -0.5 0.5 360
AttributeEnd
)";

TEST(Roads, RectangularLightIsAGlowingPolygon) {
  RenderRequest light, polygon;
  // 1 by 1 at height 2, emitting down: +Z turns to -y
  light.rib = head(64) + unbiased(2) +
              "WorldBegin\nAttributeBegin ConcatTransform [1 0 0 0  0 0 1 0  0 -1 0 0  0 2 0 1]\n"
              "Light \"PxrRectLight\" \"l\" \"float intensity\" [5] AttributeEnd\n" +
              kFloorAndBall + "WorldEnd\n";
  polygon.rib =
      head(256) + unbiased(3) + "WorldBegin\n" + kFloorAndBall +
      "AttributeBegin Sides 1\nBxdf \"PxrSurface\" \"glow\" \"float diffuseGain\" [0] \"float glowGain\" [5] \"color "
      "glowColor\" [1 1 1]\n"
      "Polygon \"vertex point P\" [-0.5 2 -0.5  0.5 2 -0.5  0.5 2 0.5  -0.5 2 0.5]\nAttributeEnd\nWorldEnd\n";
  const auto one = overSeeds(light, 8), other = overSeeds(polygon, 12);
  EXPECT_SAME_MEAN(one, other, 0.01);
  if (::testing::Test::HasFailure()) {
    SceneRender a(light), b(polygon);
    std::printf("pictures: %s %s\n", SceneRender::keep(a.channel("Ci"), "rect").c_str(),
                SceneRender::keep(b.channel("Ci"), "glow").c_str());
  }
}

TEST(Roads, SphereAtAnyDicingRateIsTheSamePicture) {
  const auto picture = [](const char* length) {
    RenderRequest r;
    r.rib = head(64) + unbiased(2) + "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n" +
            "Attribute \"dice\" \"float micropolygonlength\" [" + length + "]\n" + kFloorAndBall + "WorldEnd\n";
    SceneRender render(r);
    return render.channel("Ci");
  };
  const image::Image coarse = picture("4"), normal = picture("1"), fine = picture("0.25");
  // the same samples meet nearly the same surface: what is left is silhouettes and facets
  EXPECT_LT(rmse(normal, fine), 0.02 * mean(fine));
  EXPECT_LT(rmse(coarse, fine), 0.06 * mean(fine))
      << SceneRender::keep(coarse, "coarse") << SceneRender::keep(fine, "fine");
  EXPECT_NEAR(mean(normal), mean(fine), 0.002 * mean(fine));
}

TEST(Roads, ShapesByNameAndTrimmedSurfacesAreWhatTheyStandFor) {
  const auto picture = [](const std::string& what) {
    RenderRequest r;
    r.rib =
        head(64) + unbiased(2) + "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n" +
        "Bxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [0.6 0.5 0.4]\n" +  // facets of so few pixels would show
        "Attribute \"dice\" \"float micropolygonlength\" [0.1]\n" +
        "Polygon \"vertex point P\" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]\nRotate -90 1 0 0\n" + what + "WorldEnd\n";
    SceneRender render(r);
    return render.channel("Ci");
  };
  const auto expectSame = [&](const std::string& one, const std::string& other, const char* what) {
    const image::Image a = picture(one), b = picture(other);
    // the same samples meet nearly the same surface
    EXPECT_LT(rmse(a, b), 0.02 * mean(b)) << SceneRender::keep(a, what) << SceneRender::keep(b, "other");
    EXPECT_NEAR(mean(a), mean(b), 0.002 * mean(b)) << what;
  };
  std::string patches = "Basis \"bezier\" 3 \"bezier\" 3\nTranslate 0 0 -0.15\n";
  for (int k = 0; k < 28; ++k) {
    patches += "Patch \"bicubic\" \"P\" [";
    for (const uint16_t i : geometry::kTeapotPatches[k])
      for (const float c : geometry::kTeapotPoints[i - 1]) patches += std::to_string(c) + " ";
    patches += "]\n";
  }
  const std::string small = "Scale 0.35 0.35 0.35\n";
  expectSame(small + "Geometry \"teapot\"\n", small + patches, "teapot");
  // a ring in a square of 2, standing up
  const std::string up = "Rotate 60 1 0 0 Translate 0 1 -0.3\n";
  const auto circle = [](double radius, bool isU) {
    std::string out;
    const int d[9][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    for (int i = 0; i < 9; ++i)
      out += std::to_string((0.5 + radius * d[i][isU ? 0 : 1]) * (i % 2 ? std::sqrt(0.5) : 1)) + " ";
    return out;
  };
  const std::string knots = "0 0 0 1 1 2 2 3 3 4 4 4 ",
                    weights = "1 0.7071068 1 0.7071068 1 0.7071068 1 0.7071068 1 ";
  expectSame(up + "TrimCurve [1 1] [3 3] [" + knots + knots + "] [0 0] [4 4] [9 9] [" + circle(0.4, true) +
                 circle(0.2, true) + "] [" + circle(0.4, false) + circle(0.2, false) + "] [" + weights + weights +
                 "]\nNuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n",
             up + "Hyperboloid 0.4 0 0 0.8 0 0 360\n", "ring");
}

const char* const kPiece = R"(AttributeBegin
Bxdf "PxrSurface" "p" "color diffuseColor" [0.5 0.2 0.2] "color specularFaceColor" [0.3 0.3 0.3] "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.3]
Scale 0.3 0.5 0.3
Sphere 1 -1 1 360
AttributeEnd
AttributeBegin
Bxdf "PxrDiffuse" "q" "color diffuseColor" [0.2 0.5 0.3]
Polygon "vertex point P" [-0.5 -0.4 -0.5  -0.5 -0.4 0.5  0.5 -0.4 0.5  0.5 -0.4 -0.5]
AttributeEnd
)";
std::string placed(const std::string& what, bool mirrored) {
  std::string s;
  const char* const places[] = {"Translate -0.7 0.6 0 Rotate 20 0 1 0", "Translate 0.7 0.6 0.4 Rotate -50 1 1 0",
                                "Translate 0 1.2 0.8 Scale 0.6 0.9 0.6"};
  for (const char* p : places)
    s += "AttributeBegin " + std::string(p) + (mirrored ? " Scale -1 1 1" : "") + "\n" + what + "AttributeEnd\n";
  return s;
}

TEST(Roads, InstancesAreCopies) {
  for (const bool mirrored : {false, true}) {
    const std::string before = head(64) + unbiased(3) +
                               "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [0.5]\n"
                               "AttributeBegin Translate 0 3 0 Rotate 90 1 0 0 Light \"PxrRectLight\" \"l\" \"float "
                               "intensity\" [4] AttributeEnd\n";
    RenderRequest instances, copies;
    instances.rib = before + "ObjectBegin \"o\"\n" + kPiece + "ObjectEnd\n" +
                    placed("ObjectInstance \"o\"\n", mirrored) + "WorldEnd\n";
    copies.rib = before + placed(kPiece, mirrored) + "WorldEnd\n";
    SceneRender a(instances), b(copies);
    ASSERT_TRUE(a.ok() && b.ok());
    const image::Image x = a.channel("Ci"), y = b.channel("Ci");
    // the same samples; rounding sends few paths elsewhere, and instances are diced for their nearest use
    EXPECT_LT(rmse(x, y), 0.03 * mean(y))
        << SceneRender::keep(x, "instances") << ' ' << SceneRender::keep(y, "copies");
    EXPECT_NEAR(mean(x), mean(y), 0.002 * mean(y));
  }
}

TEST(Roads, FarFromTheOriginIsTheSamePicture) {
  const auto picture = [](double far) {
    const std::string x = std::to_string(far), y = std::to_string(-2 * far), z = std::to_string(far / 3);
    const auto negative = [](double v) { return std::to_string(-v); };
    RenderRequest r;
    r.rib = head(64, "Translate 0 -0.6 4\nTranslate " + negative(far) + " " + negative(-2 * far) + " " +
                         negative(far / 3) + "\n") +
            unbiased(3) + "WorldBegin\nTranslate " + x + " " + y + " " + z +
            "\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [0.5]\n"
            "AttributeBegin Translate 0 3 0 Rotate 90 1 0 0 Light \"PxrRectLight\" \"l\" \"float intensity\" [4] "
            "AttributeEnd\n"
            "ObjectBegin \"o\"\n" +
            kPiece + "ObjectEnd\n" + placed("ObjectInstance \"o\"\n", false) + kFloorAndBall + "WorldEnd\n";
    SceneRender render(r);
    return render.channel("Ci");
  };
  const image::Image near = picture(0), far = picture(1e6);
  // the same samples of nearly the same numbers: single precision near the camera, double for places
  EXPECT_LT(rmse(far, near), 0.01 * mean(near))
      << SceneRender::keep(far, "far") << ' ' << SceneRender::keep(near, "near");
  EXPECT_NEAR(mean(far), mean(near), 0.001 * mean(near));
}

TEST(Roads, LinkedLightsAreTheOnlyOnes) {
  const char* const lightA =
      "AttributeBegin Attribute \"grouping\" \"string membership\" [\"A\"]\nConcatTransform [1 0 0 0  0 0 1 0  0 -1 "
      "0 0  -1 2 0 1]\n"
      "Light \"PxrRectLight\" \"a\" \"float intensity\" [5] AttributeEnd\n";
  const char* const lightB =
      "AttributeBegin Attribute \"grouping\" \"string membership\" [\"B\"]\nTranslate 1.5 1.5 -1\n"
      "Light \"PxrSphereLight\" \"b\" \"float intensity\" [5] AttributeEnd\n";
  const char* const lightC =
      "AttributeBegin Attribute \"grouping\" \"string membership\" [\"C\"]\nLight \"PxrDomeLight\" \"c\" \"float "
      "intensity\" [1] AttributeEnd\n";
  const auto request = [&](const std::string& lights, const std::string& link, const char* samples) {
    RenderRequest r;
    // lights unseen by the camera: only their light counts
    r.rib = head(*samples ? 96 : 32) + unbiased(1, samples) +
            "WorldBegin\nAttributeBegin\nAttribute \"visibility\" \"int camera\" [0]\n" + lights + "AttributeEnd\n" +
            link + kFloorAndBall +
            // a sheet that is not there: looking at it must not change whose lights count
            "Bxdf \"PxrDiffuse\" \"none\" \"float presence\" [0]\nAttribute \"lighting\" \"string subset\" [\"\"] "
            "\"string excludesubset\" [\"\"]\n"
            "Polygon \"vertex point P\" [-3 1.4 -3  3 1.4 -3  3 1.4 3  -3 1.4 3]\nWorldEnd\n";
    return r;
  };
  const std::string all = std::string(lightA) + lightB + lightC;
  for (const char* samples : {"", "\"int numLightSamples\" [0]"}) {
    const auto alone = overSeeds(request(lightA, "", samples), 10);
    EXPECT_SAME_MEAN(
        alone, overSeeds(request(all, "Attribute \"lighting\" \"string subset\" [\"A\"]\n", samples), 10), 0.01);
    EXPECT_SAME_MEAN(
        alone, overSeeds(request(all, "Attribute \"lighting\" \"string excludesubset\" [\"B C\"]\n", samples), 10),
        0.01);
  }
}

}  // namespace
}  // namespace kinora::tests
