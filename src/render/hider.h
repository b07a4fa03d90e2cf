// What fills the sample records of a bucket: the loop over rays (frame.cpp) is one hider, a micropolygon hider
// another. Called by Frame on its threads; it knows no passes, displays or files, and the film only through `retire`.
#pragma once
#include <cstdint>
#include <functional>

namespace kinora::render {

class Worker;
struct CameraState;
class ActivePixels;

// A bucket's share of a pass.
struct BucketSamples {
  int x0, y0, x1, y1;           // raster pixels, half open; may reach beyond the window, where samples are ignored
  int firstSample, lastSample;  // indices, half open
  uint32_t stage;               // of the integrator
  uint32_t seed;                // of the frame
  const CameraState* camera;
  const ActivePixels* active;  // pixels that take samples in this pass; null: all
  uint64_t number = 0;         // of the bucket
};

class Hider {
 public:
  virtual ~Hider() = default;
  // As often as wanted: Worker::begin(n, StageKind::CameraPaths), then pixels, sample indices, weights
  // (GroupState::pixelX() ...) and all floats of the records (Worker::records()) of up to n samples, then
  // retire(count). Runs on several threads at once, each with a worker and buckets of its own.
  virtual void fill(Worker& worker, const BucketSamples& bucket,
                    const std::function<void(uint32_t count)>& retire) const = 0;
};

}  // namespace kinora::render
