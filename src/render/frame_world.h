// The world that a frame's rays meet: of the scene, and of those of its procedurals that are held (render/procedurals.h).
// Where rays meet others, another world with these takes its place, and what there is no room for is dropped. Held by
// Renderer, asked by the frame's loop between groups of rays.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "base/diagnostics.h"
#include "film/light_paths.h"
#include "render/frame_integrator.h"
#include "render/frame_memory.h"
#include "render/procedurals.h"
#include "render/reading_plan.h"
#include "render/renderer.h"
#include "render/statistics.h"
#include "render/world_build.h"
#include "scene/scene.h"

namespace kinora::render {

class FrameWorld {
 public:
  // What outlives it, and may change between worlds.
  struct Parts {
    const scene::Scene& scene;
    const Settings& settings;
    Procedurals& procedurals;  // of the scene
    WorldBuilder& builder;
    const FrameIntegrator& integrator;
    FrameMemory& memory;
    Statistics& statistics;
    Diagnostics& diagnostics;
  };
  explicit FrameWorld(const Parts& parts) : parts_(parts) {}

  // There is a world to render.
  bool isReady() const { return isReady_; }
  // There is none from now on.
  void close() { isReady_ = false; }
  // Of another scene: what was told is told again.
  void forgetTold() { saidAllIsHeld_ = false; }
  // Without what procedurals stand for. These return false when they were stopped, or when nothing can be rendered.
  bool build(const std::shared_ptr<const film::LightPaths>& paths);
  // With what was held before build(), as far as it stands.
  bool resume();
  // With all there is.
  bool readAll();
  // Lets groups of rays go on that have met what is not held. keepsRecords: between stages, which name places in the
  // world.
  bool readFor(std::vector<WaitingGroup*>& groups, bool keepsRecords);

 private:
  bool buildWorld();
  bool buildNext();
  bool readInOrder(std::vector<uint32_t> which);
  bool change(const std::vector<uint32_t>& drop, const std::vector<uint32_t>& read);
  void measureRead();
  void count();
  uint64_t budget() const;
  uint64_t bytesWith(const std::vector<uint32_t>& read) const;
  void addCosts(const std::vector<ShaderCost>& before);

  Parts parts_;
  std::shared_ptr<const film::LightPaths> paths_;
  bool isReady_ = false, saidAllIsHeld_ = false;
  uint64_t plans_ = 0;  // of what procedurals are held
};

}  // namespace kinora::render
