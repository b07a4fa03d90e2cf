// Media around paths: a volume that several primitives of one material close is one volume, and nests may be of any
// depth. Pictures of parts are compared with pictures of wholes tile by tile, and with Beer and Lambert where rays go
// straight. Misses shadow rays, which know no media.
#include <cmath>

#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

constexpr int kSide = 32, kTile = 8, kSeeds = 24;

std::string stage(const std::string& objects, int bounces = 10) {
  return R"(
Hider "raytrace" "int maxsamples" [16]
Display "probe.exr" "openexr" "Ci,a"
Format 32 32 1
PixelFilter "box" 1 1
Projection "perspective" "fov" [30]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [)" +
         std::to_string(bounces) +
         R"(] "float clampLuminance" [1e30] "float rouletteThreshold" [0] "int allowCaustics" [1]
Translate 0 0 4
WorldBegin
  Light "PxrDomeLight" "sky" "color lightColor" [1 .8 .6]
  AttributeBegin
    Pattern "PxrChecker" "check" "color colorA" [.9 .9 .9] "color colorB" [.1 .1 .1]
    Bxdf "PxrDiffuse" "floor" "reference color diffuseColor" ["check:resultRGB"]
    Polygon "vertex point P" [-3 -1 -2  3 -1 -2  3 -1 4  -3 -1 4] "facevarying float[2] st" [0 0 8 0 8 8 0 8]
  AttributeEnd
)" + objects +
         "\nWorldEnd\n";
}

TileMoments momentsOf(const std::string& text) {
  TileMoments m;
  Workshop shop;
  render::Settings s;
  s.threads = 2;
  forSeeds(shop, text, s, 1, kSeeds,
           [&](render::Renderer& renderer) { m.add(pictureOf(renderer), kSide, kSide, kTile); });
  return m;
}

// A sphere as one primitive, and as two half spheres whose rims meet.
std::string whole(const std::string& r) { return "Sphere " + r + " -" + r + " " + r + " 360\n"; }
std::string halves(const std::string& r) {
  return "Sphere " + r + " -" + r + " 0 360\nSphere " + r + " 0 " + r + " 360\n";
}

TEST(NestedMedia, HalvesOfGlassAreOneVolume) {
  const std::string turn = "Rotate 50 1 .3 0\n";
  const struct {
    const char* name;
    std::string before, glass, after;
  } cases[] = {
      {"alone", "", "Bxdf \"PxrGlass\" \"g\" \"float ior\" [1.5]\n", ""},
      {"with absorption", "",
       "Bxdf \"PxrGlass\" \"g\" \"float ior\" [1.5] \"color absorptionColor\" [.2 .5 1] \"float absorptionGain\" "
       "[1.5]\n",
       ""},
      {"rough", "", "Bxdf \"PxrGlass\" \"g\" \"float ior\" [1.5] \"float roughness\" [.2]\n", ""},
      {"in water",
       "Bxdf \"PxrGlass\" \"w\" \"float ior\" [1.33] \"color absorptionColor\" [1 .5 .2] \"float absorptionGain\" "
       "[.3]\n" +
           whole(".95"),
       "Bxdf \"PxrGlass\" \"g\" \"float ior\" [1.6]\n", ""},
      {"around air", "", "Bxdf \"PxrGlass\" \"g\" \"float ior\" [1.5]\n", "ReverseOrientation\n" + whole(".3")},
  };
  for (const auto& c : cases) {
    const auto objects = [&](const std::string& sphere) {
      return "AttributeBegin\n" + turn + c.before + c.glass + sphere + c.after + "AttributeEnd\n";
    };
    const TileMoments one = momentsOf(stage(objects(whole(".7")))), two = momentsOf(stage(objects(halves(".7"))));
    const TileTest t = compareTiles(two, one);
    EXPECT_TRUE(t.agrees()) << c.name << ": worst z " << t.worstZ;
    EXPECT_NEAR(two.mean(), one.mean(), 0.01 * one.mean()) << c.name;
    EXPECT_LT(t.meanError, 0.05) << c.name << ": too few samples to judge";
  }
}

// Two media of different materials, one of them closed by two primitives: inside stays inside.
TEST(NestedMedia, AnyDepthOfNestsAbsorbs) {
  // spheres of index 1 bend nothing and reflect nothing: light through the middle passes each shell twice
  for (const int depth : {3, 5, 12, 40}) {
    std::string objects;
    double optical = 0;
    for (int i = 0; i < depth; ++i) {
      const double r = 1 - 0.9 * i / depth, next = i + 1 < depth ? 1 - 0.9 * (i + 1) / depth : 0,
                   a = .1 + .05 * (i % 7);
      optical += 2 * (r - next) * a;
      objects += "Bxdf \"PxrGlass\" \"g" + std::to_string(i) +
                 "\" \"float ior\" [1] \"color absorptionColor\" [1 1 1] \"float absorptionGain\" [" +
                 std::to_string(a) + "]\n" + whole(std::to_string(r));
    }
    const std::string text = R"(
Hider "raytrace" "int maxsamples" [4]
Display "probe.exr" "openexr" "Ci,a"
Format 8 8 1
PixelFilter "box" 1 1
ScreenWindow -.01 .01 -.01 .01
Projection "orthographic"
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [100] "float clampLuminance" [1e30] "float rouletteThreshold" [0] "int allowCaustics" [1]
Translate 0 0 3
WorldBegin
  Light "PxrDomeLight" "sky"
)" + objects + "WorldEnd\n";
    Workshop shop;
    render::Settings s;
    const auto renderer = shop.load(sceneOf(text, shop.messages), s);
    const image::Image p = pictureOf(*renderer);
    double sum = 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) sum += p.at(x, y)[0] / 64;
    EXPECT_NEAR(sum, std::exp(-optical), 0.01 * std::exp(-optical)) << depth << " deep";
  }
}

TEST(NestedMedia, RaysThatPassTooMuchAreCountedAndTold) {
  for (const int cards : {200, 300}) {
    std::string objects = "Bxdf \"PxrSurface\" \"absent\" \"float presence\" [0]\n";
    for (int i = 0; i < cards; ++i) {
      const std::string z = std::to_string(2 + i * 0.01);
      objects += "Polygon \"vertex point P\" [-9 -9 " + z + " 9 -9 " + z + " 9 9 " + z + " -9 9 " + z + "]\n";
    }
    const std::string text = R"(
Hider "raytrace" "int maxsamples" [1]
Display "probe.exr" "openexr" "Ci,a"
Format 4 4 1
Projection "orthographic"
WorldBegin
  Bxdf "PxrConstant" "white"
  Polygon "vertex point P" [-9 -9 20 9 -9 20 9 9 20 -9 9 20]
)" + objects + "WorldEnd\n";
    Workshop shop;
    const auto renderer = shop.load(sceneOf(text, shop.messages), {});
    const float expected = cards < 256 ? 1.f : 0.f;
    EXPECT_NEAR(pictureOf(*renderer).at(2, 2)[0], expected, 1e-4) << cards;
    EXPECT_EQ(shop.said.find("RENDER-PASSES") != std::string::npos, cards > 256) << shop.said;
  }
}

}  // namespace
}  // namespace kinora::probes
