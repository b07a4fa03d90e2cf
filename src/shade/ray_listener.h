// Sees the rays of each group just before they are traced. Given by bench/ through render::Settings to record a
// render's own rays; null elsewhere, which costs one branch a group and call. It changes nothing of what is traced.
// Called on the workers' threads: render with one thread, or lock.
#pragma once
#include <kinora/integrator.h>

namespace kinora::shade {

class RayListener {
 public:
  virtual ~RayListener() = default;
  virtual void closest(RayKind kind, uint32_t depth, const Rays& rays, uint32_t n, const uint32_t* slots) = 0;
  virtual void shadow(uint32_t depth, const ShadowRays& rays) = 0;
};

}  // namespace kinora::shade
