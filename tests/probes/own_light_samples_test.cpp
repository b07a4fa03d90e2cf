// Lights that ask for samples of their own (fixedSampleCount): the mean stays, the light's noise goes down, and the bits
// are the same however the frame is rendered. Beside other lights and alone, with glossy surfaces, where directions of
// the material find them too, media, guiding, and samples by lobe.
#include <cmath>
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

std::string asking(std::string lamp, int samples) {
  const size_t at = lamp.find("\"float intensity\"");
  lamp.insert(at, "\"int fixedSampleCount\" [" + std::to_string(samples) + "] ");
  return lamp;
}
const char* const kShiny = R"(Bxdf "PxrSurface" "metal" "float diffuseGain" [0.2] "int specularFresnelMode" [0]
    "color specularFaceColor" [0.7 0.7 0.7] "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.15])";
const char* const kWax = R"(Bxdf "PxrSurface" "wax" "float diffuseGain" [0.3] "float subsurfaceGain" [0.7]
    "color subsurfaceColor" [0.8 0.6 0.5] "float subsurfaceDmfp" [0.2] "color subsurfaceDmfpColor" [1 0.5 0.3])";

TEST(OwnLightSamples, LeaveTheMean) {
  Workshop stage;
  struct {
    const char* what;
    std::string asked, plain;
    const char *ball, *more;
    Sets sets;
  } const kRooms[] = {
      {"rectangle alone", asking(kRect, 3), kRect, kShiny, "", {}},
      {"rectangle and sphere", asking(kRect, 3) + kSphere, std::string(kRect) + kSphere, kShiny, "", {}},
      {"both",
       asking(kRect, 2) + asking(kSphere, 5),
       std::string(kRect) + kSphere,
       kShiny,
       "",
       {{"integrator.numLightSamples", "2"}}},
      {"dome beside a sun", asking(kDome, 4) + kSun, std::string(kDome) + kSun, kShiny, "", {}},
      {"point", asking(kPoint, 4) + kMesh, std::string(kPoint) + kMesh, kGrey, "", {}},
      {"behind glass", asking(kSphere, 3) + kDome, std::string(kSphere) + kDome, kRoughGlass, "", {}},
      {"fog", asking(kMesh, 3) + kPoint, std::string(kMesh) + kPoint, kShiny, kFog, {}},
      {"wax", asking(kRect, 3) + kDome, std::string(kRect) + kDome, kWax, "", {}},
      {"directions",
       asking(kRect, 3) + kDome,
       std::string(kRect) + kDome,
       kShiny,
       "",
       {{"integrator.numIndirectSamples", "3"}}},
      {"by lobe",
       asking(kRect, 3) + kDome,
       std::string(kRect) + kDome,
       kShiny,
       "",
       {{"integrator.sampleMode", "manual"}, {"integrator.numSpecularSamples", "3"}}},
      {"learned",
       asking(kRect, 3) + kDome,
       std::string(kRect) + kDome,
       kShiny,
       "",
       {{"integrator.learnLights", "1"}, {"integrator.risPathGuiding", "1"}, {"integrator.guidingSamples", "4"}}}};
  for (const auto& r : kRooms) {
    Method m = pathTracer();
    m.sets.insert(m.sets.end(), r.sets.begin(), r.sets.end());
    expectEqual(renderAll(stage, room(r.asked, r.ball, "", r.more), m, 300, 12),
                renderAll(stage, room(r.plain, r.ball, "", r.more), pathTracer(), 100, 16), r.what, 0.1);
  }
}

TEST(OwnLightSamples, LowerItsNoise) {
  Workshop stage;
  const auto noise = [&](const std::string& lamps) {
    return renderAll(stage, room(lamps, kGrey), pathTracer(0), 500, 24).at("Ci").meanVariance();
  };
  EXPECT_LT(noise(asking(kDome, 8) + kPoint), 0.4 * noise(std::string(kDome) + kPoint));
}

TEST(OwnLightSamples, SameBits) {
  expectSameBits({}, room(asking(kRect, 2) + kSun + asking(kDome, 3), kGlass, kLens, kFog), "PxrPathTracer");
}

// PxrVCM takes none.
TEST(OwnLightSamples, OtherIntegratorsAreAsTheyWere) {
  const auto film = [](const std::string& lamps) {
    Workshop stage;
    render::Settings s;
    s.threads = 2;
    s.integrator = "PxrVCM";
    const auto r = stage.load(sceneOf(room(lamps, kGlass), stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    return stateOf(r->film());
  };
  EXPECT_TRUE(film(asking(kRect, 3) + kDome) == film(std::string(kRect) + kDome));
}

}  // namespace
}  // namespace kinora::probes
