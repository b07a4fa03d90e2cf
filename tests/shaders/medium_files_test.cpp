// Proves: Volume requests that name a file are filled by its grids, by name, by component and through networks; what is
// not there is told and a mist stands for it. The fixture is that of shader_volumes_test.cpp: "density" = x + 10 y +
// 100 z over 8 x 6 x 4 voxels of side .5, the first at (1, 2, 3).
#include <cmath>

#include "fixture.h"
#include "volume/read_process.h"

namespace kinora::tests {
namespace {

class MediumFiles : public Shaders {
 protected:
  // A sky seen along z through the grid, by rays 1/8 of a voxel apart around (x, y) of its voxels.
  double through(double x, double y, const std::string& material, const std::string& arguments,
                 uint64_t* told = nullptr) {
    RenderRequest r;
    r.rib =
        "Format 16 16 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64]\n"
        "ScreenWindow -0.001 0.001 -0.001 0.001\nProjection \"orthographic\"\n"
        "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [0] \"float clampLuminance\" [1e30]\n"
        "Translate " +
        std::to_string(-1 - x / 2) + " " + std::to_string(-2 - y / 2) +
        " 0\nWorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n" + material +
        "Volume \"blobbydso:impl_openvdb.so\" [0 6 0 6 2 6] [0 0 0] \"constant string[2] blobbydso:stringargs\" " +
        arguments + "\nWorldEnd\n";
    r.settings.texturePath = {KINORA_SOURCE_DIR "/tests/shaders"};
    r.settings.volumeCacheBytes = cacheBytes_;
    r.settings.volumeReader = {{KINORA_PROGRAM, volume::kReadCommand}, 60};
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    if (!render.ok()) return 0;
    if (told)
      *told = render.messages().size();
    else
      for (const std::string& m : render.messages()) ADD_FAILURE() << m;
    const testing::Moments m = overPixels(render.channel("Ci"));
    volumes_ = render.renderer().statistics().volumes;
    EXPECT_LT(m.standardError(), 0.004);
    return m.mean();
  }
  uint64_t cacheBytes_ = 0;
  render::Statistics::Volumes volumes_;
};

// The trilinear grid along z at whole x, y: four voxels, 0 from one beyond them on.
double expected(double x, double y, double scale) {
  double sum = 0;
  for (int z = 0; z < 4; ++z) sum += x + 10 * y + 100 * z;
  return std::exp(-scale * sum * 0.5);
}

TEST_F(MediumFiles, FillVolumesByName) {
  const std::string grids = "[\"volumes.vdb\" \"density\"] \"varying float density\" []",
                    dark = "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [0 0 0] ",
                    thin = "\"color densityColor\" [0.002 0.002 0.002] ";
  const double want = expected(3, 2, 0.002);
  EXPECT_NEAR(through(3, 2, dark + thin + "\"string densityFloatPrimVar\" [\"density\"]\n", grids), want, 0.012);
  EXPECT_NEAR(through(3, 2,
                      "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"density\"] \"string type\" [\"float\"]\n" +
                          dark + thin + "\"reference float densityFloat\" [\"p:resultF\"]\n",
                      grids),
              want, 0.012);
  // a component: y of (x, y, z) = 2 over four voxels
  EXPECT_NEAR(through(3, 2, dark + "\"color densityColor\" [0.2 0.2 0.2] \"string densityFloatPrimVar\" [\"Cd.y\"]\n",
                      "[\"volumes.vdb\" \"Cd\"] \"varying float Cd.y\" []"),
              std::exp(-0.2 * 2 * 4 * 0.5), 0.012);
  // the name of the grid stands in the arguments alone
  EXPECT_NEAR(
      through(3, 2, dark + thin + "\"string densityFloatPrimVar\" [\"density\"]\n", "[\"volumes.vdb\" \"density\"]"),
      want, 0.012);
}

TEST_F(MediumFiles, BricksBeyondTheCacheLieInAFile) {
  const auto look = [&](uint64_t cacheBytes) {
    cacheBytes_ = cacheBytes;
    return through(
        3, 2,
        "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [0 0 0] \"color densityColor\" [0.002 0.002 0.002] "
        "\"string densityFloatPrimVar\" [\"density\"]\n",
        "[\"volumes.vdb\" \"density\"] \"varying float density\" []");
  };
  const double inMemory = look(0);
  EXPECT_GT(volumes_.memoryBytes, 0u);
  EXPECT_EQ(volumes_.fileBytes, 0u);
  const uint64_t bytes = volumes_.memoryBytes;
  EXPECT_EQ(look(1), inMemory);
  EXPECT_EQ(volumes_.memoryBytes, 0u);
  EXPECT_GE(volumes_.fileBytes, bytes);
}

TEST_F(MediumFiles, WhatIsNotThereIsMist) {
  uint64_t told = 0;
  EXPECT_NEAR(
      through(
          3, 2,
          "Bxdf \"PxrVolume\" \"m\" \"color diffuseColor\" [0 0 0] \"string densityFloatPrimVar\" [\"density\"]\n",
          "[\"lost.vdb\" \"density\"] \"varying float density\" []", &told),
      std::exp(-0.7), 0.012);
  EXPECT_EQ(told, 1u);
}

}  // namespace
}  // namespace kinora::tests
