// The integrator of a scene's frames, and what the rest of a frame has to know of it. It is made again only where its node
// or a file that it was made of is another. Held by Renderer.
#pragma once
#include <vector>

#include "base/diagnostics.h"
#include "base/file_contents.h"
#include "plugin/registry.h"
#include "render/instance.h"
#include "render/statistics.h"
#include "render/trace_stage.h"
#include "render/volume_aggregates.h"
#include "render/world_build.h"
#include "scene/scene.h"

namespace kinora::render {

class FrameIntegrator {
 public:
  // Of the scene's node; PxrPathTracer stands in for one that is not there or cannot be made, with a message. False where
  // there is none at all.
  bool make(const scene::Scene& scene, Registry& registry, WorldBuilder& builder, Diagnostics& diagnostics,
            Rebuilt& rebuilt);
  // Made again the next time.
  void forget() { instance_ = {}; }

  const Instance& instance() const { return instance_; }
  const Descriptor& plugin() const { return *instance_.plugin(); }
  // It splats.
  bool hasLightStage() const;
  // It tells diffuse and specular lobes apart, at every bounce.
  bool tellsLobesApart() const;
  // Frame::passSamplesOf() of it.
  int passSamples() const;
  // It keeps or splats what is of one pass: where passes end, its samples change.
  bool dependsOnPasses() const { return hasLightStage() || passSamples(); }
  // What it asks of the world.
  std::vector<SetAsker> setAskers(const scene::Scene& scene) const;
  AggregateChoice aggregates(const scene::Scene& scene) const;

 private:
  Instance instance_;
  Digest of_;  // of the node that it was made of
  FileContents::Names files_;
};

}  // namespace kinora::render
