// Controls of forward paths, each against a closed form or a scene without what it leaves out: alpha through glass, how
// many absent surfaces a ray passes, clamps of direct light, the factor on what glows, how far surfaces are met, light
// without shadows at the end of paths.
#include <string>
#include <vector>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

// What an orthographic camera sees of things in front of it; it looks along z, 2 x 2 wide.
std::string view(const std::string& things, int samples = 64) {
  return R"(
Hider "raytrace" "int maxsamples" [)" +
         std::to_string(samples) + R"(]
Display "probe.exr" "openexr" "Ci,a"
Format 16 16 1
PixelFilter "box" 1 1
Projection "orthographic"
WorldBegin
)" + things +
         "WorldEnd\n";
}
// A square at this depth that faces the camera and fills its view.
std::string square(double z, double size = 4) {
  const auto n = [](double x) { return std::to_string(x) + " "; };
  const std::string s = n(size), m = n(-size), d = n(z);
  return "Polygon \"vertex point P\" [" + m + m + d + m + s + d + s + s + d + s + m + d + "]\n";
}
struct Mean {
  double color = 0, alpha = 0;
};
Mean meanOf(const std::string& text, const std::string& integrator, const Sets& sets, std::string* said = nullptr,
            uint32_t seeds = 1) {
  Mean m;
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    Workshop stage;
    render::Settings s;
    s.threads = 1;
    s.seed = 10 + seed;
    s.integrator = integrator;
    for (const auto& [name, value] : sets) s.sets.emplace_back("integrator." + name, value);
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    const image::Image color = pictureOf(*r), alpha = r->film().resolve(r->film().layout().find("a"));
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        m.color += (color.at(x, y)[0] + color.at(x, y)[1] + color.at(x, y)[2]) / (3 * 256. * seeds);
        m.alpha += alpha.at(x, y)[0] / (256. * seeds);
      }
    if (said) *said = stage.said;
  }
  return m;
}
const Sets kTrue{{"rouletteThreshold", "0"}, {"maxIndirectBounces", "6"}};
Sets with(Sets more) {
  more.insert(more.end(), kTrue.begin(), kTrue.end());
  return more;
}

// A block of glass across the view: what goes through both boundaries at right angles is (1 - F)^2.
const std::string kBlock = R"(
  AttributeBegin
    Bxdf "PxrGlass" "glass" "float ior" [1.5] "color transmissionColor" [0.5 0.8 0.9]
    PointsPolygons [4 4] [0 1 2 3 7 6 5 4] "vertex point P" [-4 -4 5 -4 4 5 4 4 5 4 -4 5 -4 -4 6 -4 4 6 4 4 6 4 -4 6]
  AttributeEnd
)";

TEST(PathControls, AlphaThroughGlass) {
  const double once = 0.96, mean = (0.25 + 0.64 + 0.81) / 3, through = once * once * mean;
  for (const char* integrator : {"PxrPathTracer", "PxrUnified"}) {
    for (const char* caustics : {"0", "1"}) {
      Sets sets = with({{"accumOpacity", "1"}});
      if (std::string(integrator) == "PxrPathTracer") sets.emplace_back("allowCaustics", caustics);
      EXPECT_NEAR(meanOf(view(kBlock), integrator, sets).alpha, 1 - through, 0.006) << integrator;
    }
    EXPECT_NEAR(meanOf(view(kBlock), integrator, with({{"accumOpacity", "0"}})).alpha, 1, 1e-6);
    // in front of what covers all, before an infinite light, and cut off before it is through
    const std::string wall = "Bxdf \"PxrConstant\" \"wall\" \"color emitColor\" [0 0 0]\n" + square(9);
    EXPECT_NEAR(meanOf(view(kBlock + wall), integrator, with({{"accumOpacity", "1"}})).alpha, 1, 1e-6);
    const std::string dome = "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n";
    EXPECT_NEAR(meanOf(view(dome + kBlock), integrator, with({{"accumOpacity", "1"}})).alpha, 1 - through, 0.006);
    EXPECT_NEAR(meanOf(view(kBlock), integrator, {{"accumOpacity", "1"}, {"maxIndirectBounces", "0"}}).alpha, 1,
                1e-6);
    // half of the view
    const std::string half = "TransformBegin\nTranslate 4 0 0\n" + kBlock + "TransformEnd\n";
    EXPECT_NEAR(meanOf(view(half), integrator, with({{"accumOpacity", "1"}})).alpha, 0.5 * (1 - through), 0.006);
  }
  // with several directions, by kind or not
  for (const Sets& several :
       {Sets{{"numIndirectSamples", "3"}}, Sets{{"sampleMode", "manual"}, {"numRefractionSamples", "4"}}}) {
    Sets sets = with(several);
    sets.emplace_back("accumOpacity", "1");
    EXPECT_NEAR(meanOf(view(kBlock), "PxrPathTracer", sets).alpha, 1 - through, 0.006);
  }
}

