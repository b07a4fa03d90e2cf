#include "volume/voxel_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kinora::volume {

namespace {

constexpr uint32_t kSlab = 32;
constexpr int32_t kFarthest = 1 << 30;
constexpr uint64_t kMostBricks = uint64_t(1) << 24;

// A place along one axis, counted in voxels from the first, brought into the box; false where nothing is.
bool wrapped(double& x, double n, VoxelWrap wrap) {
  switch (wrap) {
    case VoxelWrap::Clamp:
      x = std::min(std::max(x, 0.0), n - 1);
      return true;
    case VoxelWrap::Periodic:
      x -= n * std::floor(x / n);
      return true;
    case VoxelWrap::Mirror:
      x -= 2 * n * std::floor(x / (2 * n));
      return true;
    case VoxelWrap::Black:
      break;
  }
  return x > -1 && x < n;
}
// A voxel near the box, by number; -1: none. Mirrors repeat the voxel at the edge, as those of pictures do.
int32_t wrappedVoxel(int32_t i, int32_t n, VoxelWrap wrap) {
  if (uint32_t(i) < uint32_t(n)) return i;
  switch (wrap) {
    case VoxelWrap::Clamp:
      return i < 0 ? 0 : n - 1;
    case VoxelWrap::Periodic:
      return i < 0 ? i + n : i % n;
    case VoxelWrap::Mirror:
      i = i < 0 ? i + 2 * n : i % (2 * n);
      return i < n ? i : 2 * n - 1 - i;
    case VoxelWrap::Black:
      break;
  }
  return -1;
}

}  // namespace

const char* GridShape::disbelief() const {
  if (channels != 1 && channels != 3) return "it has neither one nor three numbers for each voxel";
  for (int k = 0; k < 3; ++k)
    if (first[k] < -kFarthest || first[k] > kFarthest || size[k] < 1 || size[k] > kFarthest)
      return size[k] < 1 ? "it holds no voxels" : "its box is too far from the origin";
  for (int k = 0; k < 3; ++k)
    if (uint64_t(bricks(k)) > kMostBricks) return "its voxels lie too far apart";
  if (uint64_t(bricks(0)) * uint64_t(bricks(1)) > kMostBricks || brickCount() > kMostBricks)
    return "its voxels lie too far apart";
  for (int k = 0; k < 16; ++k)
    if (!std::isfinite(worldToIndex[k])) return "its transform holds numbers that are not finite";
  if (worldToIndex[3] != 0 || worldToIndex[7] != 0 || worldToIndex[11] != 0 || worldToIndex[15] != 1)
    return "its transform is not linear";
  return nullptr;
}

VoxelGrid::VoxelGrid(const GridShape& shape, std::shared_ptr<VoxelStore> store)
    : shape_(shape),
      stride_{uint64_t(shape.bricks(0)), uint64_t(shape.bricks(0)) * uint64_t(shape.bricks(1))},
      store_(store ? std::move(store) : std::make_shared<VoxelStore>(0)) {
  for (int k = 0; k < 3; ++k) offset_[k] = shape.first[k] - shape.firstBrick(k) * GridShape::kSide;
  memory_.add(shape.brickCount() * sizeof(float*));
  table_.resize(shape.brickCount());
}

float* VoxelGrid::addBrick(uint64_t number) {
  const size_t floats = size_t(GridShape::kVoxels) * size_t(shape_.channels);
  if (!slab_ || usedOfSlab_ == kSlab) {
    slab_ = store_->add(kSlab * floats);
    brickBytes_ += kSlab * floats * sizeof(float);
    usedOfSlab_ = 0;
  }
  float* const brick = slab_ + usedOfSlab_++ * floats;
  store_->use(brick);
  table_[number] = brick;
  return brick;
}

void VoxelGrid::addConstantBrick(uint64_t number, const float* value) {
  const size_t channels = size_t(shape_.channels);
  if (!lastConstant_ || std::memcmp(lastConstant_, value, channels * sizeof(float)) != 0) {
    float* const brick = addBrick(number);
    for (size_t k = 0; k < size_t(GridShape::kVoxels) * channels; ++k) brick[k] = value[k % channels];
    lastConstant_ = brick;
  }
  table_[number] = lastConstant_;
}

void VoxelGrid::toIndex(const float world[3], double index[3]) const {
  stepToIndex(world, index);
  for (int k = 0; k < 3; ++k) index[k] += shape_.worldToIndex[12 + k];
}
void VoxelGrid::stepToIndex(const float world[3], double index[3]) const {
  const double* m = shape_.worldToIndex;
  for (int k = 0; k < 3; ++k) index[k] = world[0] * m[k] + world[1] * m[4 + k] + world[2] * m[8 + k];
}

// Null: zeros. `at` counts from the box's first voxel and lies in it.
const float* VoxelGrid::voxel(const int32_t at[3]) const {
  uint32_t i[3];
  for (int k = 0; k < 3; ++k) i[k] = uint32_t(at[k] + offset_[k]);
  const float* const brick = table_[(i[0] >> 3) + (i[1] >> 3) * stride_[0] + (i[2] >> 3) * stride_[1]];
  if (brick) store_->use(brick);
  return brick ? brick + ((i[0] & 7) + (i[1] & 7) * 8 + (i[2] & 7) * 64) * uint32_t(shape_.channels) : nullptr;
}

