// The example of an integrator that finds its own way through media, by Services::mediumIntervals and mediaAt, against
// PxrPathTracer, which ends rays in media by tracking: equal means in rooms with fog of one and of several channels,
// uneven, overlapping, scattering once, glowing, with the camera inside; equal bits for threads, widths, groups and
// splits. And what the intervals are: their ends and media in closed form. It misses media that glass surrounds.
#define KINORA_STOCK_PLUGIN
#define KINORA_KERNEL_FILE "tests/probes/haze_test.cpp"
#include <kinora/integrator_author.h>

#if KINORA_PLAIN
#include <mutex>
#include <string>
#include <vector>
namespace kinora::stretches {
// What the probe below was told of the first sample's ray.
struct Told {
  std::mutex mutex;
  std::vector<float> from, to;
  std::vector<std::vector<uint32_t>> media;
  uint32_t rays = 0, rises = 1, inOrder = 1;
};
inline Told told;
struct Data {
  explicit Data(const CreateInfo&) {}
};
}  // namespace kinora::stretches
#endif

KINORA_KERNELS_BEGIN
struct StretchProbe {
  using Data = stretches::Data;
  template <int W>
  static void integrate(const Data&, uint32_t, Group& g, const Services& sv) {
    uint32_t* all = static_cast<uint32_t*>(sv.alloc(&g, (g.padded + kPad) * sizeof(uint32_t)));
    float* through[3];
    for (float*& x : through) x = static_cast<float*>(sv.alloc(&g, (g.padded + kPad) * sizeof(float)));
    // every other ray, from behind: numbers are those of the call
    const uint32_t n = (g.count + 1) / 2;
    for (uint32_t i = 0; i < n; ++i) all[i] = 2 * (n - 1 - i);
    g.paths.passesMedia = 1;
    sv.trace(&g, &g.paths, RayKind::Camera, 0, n, all, through);
    MediumIntervals in;
    sv.mediumIntervals(&g, &g.paths, n, all, &in);
    stretches::Told& told = stretches::told;
    const std::lock_guard lock(told.mutex);
    told.rays += n;
    for (uint32_t i = 0; i < n; ++i) {
      told.inOrder &= in.first[i] <= in.first[i + 1];
      if (i + 1 == n && told.from.empty())
        for (uint32_t k = in.first[i]; k < in.first[i + 1]; ++k) {
          told.from.push_back(in.from[k]);
          told.to.push_back(in.to[k]);
          told.media.emplace_back(in.medium + in.firstMedium[k], in.medium + in.firstMedium[k + 1]);
        }
      for (uint32_t k = in.first[i]; k < in.first[i + 1]; ++k) {
        told.inOrder &= in.from[k] < in.to[k] && (k == in.first[i] || in.to[k - 1] <= in.from[k]);
        for (uint32_t m = in.firstMedium[k] + 1; m < in.firstMedium[k + 1]; ++m)
          told.rises &= in.medium[m - 1] < in.medium[m];
      }
    }
    told.inOrder &= in.first[n] == in.count;
  }
};
KINORA_KERNELS_END
KINORA_INTEGRATOR(StretchProbe, .help = "Asks for intervals of media.", .setUp = setUp<stretches::Data>,
                  .scattersInMedia = scatterInMedia)