TEST(PathControls, AlphaThroughGlassInSameBits) {
  expectSameBits({}, R"(Integrator "PxrPathTracer" "i" "int accumOpacity" [1])" + roomOfEverything(), "");
}

// Three squares of which a quarter is there, the last one of them glowing, before nothing.
TEST(PathControls, PassesSoManyAbsentSurfaces) {
  const std::string card = R"(Bxdf "PxrConstant" "card" "color emitColor" [0 0 0] "float presence" [0.25])"
                           "\n";
  const std::string glow = R"(Bxdf "PxrConstant" "glow" "color emitColor" [1 1 1] "float presence" [0.25])"
                           "\n";
  const std::string text = view(card + square(4) + square(5) + glow + square(6), 256);
  const auto at = [&](const char* most) { return meanOf(text, "PxrPathTracer", {{"maxContinuationLength", most}}); };
  const double p = 0.25, q = 0.75, error = 4 * 0.5 / std::sqrt(256. * 256);
  EXPECT_NEAR(at("-1").color, q * q * p, error);
  EXPECT_NEAR(at("-1").alpha, 1 - q * q * q, error);
  EXPECT_NEAR(at("3").color, q * q * p, error);
  EXPECT_NEAR(at("3").alpha, 1 - q * q * q, error);
  EXPECT_NEAR(at("2").color, q * q, error);  // the third is all there
  EXPECT_NEAR(at("2").alpha, 1, 1e-6);
  EXPECT_NEAR(at("1").color, 0, 1e-6);
  EXPECT_NEAR(at("0").color, 0, 1e-6);
}

// A white wall in the sun, of radiance 4 / pi: direct light; what glows is no light.
TEST(PathControls, ClampsDirectLight) {
  const std::string sun = "Light \"PxrDistantLight\" \"sun\" \"float intensity\" [4] \"float angleExtent\" [0]\n";
  const std::string wall = "Bxdf \"PxrDiffuse\" \"wall\" \"color diffuseColor\" [1 1 1]\n" + square(5);
  const std::string glow = "Bxdf \"PxrConstant\" \"glow\" \"color emitColor\" [3 3 3]\n" + square(5);
  const double plain = meanOf(view(sun + wall), "PxrUnified", {}).color;
  EXPECT_GT(plain, 0.9);
  EXPECT_NEAR(meanOf(view(sun + wall), "PxrUnified", {{"directClamp", "0.3"}}).color, 0.3, 1e-4);
  EXPECT_NEAR(meanOf(view(sun + wall), "PxrUnified", {{"indirectClamp", "0.3"}}).color, plain, 1e-6);
  EXPECT_NEAR(meanOf(view(glow), "PxrUnified", {{"directClamp", "0.3"}}).color, 3, 1e-5);
  // by each technique of light paths
  for (const char* choice : {"1", "2", "3"}) {
    SCOPED_TRACE(choice);
    const auto clampedTo = [&](const char* name, const char* most) {
      return meanOf(view(sun + wall), "PxrUnified", {{"traceLightPaths", choice}, {name, most}}).color;
    };
    EXPECT_LT(clampedTo("directClamp", "1e-4"), 0.05 * plain);
    EXPECT_GT(clampedTo("indirectClamp", "1e-4"), 0.8 * plain);
  }
}
// What has no effect is said of each integrator that only knows it by name.
TEST(PathControls, SaysWhatHasNoEffect) {
  for (const auto& [integrator, parameter] :
       {std::pair{"PxrVCM", "photonGuiding"}, std::pair{"PxrPathTracer", "jointSampling"}}) {
    const std::string text = std::string("Integrator \"") + integrator + "\" \"i\" \"" +
                             (std::string(parameter) == "jointSampling" ? "int " : "float ") + parameter +
                             "\" [1]\n" + view(square(5), 1);
    std::string said;
    meanOf(text, "", {}, &said);
    EXPECT_NE(said.find("PARAM-NO-EFFECT"), std::string::npos) << said;
    EXPECT_NE(said.find(parameter), std::string::npos) << said;
  }
}

