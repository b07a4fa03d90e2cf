#include "render/marked_channels.h"

#include <algorithm>

namespace kinora::render {

MarkedChannels::MarkedChannels(const RecordPlan& plan, const shade::ShadingWorld& world) : world_(world) {
  if (!world.marks) return;
  for (const light::MarkEntry& m : *world.marks)
    for (const RecordPlan::Primvar& p : plan.primvars)
      if (p.name == m.channel && (p.width == 1 || p.width == 3)) {
        targets_.push_back({&m, p.offset, p.width});
        goesOn_ = goesOn_ || m.mark.inReflection || m.mark.inRefraction;
      }
}

void MarkedChannels::add(uint32_t depth, uint32_t count, Context* const* contexts, shade::GroupState& state,
                         const std::function<float*(int)>& record) {
  if (targets_.empty() || (depth > 0 && !goesOn_)) return;
  const RayList& list = state.group().paths;
  if (passed_.size() < state.group().padded + kPad) passed_.resize(state.group().padded + kPad);
  Arena& arena = state.arena();
  for (uint32_t k = 0; k < count; ++k) {
    const Context* c = contexts[k];
    uint8_t* passed = passed_.data();
    for (uint32_t i = 0; i < c->count; ++i) {
      const uint32_t s = c->path[i], from = list.origin[s];
      if (depth < 2) passed[s] = 0;
      if (depth > 0)
        passed[s] |= !(from & kFromSpecular) ? kScattered : from & kFromTransmission ? kRefracted : kReflected;
    }
    uint32_t* sets = arena.make<uint32_t>(c->padded);
    for (uint32_t i = 0; i < c->count; ++i)
      sets[i] = world_.placementOf(c->place.instance[i], c->place.geometry[i]).linkSet;
    float* value[3];
    for (float*& v : value) v = arena.make<float>(c->padded);
    for (const Target& t : targets_) {
      const LightMark& m = t.mark->mark;
      light::markValues(*t.mark, world_.width, arena, c, sets, value);
      const uint32_t open =
          (m.inReflection ? uint32_t(kReflected) : 0u) | (m.inRefraction ? uint32_t(kRefracted) : 0u);
      const bool weighs = depth > 0 && m.isWeighted && list.throughput[0];
      float* to[3] = {record(t.offset), t.width == 3 ? record(t.offset + 1) : nullptr,
                      t.width == 3 ? record(t.offset + 2) : nullptr};
      for (uint32_t i = 0; i < c->count; ++i) {
        const uint32_t s = c->path[i];
        if (depth == 0 ? !m.inFirst : (passed[s] & ~open) != 0) continue;
        float v[3];
        for (int q = 0; q < 3; ++q) v[q] = value[q][i] * (weighs ? list.throughput[q][s] : 1.f);
        if (t.width == 1) v[0] = 0.2126f * v[0] + 0.7152f * v[1] + 0.0722f * v[2];
        for (int q = 0; q < t.width; ++q)
          to[q][s] = depth > 0 && !m.isWeighted ? std::max(to[q][s], v[q]) : to[q][s] + v[q];
      }
    }
  }
}

}  // namespace kinora::render
