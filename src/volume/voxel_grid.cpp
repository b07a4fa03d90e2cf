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

VoxelGrid::VoxelGrid(const GridShape& shape, std::shared_ptr<VoxelStore> store, uint32_t level)
    : shape_(shape), store_(store ? std::move(store) : std::make_shared<VoxelStore>(0)), level_(level) {
  setFrame();
  memory_.add(shape.brickCount() * sizeof(float*));
  table_.resize(shape.brickCount());
}

void VoxelGrid::setFrame() {
  const double* m = shape_.worldToIndex;
  const auto minor = [&](int row, int column) {
    const int r[2] = {(row + 1) % 3, (row + 2) % 3}, c[2] = {(column + 1) % 3, (column + 2) % 3};
    return m[4 * r[0] + c[0]] * m[4 * r[1] + c[1]] - m[4 * r[0] + c[1]] * m[4 * r[1] + c[0]];
  };
  const double determinant = m[0] * minor(0, 0) + m[1] * minor(0, 1) + m[2] * minor(0, 2);
  double fromMiddle[3];  // of index space
  for (int k = 0; k < 3; ++k) fromMiddle[k] = shape_.first[k] + 0.5 * (shape_.size[k] - 1) - m[12 + k];
  for (int row = 0; row < 3; ++row) {
    double x = 0;
    for (int k = 0; k < 3; ++k) x += fromMiddle[k] * minor(row, k) / determinant;
    // boxes that are flat have none, and need none
    frame_.middle[row] = std::fabs(x) < 1e15 ? float(x) : 0.f;
  }
  double first[3];
  toIndex(frame_.middle, first);
  for (int k = 0; k < 3; ++k) {
    frame_.first[k] = float(first[k] - shape_.first[k]);
    for (int row = 0; row < 3; ++row) frame_.toVoxels[k][row] = float(m[4 * row + k]);
    frame_.size[k] = shape_.size[k];
    frame_.offset[k] = shape_.first[k] - shape_.firstBrick(k) * GridShape::kSide;
  }
  frame_.stride[0] = shape_.bricks(0);
  frame_.stride[1] = shape_.bricks(0) * shape_.bricks(1);
}

