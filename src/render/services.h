// The services table that integrators get, over one thread's GroupState and sample records. Internal to render/.
#pragma once
#include <kinora/integrator.h>

#include <functional>
#include <string>
#include <vector>

#include "film/film.h"
#include "film/light_paths.h"
#include "render/statistics.h"
#include "render/world_build.h"
#include "shade/group.h"

namespace kinora::render {

// Where the values of surfaces go in a sample record: offsets of the first float, -1 when nobody wants it.
struct SurfaceOutputs {
  int Ci = -1, a = -1, z = -1, P = -1, Nn = -1, Ngn = -1, Vn = -1, albedo = -1, u = -1, v = -1, s = -1, id = -1, VLen = -1,
      radius = -1, spread = -1, outsideIor = -1, time = -1, sampleCount = -1, pworld = -1, nworld = -1;
};

// Channels of the film, resolved once: light path outputs and surface outputs by offset.
struct RecordPlan {
  std::vector<std::string> sources;      // by record entry
  std::vector<int> offsets;              // of each source's first float
  std::vector<int> widths;
  SurfaceOutputs surface;
  int floats = 0;
  std::vector<int> splatChannel;         // film channel of each source that takes splats, -1 others
};
RecordPlan planRecord(const film::ChannelLayout& layout, Diagnostics& diagnostics);

// One thread's part of a render.
class Worker {
 public:
  Worker(const shade::ShadingWorld& world, const CameraState& camera, const RecordPlan& plan, const film::LightPaths& paths,
         film::Film& film, uint64_t lightPathsPerPass);
  shade::GroupState& state() { return state_; }
  Services& services() { return services_; }
  // Readies the group and clears its records.
  void begin(uint32_t count, StageKind stage);
  float* const* records() { return records_.data(); }
  std::function<void(const std::string&)> print;   // while a sample is replayed
  uint32_t printSlot = 0;
  uint64_t lightRays = 0;
  size_t index = 0;   // of the worker in its frame

 private:
  struct Calls;
  void primary(const Context* c);
  void contribute(const Contributions* c);
  void emitLight(uint32_t n, float* const throughput[3], uint32_t* light);
  void connectCamera(const Context* c, CameraConnection* out);
  void splat(uint32_t n, const float* const raster[2], const float* const value[3], const uint32_t* state);

  shade::GroupState state_;
  const CameraState& camera_;
  const RecordPlan& plan_;
  const film::LightPaths& paths_;
  film::Film& film_;
  uint64_t lightPathsPerPass_;
  Services services_{};
  std::vector<float*> records_;
  std::vector<std::vector<std::pair<int, int>>> outputsOfState_;   // (offset, splat channel)
};

}  // namespace kinora::render
