// Proves: media of grids that rays see wider than a voxel are looked up in coarser levels, and pictures of those have the
// means of pictures of the finest level, by each integrator, scattered once and often, and in shadows; the same bits for
// any number of threads, width and group; a dictionary that is not understood is told. Misses: the choice of the level
// itself, which is a matter of time alone as long as the means agree.
#include <algorithm>
#include <cmath>
#include <fstream>

#include "fixture.h"
#include "volume/grid_stream.h"
#include "volume/read_process.h"

namespace kinora::tests {
namespace {

using volume::GridRecord;
using volume::GridShape;

constexpr int kSide = 64;  // voxels, of a box of side 1

class MediumLevels : public Shaders {
 protected:
  void SetUp() override {
    Shaders::SetUp();
    // what another process would write of the file: voxels that all differ around a density that varies slowly
    std::ofstream out(folder_ + "/stream", std::ios::binary);
    const auto head = [&](GridRecord kind, uint32_t count) {
      const uint32_t words[2] = {uint32_t(kind), count};
      out.write(reinterpret_cast<const char*>(words), sizeof words);
    };
    GridShape shape;
    for (int k = 0; k < 3; ++k) {
      shape.size[k] = kSide;
      shape.worldToIndex[5 * k] = kSide;
      shape.worldToIndex[12 + k] = -0.5;
    }
    shape.worldToIndex[15] = 1;
    head(GridRecord::Shape, sizeof shape);
    out.write(reinterpret_cast<const char*>(&shape), sizeof shape);
    uint32_t random = 1;
    const int bricks = kSide / GridShape::kSide;
    for (int b = 0; b < bricks * bricks * bricks; ++b) {
      head(GridRecord::Brick, uint32_t(b));
      for (int i = 0; i < GridShape::kVoxels; ++i) {
        const int x = b % bricks * 8 + i % 8, y = b / bricks % bricks * 8 + i / 8 % 8;
        const int z = b / (bricks * bricks) * 8 + i / 64;
        // nothing at the rim: what coarse voxels there spread beyond the bound is cut off with it
        const bool isRim = std::min({x, y, z}) < 8 || std::max({x, y, z}) >= kSide - 8;
        random = random * 1664525u + 1013904223u;
        const float slow = 1 + 0.6f * std::sin(0.15f * float(x)) * std::cos(0.11f * float(y));
        const float v = random >> 31 && !isRim ? 2 * slow : 0;
        out.write(reinterpret_cast<const char*>(&v), sizeof v);
      }
    }
    head(GridRecord::End, uint32_t(bricks * bricks * bricks));
    std::ofstream(folder_ + "/script") << "exec cat '" << folder_ << "/stream'\n";
  }
  // The cloud over a floor, from the side, or from above in the floor's light; pixels are as wide as 8 voxels.
  RenderRequest request(const std::string& integrator, const std::string& medium, const std::string& more,
                        int samples = 128) const {
    RenderRequest r;
    r.rib = "Format 12 12 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" +
            std::to_string(samples) + "]\nScreenWindow -0.75 0.75 -0.75 0.75\nProjection \"orthographic\"\n" +
            integrator +
            "Rotate 20 1 0 0\nTranslate -0.5 -0.3 2\nWorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" "
            "[0.5]\n"
            "Attribute \"visibility\" \"int camera\" [1]\n"
            "Light \"PxrDistantLight\" \"sun\" \"float intensity\" [2]\nBxdf \"PxrDiffuse\" \"floor\"\n"
            "Polygon \"P\" [-3 -3 1.2  3 -3 1.2  3 3 1.2  -3 3 1.2]\n"
            "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [.8 .7 .6] \"float densityFloat\" [1.2] \"string "
            "densityFloatPrimVar\" [\"density\"] " +
            medium +
            "\nVolume \"blobbydso:impl_openvdb\" [0 1 0 1 0 1] [0 0 0] \"constant string[4] "
            "blobbydso:stringargs\" [\"volumes.vdb\" \"density:fogvolume\" \"\" \"" +
            more + "\"] \"varying float density\" []\nWorldEnd\n";
    r.settings.texturePath = {KINORA_SOURCE_DIR "/tests/shaders"};
    r.settings.volumeReader = {{"/bin/sh", folder_ + "/script"}, 60};
    return r;
  }
};

const std::string kFinest = R"({\"filterWidth\": 0})", kByFootprint = R"({\"filterWidth\": 1})";
const std::string kPaths =
    "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [6] \"float clampLuminance\" [1e30]\n";

const std::string kEmits = "\"color emitColor\" [.3 .2 .1] \"int multiScatter\" [1]",
                  kMoves = "\"vector velocity\" [.08 .05 0]";

TEST_F(MediumLevels, HaveTheMeansOfTheFinest) {
  const std::string vcm = "Integrator \"PxrVCM\" \"i\" \"int maxPathLength\" [6] \"float clampLuminance\" [1e30]\n",
                    unified = "Integrator \"PxrUnified\" \"i\" \"int maxIndirectBounces\" [6]\n";
  for (const auto& [name, integrator] :
       std::vector<std::pair<std::string, std::string>>{{"paths", kPaths}, {"vcm", vcm}, {"unified", unified}})
    for (const std::string& medium :
         std::vector<std::string>{"\"color diffuseColor\" [0 0 0]", "", "\"int multiScatter\" [1]", kEmits, kMoves}) {
      if (name != "paths" && (medium == kEmits || medium == kMoves)) continue;
      SCOPED_TRACE(name + " " + medium);
      const auto mean = [&](const std::string& more) { return overSeeds(request(integrator, medium, more, 64), 6); };
      const testing::Moments fine = mean(kFinest), coarse = mean(kByFootprint);
      const double error = std::hypot(fine.standardError(), coarse.standardError());
      // what may get through less by means, see kThickest in src/render/space_media.cpp; voxels are seen one behind the
      // other, so that it comes to much less
      const double bias = 0.0078 * fine.mean();
      EXPECT_LE(std::fabs(fine.mean() - coarse.mean()), 4 * error + bias) << fine.mean() << " " << coarse.mean();
      EXPECT_LE(error, 0.01 * fine.mean()) << "too few samples to judge";
    }
}

TEST_F(MediumLevels, AreSeenByFootprintAndUnlessSaidOtherwise) {
  const auto hash = [&](const std::string& more, const std::string& medium = "") {
    SceneRender render(request(kPaths, medium, more, 4));
    for (const std::string& m : render.messages()) ADD_FAILURE() << m;
    return render.ok() ? hashOf(render.film()) : 0;
  };
  const uint64_t fine = hash(kFinest), coarse = hash(kByFootprint);
  EXPECT_NE(fine, coarse);
  EXPECT_EQ(hash(""), coarse);
  EXPECT_EQ(hash("{}"), coarse);
  EXPECT_EQ(hash(R"({\"filterWidth\": 0.0, \"densityMult\": 1.0, \"densityRolloff\": 0.0})"), fine)
      << "as exporters write it";
  EXPECT_EQ(hash(R"({\"filterWidth\": 0.001})"), fine) << "footprints narrower than a voxel";
  for (const std::string& medium : {kEmits, kMoves})
    EXPECT_NE(hash(kFinest, medium), hash(kByFootprint, medium)) << medium;
}

TEST_F(MediumLevels, GiveTheSameBitsHoweverTheyAreRendered) {
  const auto state = [&](int threads, uint32_t width, uint32_t groupSize) {
    RenderRequest r = request(kPaths, kEmits, kByFootprint, 4);
    r.settings.threads = threads;
    r.settings.width = width;
    r.settings.groupSize = groupSize;
    SceneRender render(r);
    for (const std::string& m : render.messages()) ADD_FAILURE() << m;
    return render.ok() ? stateOf(render.film()) : std::vector<int64_t>();
  };
  const std::vector<int64_t> one = state(1, 8, 0);
  ASSERT_FALSE(one.empty());
  EXPECT_EQ(state(2, 8, 64), one);
  EXPECT_EQ(state(1, 4, 0), one);
  EXPECT_EQ(state(2, 1, 0), one);
}

TEST_F(MediumLevels, DictionariesThatAreNotUnderstoodAreTold) {
  for (const char* more : {R"({\"filterWidth\": -1})", R"({\"filterWidth\": \"wide\"})", "nonsense", "[1]",
                           R"({\"densityMult\": 2})", R"({\"filterWidth\": 1, \"densityRolloff\": 0.5})"}) {
    SceneRender render(request(kPaths, "", more, 1));
    EXPECT_TRUE(render.ok());
    EXPECT_EQ(told(render, "MEDIUM-FIELD"), 1u) << more;
  }
}

}  // namespace
}  // namespace kinora::tests
