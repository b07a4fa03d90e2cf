// What patterns read of primitive variables that some objects have and others have not, and of reference positions
// however they are said.
#include <gtest/gtest.h>

#include <string>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

// Two quads of four pixels each, the left one with `left` among its primitive variables; both moved. The middle of each.
struct Pair {
  double left[3], right[3];
};
Pair shown(const std::string& pattern, const std::string& output, const std::string& left,
           const std::string& right = "") {
  RenderRequest r;
  r.rib =
      "Format 8 4 1\nProjection \"orthographic\"\nScreenWindow 0 2 -0.5 0.5\nHider \"raytrace\" \"int maxsamples\" "
      "[1] \"int minsamples\" [1] \"int jitter\" [0]\nPixelFilter \"box\" 1 1\nIntegrator \"PxrDefault\" \"i\"\n"
      "WorldBegin\n" +
      pattern + "\nBxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"p:" + output + "\"]\n";
  for (int i = 0; i < 2; ++i)
    r.rib += "AttributeBegin Translate " + std::to_string(i + 0.5) +
             " 0 3\nPolygon \"P\" [-0.5 -0.5 0 0.5 -0.5 0 0.5 0.5 0 -0.5 0.5 0] " + (i ? right : left) +
             "\nAttributeEnd\n";
  r.rib += "WorldEnd\n";
  SceneRender render(r);
  Pair out{};
  if (!render.ok()) return out;
  const image::Image picture = render.channel("Ci");
  for (int k = 0; k < 3; ++k) {
    out.left[k] = picture.at(1, 2)[k];
    out.right[k] = picture.at(5, 2)[k];
  }
  return out;
}
void expectColor(const double c[3], double r, double g, double b) {
  EXPECT_NEAR(c[0], r, 1e-4);
  EXPECT_NEAR(c[1], g, 1e-4);
  EXPECT_NEAR(c[2], b, 1e-4);
}

TEST(PrimvarPatterns, ObjectsWithoutAVariableHaveTheDefault) {
  Pair p = shown("Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"a\"] \"float defaultFloat\" [0.7]", "resultRGB",
                 "\"constant float a\" [0.25]");
  expectColor(p.left, 0.25, 0.25, 0.25);
  expectColor(p.right, 0.7, 0.7, 0.7);
  p = shown(
      "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"a\"] \"string type\" [\"color\"] \"color defaultColor\" "
      "[0.1 0.2 0.3]",
      "resultRGB", "\"constant color a\" [0.6 0.5 0.4]");
  expectColor(p.left, 0.6, 0.5, 0.4);
  expectColor(p.right, 0.1, 0.2, 0.3);
  p = shown(
      "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"a\"] \"string type\" [\"point\"] \"vector defaultFloat3\" "
      "[0.1 0.2 0.3]",
      "resultRGB", "\"constant point a\" [0.6 0.5 0.4]");
  expectColor(p.left, 0.6, 0.5, 0.4);
  expectColor(p.right, 0.1, 0.2, 0.3);
}

TEST(PrimvarPatterns, ObjectsWithoutAVariableHaveTheirOwnPlaces) {
  const std::string st = "\"st\" [0.25 0.75 0.25 0.75 0.25 0.75 0.25 0.75] ";
  Pair p = shown(
      "Pattern \"PxrManifold2D\" \"p\" \"string primvarS\" [\"a\"]\nPattern \"PxrToFloat3\" \"q\" "
      "\"reference float inputR\" [\"p:resultS\"]",
      "resultS", st + "\"constant float a\" [0.9]", st);
  EXPECT_NEAR(p.left[0], 0.9, 1e-4);
  EXPECT_NEAR(p.right[0], 0.25, 1e-4);
  // where another object's variable has two components, one of one gives s alone
  p = shown("Pattern \"PxrManifold2D\" \"p\" \"string primvarS\" [\"a\"]", "resultT",
            st + "\"constant float a\" [0.9]", st + "\"constant float[2] a\" [0.3 0.6]");
  EXPECT_NEAR(p.left[0], 1 - 0.75, 1e-4);  // t runs down
  EXPECT_NEAR(p.right[0], 1 - 0.6, 1e-4);
  p = shown("Pattern \"PxrManifold3D\" \"p\" \"int use\" [1]", "resultX", "\"constant point __Pref\" [7 8 9]");
  EXPECT_NEAR(p.left[0], 7, 1e-4);
  EXPECT_NEAR(p.right[0], -0.125, 1e-4);
}