TEST(PathControls, ScalesWhatGlows) {
  const std::string glow = "Bxdf \"PxrConstant\" \"glow\" \"color emitColor\" [3 3 3]\n" + square(5);
  for (const char* choice : {"0", "1", "3"})
    EXPECT_NEAR(meanOf(view(glow), "PxrUnified", {{"emissionMultiplier", "0.25"}, {"traceLightPaths", choice}}).color,
                0.75, 1e-5);
  // and not what shines
  const std::string lit =
      "Light \"PxrDistantLight\" \"sun\" \"float angleExtent\" [0]\n"
      "Bxdf \"PxrDiffuse\" \"wall\" \"color diffuseColor\" [1 1 1]\n" +
      square(5);
  EXPECT_EQ(meanOf(view(lit), "PxrUnified", {{"emissionMultiplier", "0.25"}}).color,
            meanOf(view(lit), "PxrUnified", {}).color);
}

// A floor under the sky, and a lid that keeps the sky from it at distance 3, behind the camera.
const std::string kFloor = R"(
  Light "PxrDomeLight" "sky" "float intensity" [1]
  Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.5 0.5 0.5]
)" + square(5, 2);
const std::string kLid =
    "AttributeBegin\nBxdf \"PxrConstant\" \"lid\" \"color emitColor\" [0 0 0]\n"
    "Attribute \"visibility\" \"int camera\" [0]\n" +
    square(2, 40) + "AttributeEnd\n";

TEST(PathControls, SurfacesAreMetSoFar) {
  const double open = meanOf(view(kFloor), "PxrUnified", {}).color;
  EXPECT_NEAR(open, 0.5, 0.01);
  EXPECT_NEAR(meanOf(view(kFloor + kLid), "PxrUnified", {}).color, 0, 0.01);
  EXPECT_NEAR(meanOf(view(kFloor + kLid), "PxrUnified", {{"maxRayDistance", "2.9"}}).color, open, 0.01);
  EXPECT_NEAR(meanOf(view(kFloor + kLid), "PxrUnified", {{"maxRayDistance", "0"}}).color, 0, 0.01);
  // what is met lies within 6, so near to the upright: 1 - sin^2 = (3 / 6)^2 of the sky's light
  EXPECT_NEAR(meanOf(view(kFloor + kLid), "PxrUnified", {{"maxRayDistance", "6"}}).color, open * 0.25, 0.01);
}

TEST(PathControls, CatchesLightAtTheEnd) {
  const Sets direct{{"maxIndirectBounces", "0"}};
  const auto at = [&](const std::string& things, const char* share) {
    Sets sets = direct;
    sets.emplace_back("catchAllLights", share);
    return meanOf(view(things), "PxrUnified", sets).color;
  };
  const double open = at(kFloor, "0");
  EXPECT_NEAR(at(kFloor, "0.6"), open, 0.01);
  EXPECT_NEAR(at(kFloor + kLid, "0"), 0, 0.01);
  EXPECT_NEAR(at(kFloor + kLid, "0.6"), 0.6 * open, 0.01);
  EXPECT_NEAR(at(kFloor + kLid, "1"), open, 0.01);
  // a bounce before the end shadows are what they are
  Sets later{{"maxIndirectBounces", "1"}, {"catchAllLights", "1"}};
  EXPECT_NEAR(meanOf(view(kFloor + kLid), "PxrUnified", later).color, 0, 0.01);
}

// The part of a caustic's light that walks bring is what a clamp takes away.
TEST(PathControls, ClampsCaustics) {
  std::string lamp = kSphere;
  const std::string name = "\"bulb\"";
  lamp.insert(lamp.find(name) + name.size(), " \"int cheapCaustics\" [1]");
  const std::string glass = "Bxdf \"PxrGlass\" \"glass\" \"int mwWalkable\" [1]";
  const std::string text = room(lamp, glass);
  const auto floor = [&](const char* clamp) {
    Workshop stage;
    render::Settings s;
    s.threads = 1;
    s.integrator = "PxrUnified";
    s.sets = {
        {"integrator.manifoldWalk", "1"}, {"integrator.indirectClamp", "1e30"}, {"integrator.causticClamp", clamp}};
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    const image::Image picture = pictureOf(*r);
    double sum = 0;
    for (const float x : picture.pixels) sum += x;
    return sum;
  };
  const double off = floor("0"), some = floor("0.01"), all = floor("1e30");
  EXPECT_LT(off, some);
  EXPECT_LT(some, all);
}

}  // namespace
}  // namespace kinora::probes
