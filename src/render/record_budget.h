// The light paths that an integrator keeps where --memory-limit has no room for the records of all. Called by the renderer
// before each pass.
#pragma once
#include "base/diagnostics.h"
#include "render/frame.h"
#include "render/instance.h"
#include "scene/scene.h"

namespace kinora::render {

class RecordBudget {
 public:
  struct Of {
    Frame& frame;
    const Instance& integrator;
    const scene::Scene& scene;
    const Host& host;
    Diagnostics& diagnostics;
  };
  // Before the pass of samples [first, last): lets the frame's integrator keep what fits, by its parameter keptPaths. How
  // many follows from what was left before the first pass and from the samples up to the next power of two: not from
  // where a frame was split. Throws MemoryExceeded where nothing fits.
  void fit(const Of& of, int first, int last);

 private:
  int block_ = -1;  // the first sample of those that it holds for
  uint64_t budget_ = 0;
  float share_ = 1, told_ = 1;  // of what the scene says; the least that was told of
  Instance integrator_;         // where it is less

  void keep(const Of& of, float byDefault, float share);
};

}  // namespace kinora::render
