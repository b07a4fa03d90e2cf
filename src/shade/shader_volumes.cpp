// texture3d() of shaders: grids of volume files at points of world space ("common" to shaders).
#include <algorithm>
#include <cmath>

#include "shade/shader_textures.h"
#include "shade/texture_call.h"
#include "volume/grid_stream.h"
#include "volume/volume_system.h"

namespace kinora::shade {

using volume::VoxelGrid;
using volume::VoxelLookup;
using volume::VoxelWrap;

namespace {

// "default" is black: the files say nothing of wrapping.
VoxelWrap voxelWrap(int code) {
  return code == 2   ? VoxelWrap::Clamp
         : code == 3 ? VoxelWrap::Periodic
         : code == 4 ? VoxelWrap::Mirror
                     : VoxelWrap::Black;
}

// How a grid's numbers become the result: one number is grey, unless the call speaks of channels.
struct VolumeChannels {
  int available;
  bool isGrey;
  VolumeChannels(const VoxelGrid& grid, const TextureCallOptions& o)
      : available(grid.shape().channels - o.plain.firstChannel),
        isGrey(grid.shape().channels == 1 && o.plain.firstChannel == 0 && !o.hasFill) {}
  // Of component k; v: of the grid's first channel.
  float of(const float* v, uint32_t k, const TextureCallOptions& o) const {
    return isGrey ? v[0] : int(k) < available ? v[o.plain.firstChannel + int(k)] : o.fill;
  }
};

}  // namespace

const VoxelGrid* ShaderTextures::gridOf(int32_t name, const TextureCallOptions& o) {
  const std::array<int32_t, 3> key{name,
                                   o.hasPartNumber   ? 1
                                   : o.partText >= 0 ? 2
                                                     : 0,
                                   o.hasPartNumber ? o.part.number : o.partText};
  const auto [it, isNew] = grids_.try_emplace(key, nullptr);
  if (isNew && volumes_) {
    const std::string which = o.hasPartNumber        ? volume::gridByNumber(o.part.number)
                              : !o.part.name.empty() ? volume::gridByName(std::string(o.part.name))
                                                     : "";
    it->second = volumes_->grid(language::stringOf(name), which, "a texture3d call of a shader");
  }
  return it->second;
}

void ShaderTextures::volume(const Batch& all, const TextureCall& call) {
  static const int32_t kNotThere = language::internString("the volume is not there"),
                       kNoChannel = language::internString("the volume has no such channel");
  const Batch batch = pointsOf(all, call);
  const bool isUniform = !hasVaryingOptions(call) && !call.file.varies;
  const uint32_t components = call.result.components;
  for (uint32_t first = 0; first < batch.points;) {
    uint32_t end = isUniform ? batch.points : first + 1;
    while (end < batch.points && (!batch.isLive(end) || (call.file.integer(0, first) == call.file.integer(0, end) &&
                                                         sameOptions(call, first, end))))
      ++end;
    uint32_t live = first;
    while (live < end && !batch.isLive(live)) ++live;
    if (live == end) {
      first = end;
      continue;
    }
    TextureCallOptions o(call, live);
    if (o.plain.firstChannel < 0) o.plain.firstChannel = 0;
    const VoxelGrid* const grid = gridOf(call.file.integer(0, live), o);
    if (!grid) {
      for (uint32_t i = live; i < end; ++i) {
        if (!batch.isLive(i)) continue;
        for (uint32_t k = 0; k < components; ++k) call.result.set(k, i, o.hasMissing ? o.plain.missingColor[k] : 0.f);
        if (call.alpha.components) call.alpha.set(0, i, o.hasMissing ? o.plain.missingAlpha : 0.f);
        if (call.error.components) call.error.set(0, i, kNotThere);
      }
      first = end;
      continue;
    }
    const VolumeChannels channels(*grid, o);
    VoxelLookup how;
    how.wrap[0] = voxelWrap(o.plain.wrapS);
    how.wrap[1] = voxelWrap(o.plain.wrapT);
    how.wrap[2] = voxelWrap(o.wrapR);
    how.isClosest = o.plain.filter == 0;
    for (uint32_t i = live; i < end; ++i) {
      if (!batch.isLive(i)) continue;
      float p[3];
      double at[3], step[3][3], spread[3] = {0, 0, 0};
      for (uint32_t k = 0; k < 3; ++k) p[k] = numberAt(call.coordinates, k, i);
      grid->toIndex(p, at);
      const Span* const steps[3] = {&call.dx, &call.dy, &call.dz};
      for (int axis = 0; axis < 3; ++axis) {
        float d[3];
        for (uint32_t k = 0; k < 3; ++k) d[k] = numberAt(*steps[axis], k, i);
        grid->stepToIndex(d, step[axis]);
        for (int k = 0; k < 3; ++k) spread[k] += step[axis][k] * step[axis][k];
      }
      // a box that spreads along each axis of the grid as the footprint does
      for (int k = 0; k < 3; ++k) {
        const float width = o.width[k].components ? numberAt(o.width[k], 0, i) : 1.f;
        how.size[k] = width * float(std::sqrt(spread[k])) + numberAt(o.blur[k], 0, i) * float(grid->shape().size[k]);
      }
      float v[3];
      grid->lookUp(at, how, v);
      for (uint32_t k = 0; k < components; ++k) call.result.set(k, i, channels.of(v, k, o));
      // the channel behind those of the result
      if (call.alpha.components)
        call.alpha.set(0, i, components == 1 && channels.available > 1 ? v[o.plain.firstChannel + 1] : 1.f);
      if (call.error.components) call.error.set(0, i, channels.available > 0 ? 0 : kNoChannel);
      for (int axis = 0; axis < 2; ++axis) {
        const Span& to = axis ? call.resultDy : call.resultDx;
        if (!to.components || !steps[axis]->components) continue;
        const double there[3] = {at[0] + step[axis][0], at[1] + step[axis][1], at[2] + step[axis][2]};
        float moved[3];
        grid->lookUp(there, how, moved);
        for (uint32_t k = 0; k < to.components; ++k) to.set(k, i, channels.of(moved, k, o) - channels.of(v, k, o));
      }
    }
    first = end;
  }
}

uint32_t ShaderTextures::volumeFact(int32_t file, const std::string& what, int32_t out[3]) {
  out[0] = 1;
  if (what == "exists") return 1;
  const bool isChannels = what == "channels";
  const VoxelGrid* const grid = isChannels || what == "resolution" ? gridOf(file, TextureCallOptions()) : nullptr;
  if (!grid) return 0;
  if (isChannels) {
    out[0] = grid->shape().channels;
    return 1;
  }
  std::copy_n(grid->shape().size, 3, out);
  return 3;
}

}  // namespace kinora::shade
