// Proves: positions in object space are each object's own, whether the object is baked into render space, placed, or
// moves, and whether they come from the surface or from a primitive variable of points. Misses: spaces other than
// "object".
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

// Two turned squares of one program; their colour is noise at the position in object space, from where `use` says.
std::string scene(int use, const std::string& how) {
  const std::string square =
      "PointsPolygons [4] [0 1 2 3] \"vertex point P\" [-1 -1 1  -1 1 1  1 1 1  1 -1 1] "
      "\"vertex point where\" [-1 -1 1  -1 1 1  1 1 1  1 -1 1]\n";
  const auto place = [&](double x, double angle) {
    const std::string move =
        "Translate " + std::to_string(x) + " 0 2\nRotate " + std::to_string(angle) + " 0 0 1\nScale 0.9 0.9 1\n";
    if (how == "instance") return "AttributeBegin\n" + move + "ObjectInstance \"square\"\nAttributeEnd\n";
    if (how == "moving")
      return "AttributeBegin\nMotionBegin [0 1]\nTranslate 0 0 0\nTranslate 0 0 0.000001\nMotionEnd\n" + move +
             square + "AttributeEnd\n";
    return "AttributeBegin\n" + move + square + "AttributeEnd\n";
  };
  return "Format 48 24 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [4]\nShutter 0 1\n"
         "ScreenWindow -2 2 -1 1\nProjection \"orthographic\"\nWorldBegin\n"
         "Pattern \"PxrManifold3D\" \"own\" \"int use\" [" +
         std::to_string(use) +
         "] \"string pref\" [\"where\"] \"string coordsys\" [\"object\"]\n"
         "Pattern \"PxrFractal\" \"veins\" \"reference struct manifold\" [\"own:result\"] \"float frequency\" [2]\n"
         "Bxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"veins:resultRGB\"]\n" +
         (how == "instance" ? "ObjectBegin \"square\"\n" + square + "ObjectEnd\n" : "") + place(-1, 20) +
         place(1, -50) + "WorldEnd\n";
}

TEST(Spaces, ObjectSpaceIsEachObjectsOwn) {
  const auto picture = [](int use, const std::string& how) {
    RenderRequest r;
    r.rib = scene(use, how);
    SceneRender s(r);
    EXPECT_TRUE(s.ok()) << how;
    return s.ok() ? s.channel("Ci") : image::Image();
  };
  const image::Image base = picture(0, "baked");
  ASSERT_GT(base.width(), 0);
  // the halves are the same noise turned: neither black nor one another's copy
  double sum = 0, contrast = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      sum += double(base.at(x, y)[0]);
      contrast += std::abs(double(base.at(x, y)[0]) - double(base.at(x + 24, y)[0]));
    }
  EXPECT_GT(sum, 30);
  EXPECT_GT(contrast, 5);
  for (const char* how : {"baked", "instance", "moving"})
    for (const int use : {0, 1}) {
      const image::Image other = picture(use, how);
      ASSERT_EQ(other.width(), base.width());
      // samples on the outline may fall to either side: a few pixels may differ
      int different = 0;
      for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 48; ++x)
          different += std::abs(double(base.at(x, y)[0]) - double(other.at(x, y)[0])) > 5e-3;
      EXPECT_LE(different, 25) << how << ", use " << use;
    }
}

}  // namespace
}  // namespace kinora::tests
