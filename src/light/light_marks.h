// Lights that mark what they are linked to (LightMark), beside the lights that light (light_set.h). Built by render/ from
// the scene's lights; asked by render/ for the points of contexts.
#pragma once
#include <kinora/context.h>
#include <kinora/light.h>

#include <memory>
#include <string>
#include <vector>

#include "light/light_filters.h"

namespace kinora::light {

struct MarkEntry {
  std::string channel;
  LightMark mark{};
  float center[3] = {0, 0, 0};  // where the light stands, render space: filters are told so
  std::vector<LightFilterEntry> filters;
  std::vector<std::shared_ptr<void>> owners;
  std::vector<uint8_t> isLinked;      // by link set
  std::vector<uint64_t> filterLinks;  // by link set, FilterUse::links of its objects; empty: all filters are on all
};

// What the light adds to its channel at the points of a context, by point; linkSet: of the points' objects.
void markValues(const MarkEntry& mark, uint32_t width, Arena& arena, const Context* c, const uint32_t* linkSet,
                float* const out[3]);

}  // namespace kinora::light