#if KINORA_PLAIN
#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora {
const Descriptor* kinoraStock_Haze();
const Descriptor* kinoraStock_StretchProbe();
namespace probes {
namespace {

std::string hazy(const std::string& material, const std::string& bound, const std::string& more = "[0 0 0]") {
  return "  AttributeBegin\n    Bxdf \"PxrVolume\" \"fog\" " + material + "\n    Volume \"box\" " + bound + " " +
         more + "\n  AttributeEnd\n";
}
const std::string kScattersOften = "\"int multiScatter\" [1] ";
const char* const kRoomful = "[-1.6 1.6 -0.1 2.1 -0.2 2.1]";

// `sharpness`: the relative standard error that a tile of Ci may have, on average, for the test to say something.
void expectHazeEqualsPathTracer(const std::string& text, double sharpness, uint32_t seeds = 24) {
  Workshop stage{kinoraStock_Haze()};
  const Method haze{"Haze", {{"integrator.maxIndirectBounces", "4"}}};
  const Pictures own = renderAll(stage, text, haze, 500, seeds),
                 reference = renderAll(stage, text, pathTracer(), 100, seeds);
  EXPECT_GT(reference.at("Ci").mean(), 0.01) << stage.said;
  expectEqual(own, reference, "Haze", sharpness);
}

TEST(Haze, EqualsPathTracerInEvenFog) {
  expectHazeEqualsPathTracer(
      room(kRect, kGrey, "",
           hazy(kScattersOften + "\"float densityFloat\" [0.5] \"float anisotropy\" [0.4]", kRoomful)),
      0.07);
}
TEST(Haze, EqualsPathTracerFromWithinFogOfSeveralChannels) {
  expectHazeEqualsPathTracer(
      room(kPoint, kGrey, "",
           hazy(kScattersOften + "\"color densityColor\" [0.1 0.4 0.9] \"color diffuseColor\" [0.9 0.8 0.6]",
                "[-3 3 -3 3 -6 4]")),
      0.11, 64);
}
TEST(Haze, EqualsPathTracerInUnevenSmoke) {
  expectHazeEqualsPathTracer(
      room(std::string(kSun) + kDome, kGrey, "",
           hazy(kScattersOften + "\"string densityFloatPrimVar\" [\"density\"] \"color diffuseColor\" [0.9 0.9 0.8]",
                "[-1.2 1.2 0.1 1.6 0.2 1.8]", "[3 2 2] \"varying float density\" [0 1 4 0.3 0 3 0.5 1 0 1 0 2]")),
      0.05);
}
// Two that overlap, one of which scatters once, and one apart of them.
TEST(Haze, EqualsPathTracerWhereMediaOverlap) {
  expectHazeEqualsPathTracer(
      room(kSphere, kGrey, "",
           hazy(kScattersOften + "\"color densityColor\" [0.3 0.5 0.6]", kRoomful) +
               hazy("\"float densityFloat\" [1.5] \"float anisotropy\" [-0.3]", "[-0.6 0.6 0.2 1.2 0.3 1.4]") +
               hazy(kScattersOften + "\"float densityFloat\" [2]", "[0.7 1.2 0.2 1.2 0.3 1.4]")),
      0.06);
}
TEST(Haze, EqualsPathTracerAroundFire) {
  expectHazeEqualsPathTracer(
      room(kRect, kGrey, "",
           hazy(kScattersOften + "\"float densityFloat\" [0.6] \"color emitColor\" [3 1.5 0.4]",
                "[-0.9 -0.3 0.1 0.9 0.6 1.2]")),
      0.05);
}
TEST(Haze, SameBits) {
  expectSameBits({kinoraStock_Haze()},
                 room(kRect, kGrey, "", hazy(kScattersOften + "\"color densityColor\" [0.3 0.5 0.6]", kRoomful)),
                 "Haze");
}

// Boxes across the view: from 1 to 4, from 2 to 3, from 6 to 9, where a wall stands at 8; and nothing without media.
TEST(MediumIntervals, AreWhatRaysPass) {
  const std::string head =
                        "Format 8 8 1\nHider \"raytrace\" \"int maxsamples\" [2]\nDisplay \"x.exr\" \"openexr\" "
                        "\"Ci\"\nProjection \"orthographic\"\nScreenWindow -1 1 -1 1\nWorldBegin\n",
                    wall = "Bxdf \"PxrDiffuse\" \"d\"\nPolygon \"P\" [-9 -9 8  9 -9 8  9 9 8  -9 9 8]\n";
  const auto ask = [&](const std::string& media) {
    stretches::told.from.clear();
    stretches::told.to.clear();
    stretches::told.media.clear();
    Workshop stage{kinoraStock_StretchProbe()};
    render::Settings s;
    s.threads = 1;
    s.integrator = "StretchProbe";
    const auto r = stage.load(sceneOf(head + media + wall + "WorldEnd\n", stage.messages), s);
    pictureOf(*r);
  };
  const std::string fog = "\"float densityFloat\" [0.5]";
  ask(hazy(fog, "[-3 3 -3 3 1 4]") + hazy(fog, "[-3 3 -3 3 2 3]") + hazy(fog, "[-3 3 -3 3 6 9]"));
  const stretches::Told& told = stretches::told;
  EXPECT_GT(told.rays, 0u);
  EXPECT_TRUE(told.inOrder);
  EXPECT_TRUE(told.rises);
  const float from[] = {1, 2, 3, 6}, to[] = {2, 3, 4, 8};
  const size_t media[] = {1, 2, 1, 1};
  ASSERT_EQ(told.from.size(), 4u);
  for (size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(told.from[k], from[k], 1e-4);
    EXPECT_NEAR(told.to[k], to[k], 1e-4);
    EXPECT_EQ(told.media[k].size(), media[k]);
  }
  EXPECT_EQ(told.media[0], told.media[2]);
  EXPECT_NE(told.media[0], told.media[3]);
  ask("");
  EXPECT_TRUE(told.from.empty());
}

}  // namespace
}  // namespace probes
}  // namespace kinora
#endif