float* VoxelGrid::addBrick(uint64_t number) {
  const size_t floats = size_t(GridShape::kVoxels) * size_t(shape_.channels);
  if (!slab_ || usedOfSlab_ == kSlab) {
    slab_ = store_->add(kSlab * floats, level_);
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

namespace {

// Of the next level: two voxels along each axis are one, beginning at even numbers.
GridShape coarserShape(const GridShape& fine) {
  GridShape shape = fine;
  for (int k = 0; k < 3; ++k) {
    shape.first[k] = fine.first[k] >> 1;
    shape.size[k] = ((fine.first[k] + fine.size[k] - 1) >> 1) - shape.first[k] + 1;
    // the middle of voxels 2 i and 2 i + 1 is that of voxel i
    for (int row = 0; row < 3; ++row) shape.worldToIndex[4 * row + k] = 0.5 * fine.worldToIndex[4 * row + k];
    shape.worldToIndex[12 + k] = 0.5 * (fine.worldToIndex[12 + k] - 0.5);
  }
  return shape;
}

}  // namespace

void VoxelGrid::coarsen(uint64_t below) {
  constexpr int32_t kWorthIt = 16;  // voxels along the longest side of a grid that has a coarser level
  if (std::max({shape_.size[0], shape_.size[1], shape_.size[2]}) < kWorthIt) return;
  if (!coarser_) coarser_.reset(new VoxelGrid(coarserShape(shape_), store_, level_ + 1));
  const int32_t layers = int32_t(below / uint64_t(frame_.stride[1]));  // that are whole
  const GridShape& coarse = coarser_->shape_;
  for (; coarsened_ < coarse.bricks(2); ++coarsened_) {
    // the last of this level's layers that it is made of
    const int32_t last =
        std::min(2 * (coarse.firstBrick(2) + coarsened_) + 1 - shape_.firstBrick(2), shape_.bricks(2) - 1);
    if (last >= layers) break;
    coarsenLayer(coarsened_);
  }
  coarser_->coarsen(uint64_t(coarsened_) * uint64_t(coarser_->frame_.stride[1]));
}

void VoxelGrid::coarsenLayer(int32_t z) {
  const size_t channels = size_t(shape_.channels), floats = size_t(GridShape::kVoxels) * channels;
  std::vector<float> made(floats);
  for (int32_t y = 0; y < coarser_->shape_.bricks(1); ++y)
    for (int32_t x = 0; x < coarser_->shape_.bricks(0); ++x) {
      const int32_t at[3] = {x, y, z};
      if (!averageBricks(at, made.data())) continue;
      const bool isOne = std::memcmp(made.data(), made.data() + channels, (floats - channels) * sizeof(float)) == 0;
      if (isOne && std::all_of(made.begin(), made.begin() + long(channels), [](float v) { return v == 0; })) continue;
      const uint64_t number = uint64_t(coarser_->frame_.numberOf(x, y, z));
      if (isOne)
        coarser_->addConstantBrick(number, made.data());
      else
        std::copy(made.begin(), made.end(), coarser_->addBrick(number));
    }
}

// One brick of the coarser level. Beyond the box there is nothing, as lookups have it. False: no brick is there.
bool VoxelGrid::averageBricks(const int32_t at[3], float* out) const {
  const size_t channels = size_t(shape_.channels);
  const float* bricks[8] = {};
  int32_t first[3];  // of the bricks that it is made of
  for (int k = 0; k < 3; ++k) first[k] = 2 * (coarser_->shape_.firstBrick(k) + at[k]) - shape_.firstBrick(k);
  bool isAny = false;
  for (int corner = 0; corner < 8; ++corner) {
    const int32_t b[3] = {first[0] + (corner & 1), first[1] + (corner >> 1 & 1), first[2] + (corner >> 2)};
    if (b[0] < 0 || b[1] < 0 || b[2] < 0 || b[0] >= shape_.bricks(0) || b[1] >= shape_.bricks(1) ||
        b[2] >= shape_.bricks(2))
      continue;
    bricks[corner] = table_[size_t(frame_.numberOf(b[0], b[1], b[2]))];
    isAny |= bricks[corner] != nullptr;
  }
  if (!isAny) return false;
  std::fill_n(out, size_t(GridShape::kVoxels) * channels, 0.f);
  for (int corner = 0; corner < 8; ++corner) {
    const float* const fine = bricks[corner];
    if (!fine) continue;
    store_->use(fine);
    int32_t from[3], to[3];  // voxels of the brick that lie in the box
    for (int k = 0; k < 3; ++k) {
      const int32_t begin = frame_.offset[k] - 8 * (first[k] + (corner >> k & 1));
      from[k] = std::max(begin, 0);
      to[k] = std::min(begin + shape_.size[k], 8);
    }
    const size_t origin = size_t(corner & 1) * 4 + size_t(corner >> 1 & 1) * 32 + size_t(corner >> 2) * 256;
    for (int32_t z = from[2]; z < to[2]; ++z)
      for (int32_t y = from[1]; y < to[1]; ++y)
        for (int32_t x = from[0]; x < to[0]; ++x) {
          const float* const v = fine + size_t(x + 8 * y + 64 * z) * channels;
          float* const sum = out + (origin + size_t((x >> 1) + 8 * (y >> 1) + 64 * (z >> 1))) * channels;
          for (size_t c = 0; c < channels; ++c) sum[c] += v[c] * 0.125f;
        }
  }
  return true;
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
  const float* const brick = table_[size_t(frame_.brickOf(at))];
  if (brick) store_->use(brick);
  return brick ? brick + frame_.inBrick(at) * shape_.channels : nullptr;
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

void VoxelGrid::lookUp(uint32_t width, uint32_t n, const float* const world[3], VoxelWrap wrap,
                       float* const out[3]) const {
  const GridLookupArgs args{
      &frame_,
      table_.data(),
      store_.get(),
      wrap == VoxelWrap::Clamp,
      n,
      {world[0], world[1], world[2]},
      {out[0], shape_.channels == 3 ? out[1] : nullptr, shape_.channels == 3 ? out[2] : nullptr}};
  gridLookupKernel(width, shape_.channels)(args);
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
        const int32_t end = std::min(to[0], at[0] + 7 - ((at[0] + frame_.offset[0]) & 7));
        for (int32_t x = 1; v && x <= end - at[0]; ++x) see(v + x * channels);
        at[0] = end + 1;
      }
}

}  // namespace kinora::volume
