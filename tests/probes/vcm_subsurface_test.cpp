// PxrVCM below surfaces against PxrPathTracer: equal means of a ball of wax under a coat, by walks,
// by a profile, by single scattering and straight through, under lights of every kind and in fog; with all sets
// of techniques. Footprints decide nothing where paths of both ends come. Equal bits for threads, widths, groups and
// splits. It misses boundaries with an index and skins in layers, whose ways below are the same ones.
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

std::string wax(const std::string& more, int gain = 1) {
  return R"(Bxdf "PxrSurface" "wax" "float diffuseGain" [0] "float subsurfaceGain" [)" + std::to_string(gain) + R"(]
    "color subsurfaceColor" [0.8 0.6 0.4] "color subsurfaceDmfpColor" [1 0.6 0.4] "float unitLength" [1]
    "float subsurfaceDiffuseSwitch" [0] )" +
         more;
}
const std::string kWalks = R"("int subsurfaceType" [4] "float subsurfaceDmfp" [0.2] )";
const std::string kProfile = R"("int subsurfaceType" [2] "float subsurfaceDmfp" [0.1] )";
const std::string kCoat = R"("int specularFresnelMode" [1] "color specularEdgeColor" [1 1 1] "color specularIor"
    [1.5 1.5 1.5] "int specularModelType" [1] "float specularRoughness" [0.3] )";
const std::string kOnce = R"("float singlescatterGain" [1] "color singlescatterColor" [0.9 0.7 0.5]
    "color singlescatterMfpColor" [1 1 1] "float singlescatterMfp" [0.3] "float singlescatterDirectionality" [0.3] )";

TEST(VcmSubsurface, WalksUnderACoat) {
  expectSamePicture(room(std::string(kRect) + kSphere, wax(kWalks + kCoat)), 0.03);
}
TEST(VcmSubsurface, WalksUnderAPointAndASun) {
  expectSamePicture(room(std::string(kPoint) + kSun, wax(kWalks)), 0.03);
}
TEST(VcmSubsurface, AProfileUnderADome) { expectSamePicture(room(kDome, wax(kProfile + kCoat)), 0.03); }
TEST(VcmSubsurface, SingleScatteringAndStraightThrough) {
  expectSamePicture(room(std::string(kRect) + kSphere, wax(kOnce + R"("float singlescatterDirectGain" [0.5] )", 0)),
                    0.04, 48);
}
TEST(VcmSubsurface, SingleScatteringOfWalks) {
  expectSamePicture(room(std::string(kPoint) + kDome, wax(kWalks + kOnce)), 0.04, 48);
}
TEST(VcmSubsurface, WalksInFog) {
  Workshop stage;
  expectConnectedAlike(stage, room(kRect, wax(kWalks + kCoat), "", kFog), 0.07, 32);
}

// Under a switch at which the path tracer reflects at once: what comes out must not hang on the width of either path.
TEST(VcmSubsurface, FootprintsDecideNothing) {
  const auto meanOf = [](const Method& method, int switchAt) {
    std::string text = room(std::string(kRect) + kPoint, wax(kWalks));
    const std::string never = "\"float subsurfaceDiffuseSwitch\" [0]";
    text.replace(text.find(never), never.size(),
                 "\"float subsurfaceDiffuseSwitch\" [" + std::to_string(switchAt) + "]");
    Workshop stage;
    return renderAll(stage, text, method, 1000, 2).at("Ci").mean();
  };
  EXPECT_EQ(meanOf(vcm(true, true), 0), meanOf(vcm(true, true), 1000));
  EXPECT_NE(meanOf(pathTracer(), 0), meanOf(pathTracer(), 1000)) << "or this test says nothing";
}

TEST(VcmSubsurface, SameBits) {
  expectSameBits({}, room(std::string(kRect) + kSun + kDome, wax(kWalks + kCoat + kOnce), kLens, kFog), "PxrVCM");
}

}  // namespace
}  // namespace kinora::probes
