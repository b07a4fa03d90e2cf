// Lookups of one grid by the renderer's kernels and by OpenVDB's own sampler, a thread each, at the same points.
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "media.h"
#include "simd/dispatch.h"
#include "volume/medium_field.h"

namespace kinora::bench {

namespace {

using volume::GridShape;
using volume::VoxelGrid;

float densityAt(int x, int y, int z, int n) {
  const float p[3] = {2 * float(x) / float(n) - 1, 2 * float(y) / float(n) - 1, 2 * float(z) / float(n) - 1};
  const float r2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
  return r2 < 1 ? 0.6f + 0.4f * std::sin(9 * p[0] + 2 * p[1]) * std::sin(7 * p[1] + p[2]) : 0.f;
}

// The same ball of a side of n voxels in both forms, over -1 to 1.
struct BothGrids {
  std::unique_ptr<VoxelGrid> own;
  openvdb::FloatGrid::Ptr theirs = openvdb::FloatGrid::create();
  explicit BothGrids(int n) {
    const double voxel = 2.0 / n;
    theirs->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    theirs->transform().postTranslate(openvdb::Vec3d(-1, -1, -1));
    GridShape shape;
    for (int k = 0; k < 3; ++k) {
      shape.size[k] = n;
      shape.worldToIndex[5 * k] = 1 / voxel;
      shape.worldToIndex[12 + k] = 1 / voxel;
    }
    shape.worldToIndex[15] = 1;
    own = std::make_unique<VoxelGrid>(shape);
    auto accessor = theirs->getAccessor();
    uint64_t number = 0;
    for (int z = 0; z < shape.bricks(2); ++z)
      for (int y = 0; y < shape.bricks(1); ++y)
        for (int x = 0; x < shape.bricks(0); ++x, ++number) {
          float brick[GridShape::kVoxels];
          bool isAny = false;
          for (int i = 0; i < GridShape::kVoxels; ++i) {
            const int at[3] = {8 * x + i % 8, 8 * y + i / 8 % 8, 8 * z + i / 64};
            brick[i] = densityAt(at[0], at[1], at[2], n);
            if (brick[i] == 0) continue;
            isAny = true;
            accessor.setValue(openvdb::Coord(at[0], at[1], at[2]), brick[i]);
          }
          if (isAny) std::copy(brick, brick + GridShape::kVoxels, own->addBrick(number));
        }
  }
};

// Points in groups as tracking asks for them: each group's rays start near each other and have gone anywhere along
// their ways; or anywhere at all.
std::vector<float> points(uint32_t count, bool isAnywhere, std::mt19937& r) {
  const auto uniform = [&](float a, float b) { return a + (b - a) * float(r() >> 8) * 0x1p-24f; };
  std::vector<float> p(3 * size_t(count));
  constexpr uint32_t kGroup = 256;
  float from[3] = {}, to[3] = {};
  for (uint32_t i = 0; i < count; ++i) {
    if (i % kGroup == 0)
      for (int k = 0; k < 3; ++k) from[k] = uniform(-0.9f, 0.9f), to[k] = uniform(-0.9f, 0.9f);
    const float t = uniform(0, 1);
    for (size_t k = 0; k < 3; ++k)
      p[k * count + i] =
          isAnywhere ? uniform(-0.98f, 0.98f) : from[k] + (to[k] - from[k]) * t + uniform(-0.05f, 0.05f);
  }
  return p;
}

}  // namespace

void measureVoxelLookups(const Options& options, Figures& figures) {
  const uint32_t count = options.quick ? 1024 : 1u << 20, width = bestWidth();
  const BothGrids grids(options.quick ? 24 : 256);
  const volume::MediumField field(grids.own.get());
  std::mt19937 r(3);
  for (const bool isAnywhere : {false, true}) {
    const std::vector<float> p = points(count, isAnywhere, r);
    std::vector<float> own(count), theirs(count);
    std::vector<double> ns[2], ratio;
    for (int repeat = 0; repeat < options.repeat; ++repeat) {
      double seconds[2];
      double start = threadSeconds();
      constexpr uint32_t kGroup = 256;
      for (uint32_t i = 0; i < count; i += kGroup) {
        const float* const at[3] = {p.data() + i, p.data() + count + i, p.data() + 2 * size_t(count) + i};
        float* const out[3] = {own.data() + i, nullptr, nullptr};
        field.at(width, kGroup, at, out);
      }
      seconds[0] = threadSeconds() - start;
      start = threadSeconds();
      // an accessor remembers where it was: one for the thread
      const openvdb::FloatGrid::ConstAccessor accessor = grids.theirs->getConstAccessor();
      const openvdb::tools::GridSampler<openvdb::FloatGrid::ConstAccessor, openvdb::tools::BoxSampler> sampler(
          accessor, grids.theirs->transform());
      for (uint32_t i = 0; i < count; ++i)
        theirs[i] = sampler.wsSample(openvdb::Vec3d(p[i], p[count + i], p[2 * size_t(count) + i]));
      seconds[1] = threadSeconds() - start;
      for (int k = 0; k < 2; ++k) ns[k].push_back(seconds[k] / count * 1e9);
      ratio.push_back(seconds[1] / seconds[0]);
    }
    if (options.spoil) own[0] += 1;
    double most = 0;
    for (uint32_t i = 0; i < count; ++i) most = std::max(most, std::fabs(double(own[i]) - double(theirs[i])));
    if (most > 1e-3) figures.fail("BENCH-VALUES", "lookups differ from OpenVDB's by " + std::to_string(most));
    const std::string where = isAnywhere ? "_anywhere" : "_along_rays";
    figures.add("lookups_vs_openvdb" + where, ratio,
                std::string("trilinear lookups of a grid of 256^3, OpenVDB's sampler over the renderer's, ") +
                    (isAnywhere ? "points anywhere" : "points as rays of a group ask"));
    figures.add("ns_lookup" + where, ns[0], "nanoseconds of the renderer's");
    figures.add("ns_lookup_openvdb" + where, ns[1], "and of OpenVDB's");
  }
}

}  // namespace kinora::bench