// Exporters write rest positions as points, as vectors, as colours or as three numbers: all are the object's own.
TEST(PrimvarPatterns, ReferencePositionsAreTheObjectsOwnHoweverTheyAreSaid) {
  for (const char* type : {"point", "vector", "color", "float[3]"}) {
    SCOPED_TRACE(type);
    const std::string rest = std::string("\"constant ") + type + " __Pref\" [0.1 0.2 0.3]";
    const Pair x = shown("Pattern \"PxrManifold3D\" \"p\" \"int use\" [1]", "resultX", rest),
               z = shown("Pattern \"PxrManifold3D\" \"p\" \"int use\" [1]", "resultZ", rest);
    EXPECT_NEAR(x.left[0], 0.1, 1e-4);
    EXPECT_NEAR(z.left[0], 0.3, 1e-4);
  }
  const Pair beside = shown("Pattern \"PxrManifold3D\" \"p\" \"int use\" [1]", "resultY",
                            "\"constant point __Pref\" [0.1 0.2 0.3]", "\"constant float[3] __Pref\" [0.4 0.5 0.6]");
  EXPECT_NEAR(beside.left[0], 0.2, 1e-4);
  EXPECT_NEAR(beside.right[0], 0.5, 1e-4);
}

// Footprints too: a texture that is seen aslant by coordinates of its own is looked up alike beside an object that has the
// variable and without it, whichever points are shaded together.
TEST(PrimvarPatterns, LookupsDoNotDependOnWhatIsBeside) {
  const auto render = [](bool hasLeft, bool hasRight, uint32_t group) {
    RenderRequest r;
    r.settings.groupSize = group;
    r.rib =
        "Format 16 8 1\nProjection \"orthographic\"\nScreenWindow 0 2 -0.5 0.5\nHider \"raytrace\" \"int "
        "maxsamples\" "
        "[4] \"int minsamples\" [4]\nPixelFilter \"box\" 1 1\nIntegrator \"PxrDefault\" \"i\"\nWorldBegin\n"
        "Pattern \"PxrManifold2D\" \"m\" \"string primvarS\" [\"a\"]\n"
        "Pattern \"PxrTexture\" \"p\" \"string filename\" [\"" KINORA_SOURCE_DIR
        "/scenes/sky.hdr\"] \"reference struct manifold\" [\"m:result\"]\n"
        "Bxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"p:resultRGB\"]\n";
    const auto quad = [&](int i, const char* more) {
      r.rib += "AttributeBegin Translate " + std::to_string(i + 0.5) +
               " 0 3 Rotate 70 1 0 0\nPolygon \"P\" [-0.5 -1 0 0.5 -1 0 0.5 1 0 -0.5 1 0] "
               "\"st\" [0.1 0.1 0.4 0.1 0.4 0.9 0.1 0.9] " +
               more + "\nAttributeEnd\n";
    };
    if (hasLeft) quad(0, "\"facevarying float[2] a\" [0.2 0.2 0.6 0.2 0.6 0.7 0.2 0.7]");
    if (hasRight) quad(1, "");
    r.rib += "WorldEnd\n";
    SceneRender s(r);
    return s.ok() ? s.channel("Ci") : image::Image();
  };
  const image::Image both = render(true, true, 256), few = render(true, true, 16), left = render(true, false, 256),
                     right = render(false, true, 256);
  ASSERT_FALSE(both.pixels.empty() || few.pixels.empty() || left.pixels.empty() || right.pixels.empty());
  EXPECT_EQ(both.pixels, few.pixels);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x)
      for (int k = 0; k < 3; ++k) EXPECT_EQ(both.at(x, y)[k], (x < 8 ? left : right).at(x, y)[k]) << x << " " << y;
}

TEST(PrimvarPatterns, RampsReachTheirLastKnotAndGoByTheirCurve) {
  const auto at = [](const char* place, const std::string& more) {
    return shown("Pattern \"PxrRamp\" \"p\" \"int rampType\" [6] \"float splineMap\" [" + std::string(place) + "] " +
                     "\"float[2] positions\" [0 0.5] \"color[2] colors\" [1 0 0 0 1 0] " + more,
                 "resultRGB", "");
  };
  expectColor(at("0.25", "\"int basis\" [1]").left, 1, 0, 0);
  expectColor(at("0.5", "\"int basis\" [1]").left, 0, 1, 0);
  expectColor(at("0.8", "\"int basis\" [1]").left, 0, 1, 0);
  expectColor(at("0.125", "\"int basis\" [0] \"string colorRamp_Interpolation\" [\"linear\"]").left, 0.75, 0.25, 0);
}

}  // namespace
}  // namespace kinora::tests
