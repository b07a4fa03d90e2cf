// The services table that integrators get, over one thread's GroupState and sample records. Internal to render/.
#pragma once
#include <kinora/integrator.h>

#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "film/film.h"
#include "film/light_paths.h"
#include "film/splat_filter.h"
#include "render/learned_state.h"
#include "render/pass_store.h"
#include "render/record_plan.h"
#include "render/statistics.h"
#include "render/world_build.h"
#include "shade/group.h"

namespace kinora::render {

class MarkedChannels;

// One thread's part of a render.
class Worker {
 public:
  Worker(const shade::ShadingWorld& world, const CameraState& camera, const RecordPlan& plan,
         const film::LightPaths& paths, film::Film& film, const film::SplatFilter& splatFilter,
         uint64_t lightPathsPerPass);
  ~Worker();
  shade::GroupState& state() { return state_; }
  Services& services() { return services_; }
  // Whether the integrator takes contexts of points in media; before the first group.
  void scatterInMedia(bool scatters);
  // Readies the group and clears its records.
  void begin(uint32_t count, StageKind stage);
  // All floats of the records, to be read and written.
  float* const* records() {
    for (size_t k = 0; k < records_.size(); ++k) record(k);
    return records_.data();
  }
  // The same to be read: what nothing has been written to is zeros().
  const float* const* values();
  const float* zeros() const { return zeros_.data(); }
  // After the integrator, before the film: what concerns whole records of `count` samples.
  void finishRecords(uint32_t count);
  void setCpuTime(uint32_t count, float secondsASample);
  // In worlds with parts that have not been read a group is tried: what it leaves behind (records of an integrator,
  // splats, counts) counts once keepTry() has found that none of its rays met such a part, and is taken back otherwise.
  void beginTry();
  bool keepTry();
  // Which those were, by number in the world's UnreadBounds, of the last try that was not kept.
  std::vector<uint32_t> metUnread() const;
  // The same for what is to leave nothing behind but records.
  void beginLook();
  void endLook();
  // By slot: PlacementInfo::noiseTolerance of what the camera ray met. Null: 1 everywhere.
  const float* tolerances() const { return tolerances_; }
  std::function<void(const std::string&)> print;  // while a sample is replayed
  uint32_t printSlot = 0;
  uint64_t lightRays = 0;
  std::vector<float*> filterWeights;  // by filter of the film's layout: of the samples of the group
  size_t index = 0;                   // of the worker in its frame
  PassStore* store = nullptr;         // of its frame; null: the integrator keeps no records
  LearnedState* learned = nullptr;    // of its frame; null: the integrator learns nothing
  void learn(LearnedState* state) {
    learned = state;
    state_.weighsLights = state != nullptr;
  }

 private:
  struct Calls;
  void primary(const Context* c);
  void contribute(const Contributions* c);
  void noteWalks(const WalkNote& note);
  void emitLight(uint32_t n, EmittedLight* out);
  uint32_t keepLinked(uint32_t n, const uint32_t** slots);
  bool isHidden(uint32_t instance, uint32_t geometry) const;  // from the camera
  void connectCamera(const Context* c, CameraConnection* out);
  void splat(uint32_t n, const float* const raster[2], const float* const value[3], const uint32_t* state,
             const uint32_t* light);
  uint32_t endOf(uint32_t light) const { return light < ends_.size() ? ends_[light] : film::LightPaths::kGlow; }

  shade::GroupState state_;
  const CameraState& camera_;
  const RecordPlan& plan_;
  const film::LightPaths& paths_;
  film::Film& film_;
  const film::SplatFilter* splatFilter_;
  uint64_t lightPathsPerPass_;
  Services services_{};
  float* record(size_t k) {
    if (!isWritten_[k]) {
      std::memset(records_[k], 0, recordBytes_);
      isWritten_[k] = 1;
    }
    return records_[k];
  }
  std::vector<float*> records_;  // cleared at the first use: most of a list of light paths are not reached
  std::vector<uint8_t> isWritten_;
  size_t recordBytes_ = 0;
  std::vector<float> zeros_;
  bool hasTolerances_ = false;  // some object has another than 1
  float* tolerances_ = nullptr;
  std::vector<const float*> values_;
  std::vector<uint32_t> emitted_;  // light by slot, of the group's light paths
  // Where contributions go, by kind of light, state and end: a set, targets_[first_[set]] to targets_[first_[set +
  // 1]].
  struct Target {
    int offset;
    float sign;
  };
  std::vector<Target> targets_;
  std::vector<uint16_t> setOf_;
  std::vector<uint32_t> first_;
  uint32_t endCount_ = 1, perKind_ = 0;
  std::vector<uint16_t> ends_;       // by light
  std::vector<uint8_t> exceptions_;  // by light, see Services::lightExceptions
  std::vector<uint8_t> walkedTo_;    // by light, see Services::lightWalks
  std::unique_ptr<MarkedChannels> marks_;
  std::function<float*(int)> recordAt_;
  std::vector<int> splatChannels_;
  std::vector<uint8_t> takesSplat_;  // by splat channel, state and end
  struct Try {
    uint64_t notes = 0;
    std::vector<uint64_t> met;  // a bit for each unread bound of the world
    shade::GroupCounters counters;
    uint64_t lightRays = 0;
    std::vector<size_t> records;  // by list of the store
    size_t lessons = 0;
    struct Splat {
      int channel;
      int32_t x, y;
      float value[3];
    };
    std::vector<Splat> splats;
    bool isOpen = false;
  } try_;
};

}  // namespace kinora::render
