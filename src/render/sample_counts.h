// How many samples each pixel takes: what command line, Hider, PixelSamples and PixelVariance say of it together.
// Called by Renderer.
#pragma once
#include "base/diagnostics.h"
#include "render/adaptive.h"
#include "render/renderer.h"
#include "scene/scene.h"

namespace kinora::render {

inline constexpr int kUsualSamples = 64;  // a pixel, where nothing says how many

struct SampleCounts {
  int first = 0, last = 64;  // indices, half open; with adaptivity the most
  int stride = 1;            // from one index that is taken to the next
  Adaptivity adaptivity;

  int count() const { return last > first ? (last - first + stride - 1) / stride : 0; }
};
// The samples that a part of a frame takes (--samples), by scene and --set alike: for its name.
struct PartIndices {
  int first, stride;
};
PartIndices partIndicesOf(const scene::Scene& scene, const Settings& settings);

SampleCounts sampleCountsOf(const scene::Scene& scene, const Settings& settings, Diagnostics& diagnostics);

}  // namespace kinora::render
