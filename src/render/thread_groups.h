// Groups of a world for who shades on many threads while it is built: one a thread, made when the thread first asks.
#pragma once
#include <tbb/enumerable_thread_specific.h>

#include <memory>

#include "base/arena.h"
#include "render/shading_floats.h"
#include "shade/group.h"

namespace kinora::render {

class ThreadGroups {
 public:
  explicit ThreadGroups(const shade::ShadingWorld& world) : world_(world) {}
  // This thread's group for as long as it lives: its memory since then goes back, and numbers are rounded as in passes.
  class Use {
   public:
    explicit Use(ThreadGroups& groups) : group_(groups.ofThread()), memory_(group_.arena()) {}
    shade::GroupState& group() const { return group_; }
    Arena& arena() const { return group_.arena(); }

   private:
    ShadingFloats floats_;
    shade::GroupState& group_;
    ArenaScope memory_;
  };

 private:
  shade::GroupState& ofThread() {
    std::unique_ptr<shade::GroupState>& group = groups_.local();
    if (!group) group = std::make_unique<shade::GroupState>(world_);
    return *group;
  }
  const shade::ShadingWorld& world_;
  tbb::enumerable_thread_specific<std::unique_ptr<shade::GroupState>> groups_;
};

}  // namespace kinora::render
