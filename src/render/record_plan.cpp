#include "render/record_plan.h"

#include <cmath>
#include <cstdint>
#include <utility>

namespace kinora::render {

bool isReferenceSource(std::string_view source) {
  return source == "__Pref" || source == "__Nref" || source == "__WPref" || source == "__WNref";
}

RecordPlan planRecord(const film::ChannelLayout& layout) {
  RecordPlan p;
  for (const film::RecordEntry& e : layout.record()) {
    std::array<float, 3> remap;
    const std::string source = film::sourceBehind(e.source, remap);
    if (remap[2] > 0) p.remaps.push_back({e.offset, e.width, remap});
    p.sources.push_back(source);
    p.offsets.push_back(e.offset);
    p.widths.push_back(e.width);
    p.splatChannels.emplace_back();
    for (int c = 0; c < layout.size(); ++c)
      if (layout[c].splats && layout[c].source == e.source) p.splatChannels.back().push_back(c);
    const film::SourceInfo* known = film::findSource(source);
    if (source == film::kVisibleFallback) {
      p.cleared.push_back({e.offset, 1});
      if (e.width == 3) p.cleared.push_back({e.offset + 2, 1});
    } else if (!known) {
      if (!film::LightPaths::knows(source)) p.primvars.push_back({source, e.offset, e.width});
    } else if (known->source == film::Source::SampleCount) {
      p.cleared.push_back({e.offset, 1});
    } else if (known->source == film::Source::CpuTime) {
      p.cpuTime.push_back(e.offset);
    } else {
      if (known->source == film::Source::Depth) p.cleared.push_back({e.offset, INFINITY});
      if (known->source == film::Source::Alpha || known->source == film::Source::Opacity)
        for (int k = 0; k < e.width; ++k) p.coverage.push_back(e.offset + k);
      p.surfaces.push_back({known->source, e.offset, e.width, false});
    }
  }
  p.floats = layout.recordFloats();
  return p;
}

void addUserLobes(const film::LightPaths& paths, RecordPlan& plan) {
  static constexpr std::pair<uint32_t, film::Source> kSignals[] = {
      {2, film::Source::Albedo}, {3, film::Source::P}, {6, film::Source::Nn}};
  for (size_t i = 0; i < plan.sources.size(); ++i)
    for (const auto& [lobe, source] : kSignals)
      if (paths.userLobes(i) >> (lobe - 1) & 1)
        plan.surfaces.push_back({source, plan.offsets[i], plan.widths[i], true});
}

}  // namespace kinora::render
