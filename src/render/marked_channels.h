// Channels that lights mark what they are linked to in (light/light_marks.h): filled by Worker for the contexts that an
// integrator shades on the paths of its samples, at what the camera sees and along reflections and refractions.
#pragma once
#include <functional>
#include <vector>

#include "light/light_marks.h"
#include "render/services.h"
#include "shade/group.h"

namespace kinora::render {

class MarkedChannels {
 public:
  MarkedChannels(const RecordPlan& plan, const shade::ShadingWorld& world);
  bool empty() const { return targets_.empty(); }
  // Contexts at which paths of the group's own list arrive; depth 0: what the camera sees. record(k): a record's floats,
  // by slot.
  void add(uint32_t depth, uint32_t count, Context* const* contexts, shade::GroupState& state,
           const std::function<float*(int)>& record);

 private:
  struct Target {
    const light::MarkEntry* mark;
    int offset, width;
  };
  const shade::ShadingWorld& world_;
  std::vector<Target> targets_;
  bool goesOn_ = false;  // some mark is seen by rays that go on
  // By slot: what the path has passed; only mirror-like reflections and refractions go on.
  enum Passed : uint8_t { kReflected = 1, kRefracted = 2, kScattered = 4 };
  std::vector<uint8_t> passed_;
};

}  // namespace kinora::render
