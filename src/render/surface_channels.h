// The values of built-in channel sources (film/sources.h) at the points that camera rays hit. Made by Worker for each
// context of first hits; it computes what is asked for and keeps nothing. Misses keep what the record was cleared to.
#pragma once
#include "film/sources.h"
#include "render/world_build.h"
#include "shade/group.h"

namespace kinora::render {

class SurfaceChannels {
 public:
  SurfaceChannels(const Context* c, shade::GroupState& state, const CameraState& camera)
      : c_(c), state_(state), camera_(camera) {}
  // Arrays by point, of the context's life; those of components that the source lacks repeat (one float) or are null.
  struct Value {
    const float* data[3] = {nullptr, nullptr, nullptr};
    uint32_t stride = 1;
  };
  Value of(film::Source source);

 private:
  float* floats() const { return c_->alloc<float>(c_->padded); }
  Value one(const float* v) const { return {{v, v, v}, 1}; }
  Value three(const float* const v[3]) const { return {{v[0], v[1], v[2]}, 1}; }
  Value constant(float v) const;
  Value depth() const;
  Value id2() const;
  Value footprintIn(Builtin derivative) const;
  Value motion(film::Source source) const;
  // From the change in camera space; three components, the last one 0.
  Value rasterMotion(const float* const d[3], float sign) const;
  void toCamera(const float p[3], float t, float out[3]) const;

  const Context* c_;
  shade::GroupState& state_;
  const CameraState& camera_;
};

}  // namespace kinora::render
