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
  Adaptivity adaptivity;
};
SampleCounts sampleCountsOf(const scene::Scene& scene, const Settings& settings, Diagnostics& diagnostics);

}  // namespace kinora::render
