// Light samples chosen among candidates (PxrPathTracer, numLightCandidates): the mean is that of one sample for kinds of
// lights, surfaces, links, filters, media and numbers of samples, unshadowed light too; bits do not depend on threads,
// widths, groups, parts or crops. What it brings: docs/sampling.md.
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

const std::string kScreen = "  Polygon \"vertex point P\" [-0.3 0 0.5  -0.3 0 2  -0.3 1.7 2  -0.3 1.7 0.5]\n";
const std::string kLamps = std::string(kRect) + kSphere + kSun;

Method candidates(const char* count = "4") {
  Method m = pathTracer(2);
  m.sets.emplace_back("integrator.numLightCandidates", count);
  return m;
}
void expectMeanOfOne(const std::string& text, double sharpness = 0.05, const Method& method = candidates()) {
  Workshop stage;
  expectEqual(renderAll(stage, text, method, 100), renderAll(stage, text, pathTracer(2), 500), "chosen", sharpness);
}
TEST(LightCandidates, KeepTheMeanUnderAreaLightsAndSun) { expectMeanOfOne(room(kLamps, kGrey, "", kScreen)); }
TEST(LightCandidates, KeepTheMeanUnderDomeMeshAndPoint) {
  expectMeanOfOne(room(std::string(kDome) + kMesh + kPoint, kGrey, "", kScreen));
}
TEST(LightCandidates, KeepTheMeanUnderOneLight) {
  for (const char* light : {kRect, kSun, kPoint, kDome}) expectMeanOfOne(room(light, kGrey, "", kScreen));
}
TEST(LightCandidates, KeepTheMeanBesideRoughGlass) {
  expectMeanOfOne(room(std::string(kRect) + kSphere + kDome, kRoughGlass, "", kScreen), 0.08);
}
TEST(LightCandidates, KeepTheMeanBehindTintedShadows) {
  Method m = candidates(), one = pathTracer(2);
  for (Method* x : {&m, &one}) x->sets.emplace_back("integrator.allowCaustics", "0");
  Workshop stage;
  const std::string text = room(std::string(kRect) + kSphere + kDome, kGlass, "", kScreen);
  expectEqual(renderAll(stage, text, m, 100), renderAll(stage, text, one, 500), "chosen", 0.05);
}
TEST(LightCandidates, KeepTheMeanInMotionThroughALens) {
  expectMeanOfOne(room(std::string(kRect) + kDome + kMesh, kGrey, kLens, kScreen));
}
TEST(LightCandidates, KeepTheMeanWithSeveralSamplesAndDirections) {
  Method m = candidates("7");
  m.sets.insert(m.sets.end(), {{"integrator.numLightSamples", "3"}, {"integrator.numIndirectSamples", "2"}});
  expectMeanOfOne(room(kLamps + kDome, kGrey, "", kScreen), 0.05, m);
}
TEST(LightCandidates, KeepTheMeanWithGuidedPaths) {
  Method m = candidates();
  m.sets.emplace_back("integrator.risPathGuiding", "1");
  expectMeanOfOne(room(kLamps + kDome, kGrey, "", kScreen), 0.05, m);
}
TEST(LightCandidates, KeepTheMeanWithLinksAndFilters) {
  expectMeanOfOne(roomWithLinks(kScreen, " \"float diffuse\" [0.5]"));
}
TEST(LightCandidates, KeepTheMeanInFog) { expectMeanOfOne(foggyRoom(kScreen), 0.1); }

TEST(LightCandidates, SameBits) {
  const char* const chosen = "Integrator \"PxrPathTracer\" \"i\" \"int numLightCandidates\" [4]\n";
  expectSameBits({}, room(kLamps + kDome, kGlass, std::string(kLens) + chosen, kScreen), "");
}

// Each technique of light without shadows counts once.
TEST(LightCandidates, KeepUnshadowedLight) {
  std::string text = room(kLamps + kDome, kGrey, "", kScreen);
  const std::string old = "\"string source\" [\"lpe:C.+<L.'key'>\"]";
  ASSERT_NE(text.find(old), std::string::npos);
  text.replace(text.find(old), old.size(), "\"string source\" [\"lpe:unoccluded;C[DS]+L\"]");
  expectMeanOfOne(text);
}

}  // namespace
}  // namespace kinora::probes
