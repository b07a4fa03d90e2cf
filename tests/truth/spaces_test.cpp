// Proves: positions in object space are each object's own, whether the object is baked into render space, placed, or
// moves, and whether they come from the surface or from a primitive variable of points; systems by name are each
// instance's own where its object names them, are where they are at the time of a sample, and are told where nothing
// names them. Misses: light filters.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

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

// The mean colour of a picture that shows how far along an axis the surface lies in a space, or the square of that.
class InSpace {
 public:
  InSpace(const std::string& space, const std::string& axis, bool isSquared, const std::string& world) {
    RenderRequest r;
    r.rib =
        "Format 8 4 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [256]\nShutter 0 1\n"
        "ScreenWindow -2 2 -1 1\nProjection \"orthographic\"\nWorldBegin\n" +
        replaced(world, "Pattern \"PxrManifold3D\" \"m\" \"string coordsys\" [\"" + space +
                            "\"]\nPattern \"PxrToFloat3\" \"f\" \"reference float inputR\" [\"m:result" + axis +
                            "\"]\nPattern \"PxrArithmetic\" \"sq\" \"int operation\" [1] \"reference color input1\" "
                            "[\"f:resultRGB\"] \"reference color input2\" [\"f:resultRGB\"]\n"
                            "Bxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"" +
                            (isSquared ? "sq" : "f") + ":resultRGB\"]\n") +
        "WorldEnd\n";
    scene_ = std::make_unique<SceneRender>(r);
    if (scene_->ok()) picture_ = scene_->channel("Ci");
  }
  // Of the left or right half; -1: there is no picture.
  double mean(bool isRight) const {
    double sum = 0;
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4 && picture_.width() == 8; ++x) sum += double(picture_.at(x + (isRight ? 4 : 0), y)[0]);
    return picture_.width() == 8 ? sum / 16 : -1;
  }
  std::string said(const std::string& code) const {
    for (const std::string& m : scene_->messages())
      if (m.find(code) != std::string::npos) return m;
    return "";
  }

 private:
  static std::string replaced(std::string text, const std::string& material) {
    const size_t at = text.find("MATERIAL");
    return text.replace(at, 8, material);
  }
  std::unique_ptr<SceneRender> scene_;
  image::Image picture_;
};

// Each instance of an object has the systems that its definition names, whatever the place of the primitive in it; the
// object may be of several primitives, which are one part of the world.
TEST(Spaces, SystemsOfObjectsFollowTheirInstances) {
  const std::string card = "Polygon \"P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]\n";
  for (const char* request : {"ScopedCoordinateSystem", "CoordinateSystem"})
    for (const bool isOfTwo : {false, true}) {
      const std::string object = std::string("ObjectBegin \"o\"\nTransformBegin\nTranslate 0 0 -2\n") + request +
                                 " \"cs\"\nTransformEnd\nMATERIAL\nTransformBegin\nTranslate 0 0 .5\n" + card +
                                 "TransformEnd\n" + (isOfTwo ? "Translate 0 0 7\n" + card : "") + "ObjectEnd\n";
      const InSpace s("cs", "Z", false,
                      object +
                          "AttributeBegin\nTranslate -1 0 5\nObjectInstance \"o\"\nAttributeEnd\n"
                          "AttributeBegin\nTranslate 1 0 8\nScale 1 1 2\nObjectInstance \"o\"\nAttributeEnd\n");
      EXPECT_NEAR(s.mean(false), 2.5, 1e-4) << request << isOfTwo;
      EXPECT_NEAR(s.mean(true), 2.5, 1e-4) << request << isOfTwo;
      EXPECT_EQ(s.said("COORDSYS"), "");
    }
}

// A system that goes from -1 to 1 while the shutter is open: a point at x is at x + 1 - 2t in it, the mean of whose square
// is x^2 + 1/3. Frozen in the middle of the shutter it would be x^2.
TEST(Spaces, SystemsMoveWithTheShutter) {
  const std::string moves =
      "TransformBegin\nMotionBegin [0 1]\nTranslate -1 0 0\nTranslate 1 0 0\nMotionEnd\n"
      "CoordinateSystem \"cs\"\nTransformEnd\n";
  const std::string wall = "MATERIAL\nPolygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\n";
  const InSpace s("cs", "X", true, moves + wall);
  double expected = 0;
  for (int x = 0; x < 4; ++x) {
    const double at = -1.75 + .5 * x;  // of the pixel's middle; with its width of .5
    expected += (at * at + .25 / 12 + 1. / 3) / 4;
  }
  EXPECT_NEAR(s.mean(false), expected, .02);
  // an instance in motion takes the systems of its object along
  const InSpace own("cs", "X", true,
                    "ObjectBegin \"o\"\nCoordinateSystem \"cs\"\nMATERIAL\n"
                    "Polygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\nObjectEnd\n"
                    "MotionBegin [0 1]\nTranslate -1 0 0\nTranslate 1 0 0\nMotionEnd\nObjectInstance \"o\"\n");
  EXPECT_NEAR(own.mean(false), expected, .02);
}

TEST(Spaces, NamesThatNothingGivesAreTold) {
  const std::string world = "CoordinateSystem \"mark\"\nMATERIAL\nPolygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\n";
  const std::string said = InSpace("marc", "Z", false, world).said("PATTERN-COORDSYS");
  for (const char* part : {"PxrManifold3D \"m\"", "'marc'", "camera", "mark", "object", "world"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
  for (const char* known : {"mark", "world", "camera", "object"})
    EXPECT_EQ(InSpace(known, "Z", false, world).said("PATTERN-COORDSYS"), "") << known;
}

}  // namespace
}  // namespace kinora::tests
