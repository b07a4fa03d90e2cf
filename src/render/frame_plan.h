// What a frame sums and writes: displays and their channels, filters, light paths, the record of a sample. Made by
// Renderer of the scene's own fields; it stands until one of them is another.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include "base/digest.h"
#include "base/file_contents.h"
#include "film/display_plan.h"
#include "film/filter_ratio.h"
#include "film/light_paths.h"
#include "film/pixel_filter.h"
#include "render/filters.h"
#include "render/services.h"

namespace kinora::render {

struct FramePlan {
  film::DisplayPlan displays;
  std::shared_ptr<const film::LightPaths> paths;
  Digest ofPaths;  // of what they were made of
  RecordPlan record;
  film::PixelFilter filter;
  FilterChain sampleFilters, displayFilters;
  std::vector<film::FilterRatio> ratios;  // by filter of the layout
  std::array<int, 2> halves{-1, -1};      // channels of the even and the odd samples; -1: not measured
  FileContents::Names files;              // that filters were made of
};

// The first colour of a layout, by which noise is measured; -1: there is none.
int firstColor(const film::ChannelLayout& layout);
bool hasJitter(const scene::Scene& scene);
film::DriverLookup displayDrivers(Registry& registry, Diagnostics& diagnostics);

// Of all that planFrame() reads beside the settings.
Digest framePlanDigestOf(const scene::Scene& scene, const CameraState& camera, bool hasLightStage, bool needsSplit);
// Null, after a message, when two pictures would go to one file. hasLightStage: the integrator splats; needsSplit:
// see WorldBuilder; `before`: the plan of the world before, or null.
std::unique_ptr<FramePlan> planFrame(const scene::Scene& scene, const Settings& settings, bool hasLightStage,
                                     bool needsSplit, const FramePlan* before, Registry& registry,
                                     WorldBuilder& builder, Diagnostics& diagnostics);

}  // namespace kinora::render
