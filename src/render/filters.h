// Sample and display filters of a scene: plug-ins in order, each with the channels it asked for. Made by Renderer for
// each frame; run by the loop over samples (between paths and film) and when pictures are written.
#pragma once
#include <kinora/channel_filter.h>

#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "film/display_output.h"
#include "film/film.h"
#include "film/filtered_pixels.h"
#include "film/pixel_filter.h"
#include "light/light_set.h"
#include "plugin/registry.h"
#include "render/camera.h"
#include "render/world_build.h"
#include "scene/scene.h"

namespace kinora::render {

class FilterChain {
 public:
  // Of the nodes that the scene lists the last is active; a combiner (PxrSampleFilterCombiner,
  // PxrDisplayFilterCombiner) names others to run in order. What cannot be used is a message and left out.
  void make(Kind kind, const std::vector<scene::NodePtr>& nodes, const film::ChannelLayout& layout,
            const ChannelFilterInfo& picture, Registry& registry, const Host& host, uint32_t width,
            Diagnostics& diagnostics);
  bool empty() const { return steps_.empty(); }
  // Whether some filter has to do with the channel or those of its source: what it holds may be the filter's.
  bool uses(const std::string& name) const;
  // Samples of a group: their records are changed in place. Padded arrays.
  void run(uint32_t count, const int32_t* x, const int32_t* y, float* const* records) const;
  // The pixels of a film.
  film::FilteredPixels run(const film::Film& film) const;

 private:
  static constexpr uint32_t kMostChannels = 32;
  struct Channel {
    std::string name;      // as the filter asks for it
    int layoutIndex = -1;  // -1: the frame has none
    int record = -1, width = 0;
    bool isCopy = false;  // another one of the step's runs changes it: this one sees what was there before
  };
  using Run = std::vector<Channel>;
  // Displays with settings of their own have channels of their own of the same names: a run for each.
  struct Step {
    Instance instance;
    const void* functions = nullptr;
    std::vector<Run> runs;
    bool seesPicture = false;
  };
  void addRuns(const film::ChannelLayout& layout, Run first, Step& step) const;
  void call(const Step& step, const ChannelFilterArgs& args) const;
  Kind kind_ = Kind::SampleFilter;
  std::vector<Step> steps_;
};

// The display filters of a plan for pictures of `film`'s size, as Renderer would make them of its scene (kinora merge).
// They hold what they need beside the registry and the diagnostics.
film::DisplayOutput::PixelStage displayFiltersOf(const film::DisplayPlan& plan, const film::Film& film,
                                                 Registry& registry, Diagnostics& diagnostics);

// The pixel filter that a scene names: one of RIB's, else a plug-in. FILM-FILTER and gaussian 2 2 when it is neither.
void makePixelFilter(const scene::Scene& scene, Registry& registry, const Host& host, Diagnostics& diagnostics,
                     film::PixelFilter& out);

// The filters of a light, ready for its entry in the light set.
std::vector<light::LightFilterEntry> makeLightFilters(const scene::Light& light, const scene::Scene& scene,
                                                      const CameraState& camera, Registry& registry, const Host& host,
                                                      Diagnostics& diagnostics, float& largestFactor);

}  // namespace kinora::render