// place: in voxels from the box's first.
void VoxelGrid::sample(const double place[3], const VoxelLookup& how, float* out) const {
  const int channels = shape_.channels;
  std::fill_n(out, channels, 0.f);
  int32_t at[3][2];
  float f[3];
  for (int k = 0; k < 3; ++k) {
    double x = place[k];
    const int32_t n = shape_.size[k];
    // what is not a number is nowhere, as what is too far to be one of a voxel
    if (!(std::fabs(x) < 1e15) || !wrapped(x, n, how.wrap[k])) return;
    const double low = std::floor(how.isClosest ? x + 0.5 : x);
    f[k] = float(x - low);
    for (int side = 0; side < 2; ++side) at[k][side] = wrappedVoxel(int32_t(low) + side, n, how.wrap[k]);
  }
  const auto read = [&](int x, int y, int z, float v[3]) {
    const int32_t i[3] = {at[0][x], at[1][y], at[2][z]};
    const float* from = i[0] < 0 || i[1] < 0 || i[2] < 0 ? nullptr : voxel(i);
    for (int c = 0; c < channels; ++c) v[c] = from ? from[c] : 0.f;
  };
  if (how.isClosest) return read(0, 0, 0, out);
  float v[2][2][2][3];
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x) read(x, y, z, v[z][y][x]);
  const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
  for (int c = 0; c < channels; ++c) {
    float along[2];
    for (int z = 0; z < 2; ++z)
      along[z] = mix(mix(v[z][0][0][c], v[z][0][1][c], f[0]), mix(v[z][1][0][c], v[z][1][1][c], f[0]), f[1]);
    out[c] = mix(along[0], along[1], f[2]);
  }
}

void VoxelGrid::lookUp(const double index[3], const VoxelLookup& how, float* out) const {
  double place[3], step[3];
  bool isWide = false;
  for (int k = 0; k < 3; ++k) {
    place[k] = index[k] - shape_.first[k];
    // a box of side s spreads as two places at s / 4 on either side do, but for the little that each place is wide
    // itself
    const bool isLong = how.size[k] > 1 && !how.isClosest;
    step[k] = isLong ? 0.25 * how.size[k] : 0;
    isWide |= isLong;
  }
  if (!isWide) return sample(place, how, out);
  float sum[3] = {}, one[3];
  int taps = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double at[3];
    bool isOwn = true;
    for (int k = 0; k < 3; ++k) {
      const bool isUpper = corner >> k & 1;
      isOwn &= step[k] > 0 || !isUpper;
      at[k] = place[k] + (isUpper ? step[k] : -step[k]);
    }
    if (!isOwn) continue;
    sample(at, how, one);
    for (int c = 0; c < shape_.channels; ++c) sum[c] += one[c];
    ++taps;
  }
  for (int c = 0; c < shape_.channels; ++c) out[c] = sum[c] / float(taps);
}

void VoxelGrid::extremes(const double low[3], const double high[3], const VoxelLookup& how, float* least,
                         float* most) const {
  const int channels = shape_.channels;
  int32_t from[3], to[3];  // voxels of the box, from its first
  bool isBlack = false;    // some of it lies outside, where there is nothing
  for (int k = 0; k < 3; ++k) {
    const double n = shape_.size[k], a = std::floor(low[k] - shape_.first[k]),
                 b = std::ceil(high[k] - shape_.first[k]);
    if (how.wrap[k] == VoxelWrap::Periodic || how.wrap[k] == VoxelWrap::Mirror || !(b - a < n + 2)) {
      from[k] = 0, to[k] = shape_.size[k] - 1;
      isBlack |= how.wrap[k] == VoxelWrap::Black;
      continue;
    }
    isBlack |= how.wrap[k] == VoxelWrap::Black && (a < 0 || b > n - 1);
    from[k] = int32_t(std::clamp(a, 0.0, n - 1));
    to[k] = int32_t(std::clamp(b, 0.0, n - 1));
    if (how.wrap[k] == VoxelWrap::Black && (b < 0 || a > n - 1)) {  // all of it
      std::fill_n(least, channels, 0.f);
      std::fill_n(most, channels, 0.f);
      return;
    }
  }
  std::fill_n(least, channels, isBlack ? 0.f : INFINITY);
  std::fill_n(most, channels, isBlack ? 0.f : -INFINITY);
  const auto see = [&](const float* v) {
    for (int c = 0; c < channels; ++c) {
      least[c] = std::min(least[c], v ? v[c] : 0.f);
      most[c] = std::max(most[c], v ? v[c] : 0.f);
    }
  };
  int32_t at[3];
  for (at[2] = from[2]; at[2] <= to[2]; ++at[2])
    for (at[1] = from[1]; at[1] <= to[1]; ++at[1])
      for (at[0] = from[0]; at[0] <= to[0];) {
        const float* const v = voxel(at);
        see(v);
        // the rest of the brick's row: nothing, or numbers side by side
        const int32_t end = std::min(to[0], at[0] + 7 - ((at[0] + offset_[0]) & 7));
        for (int32_t x = 1; v && x <= end - at[0]; ++x) see(v + x * channels);
        at[0] = end + 1;
      }
}

}  // namespace kinora::volume
