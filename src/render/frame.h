// The loop over a frame: passes, stages, buckets, groups. Each pass is a range of sample indices over the whole
// picture; between stages all threads meet. Called by Renderer; it decides nothing about files.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "film/film.h"
#include "film/filter_ratio.h"
#include "film/pixel_filter.h"
#include "film/splat_filter.h"
#include "render/adaptive.h"
#include "render/filters.h"
#include "render/hider.h"
#include "render/learned_state.h"
#include "render/reading_plan.h"
#include "render/services.h"

namespace kinora::render {

struct FrameInput {
  const WorldBuilder* world;
  const Descriptor* integrator;
  const void* integratorData;
  const film::LightPaths* paths;
  const RecordPlan* plan;
  const film::PixelFilter* filter;
  const FilterChain* sampleFilters = nullptr;
  std::vector<film::FilterRatio> ratios;  // by filter of the film's layout
  film::Film* film;
  const Hider* hider = nullptr;  // null: the loop over rays
  uint32_t seed = 0;
  int firstSample = 0, lastSample = 64;  // half open
  const ActivePixels* active = nullptr;  // where passes take samples; null: everywhere
  NoiseEstimate* noise = nullptr;        // gets every sample's three floats from `noiseOffset` of the record on
  int noiseOffset = 0;
  int threads = 1;
  uint32_t groupSize = 1024;
  std::string bucketOrder = "horizontal";
  bool jitter = true;
  std::atomic<bool>* stop = nullptr;
  shade::RayListener* rayListener = nullptr;
  // Reads what rays of some of these groups have met that had not been read, and makes another world in the place of
  // `world`; false when it was stopped. Sets the groups' turns, and adds to their needs. Asked between groups;
  // statistics of workers that the old world had are added to `statistics` before.
  std::function<bool(std::vector<WaitingGroup*>&)> readMet;
  Statistics* statistics = nullptr;
};

// Workers live as long as the frame, so that arenas stay warm from pass to pass.
class Frame {
 public:
  explicit Frame(const FrameInput& input);
  ~Frame();
  // Renders one range of sample indices; false when stopped before all of it was done.
  bool pass(int first, int last);
  static constexpr int kMostSamplesOfPass = 16;
  // Ranges of the passes: 1, 1, 2, 4, 8, then 16 at a time; never more than `most` (0: no bound).
  static std::vector<std::pair<int, int>> passes(int first, int last, int most = 0);
  // That bound for an integrator, as a power of two.
  static int passSamplesOf(const Descriptor& integrator, const void* data);
  void addTo(Statistics& s) const;
  bool replay(int x, int y, int sample, const std::function<void(const std::string&)>& print);
  uint64_t arenaBytes() const;
  uint64_t droppedRecords() const { return store_ ? store_->dropped() : 0; }
  // Bytes that the records of one sample will take, by following a share of its light paths, which leave nothing else.
  // A function of the sample alone. 0: it keeps none. Throws MemoryExceeded where not even those of that share fit.
  uint64_t foreseenRecords(int sample);
  // Another instance of the same integrator, from the next pass on.
  void setIntegratorData(const void* data) { in_.integratorData = data; }
  // Null: the integrator keeps no records between stages.
  const PassStore* store() const { return store_.get(); }
  // Null: the integrator learns nothing.
  const LearnedState* learned() const { return learned_.get(); }
  // False where the integrator wants to learn and cannot, see kinora/integrator.h, Learning.
  bool learnsAsWanted() const { return learnsAsWanted_; }

 private:
  struct Bucket {
    int x, y;
  };
  class RayLoop;
  // Paths that have not taught yet: of samples [first, last), where `done` is not active (none: everywhere).
  struct Lesson {
    int first, last;
    std::optional<ActivePixels> done;
  };
  // One loop a thread; each takes the next item until there is none. False when stopped.
  bool parallel(const std::function<bool(size_t worker)>& next);
  // Paths of an item come in blocks of kBlock x kBlock, which are those of so many pixels side by side where all are
  // active: blocks [first, last) are a group. It is void when its rays met what has not been read.
  struct Void {
    uint64_t item;
    uint32_t first, last;
    WaitingGroup waiting;
    bool operator<(const Void& o) const { return item != o.item ? item < o.item : first < o.first; }
  };
  // Goes through the blocks of an item: which are rendered now, and where groups end.
  class Groups {
   public:
    Groups(const Frame& frame, uint64_t item, uint32_t blocks);  // `blocks`: of a group that is tried first
    // The next block; false: it is not rendered now.
    bool next();
    bool isFull() const { return at_ == last_; }  // the block is the last one of its group
    uint32_t first() const { return first_; }
    uint32_t last() const { return at_; }

   private:
    const Frame& frame_;
    uint64_t item_;
    uint32_t blocks_, at_ = 0, first_ = 0, last_ = 0;  // at_: behind the block
    std::vector<Void>::const_iterator again_;
  };
  // All items, on all threads; then again void groups, once what these met has been read, until there are none. run()
  // goes through each item's Groups and asks keep() after each.
  bool forEachItem(uint64_t items, const std::function<void(Worker& w, uint64_t item)>& run);
  bool keep(Worker& w, uint64_t item, uint32_t first, uint32_t last);
  bool readMet(std::vector<WaitingGroup*>& groups);
  bool readMet(WaitingGroup& group, const Worker& w);
  void makeWorkers();
  void addWorkers(Statistics& s) const;
  bool renderPass(int first, int last);
  void makeLearned();
  bool learnUpTo(int sample);
  bool teach(const Lesson& lesson);
  void addPath(shade::GroupState& s, int x, int y, int sample, uint32_t& n) const;
  void cameraGroup(Worker& w, uint32_t count, uint32_t stage);
  void retire(Worker& w, uint32_t count);
  void addNoise(uint32_t count, const float* const* colour, const float* tolerance, shade::GroupState& s);
  void cameraRays(Worker& w, uint32_t count);
  uint64_t pathsOf(const Stage& s) const;  // light paths a sample
  bool replayEarlierStages(int sample, uint32_t& stage);
  void endStage(uint32_t stage, int first, int last);
  void lightPaths(Worker& w, uint64_t firstPath, uint32_t count, int sample, uint32_t stage);
  enum class Replayed : uint8_t { Done, Void, Failed };
  Replayed replayOnce(int x, int y, int sample, const std::function<void(const std::string&)>& print);
  FrameInput in_;
  const IntegratorFunctions* functions_;
  std::vector<Stage> stages_;
  int bucketSide_ = 16;  // pixels
  std::vector<Bucket> buckets_;
  std::vector<uint64_t> bucketTimes_;  // nanoseconds; each entry is one worker's at a time
  film::SplatFilter splatFilter_;
  std::vector<std::unique_ptr<Worker>> workers_;
  bool isAgain_ = false;                 // only the groups of again_ are rendered
  std::vector<Void> again_;              // in order
  std::vector<std::vector<Void>> void_;  // by worker
  std::unique_ptr<Hider> rayLoop_;
  const Hider* hider_;
  uint64_t lightPathsPerSample_ = 0;
  struct Times;
  std::unique_ptr<Times> times_;
  std::atomic<double> firstGroupAge_{-1};  // of the process, when its first samples became pixels
  std::unique_ptr<PassStore> store_;       // null: the integrator keeps no records
  std::unique_ptr<LearnedState> learned_;
  bool learnsAsWanted_ = true;
  std::atomic<bool> isCutShort_{false};  // a group was dropped since the renderer is stopping; no further one counts
  bool teaches_ = false;                 // paths of the groups that are rendered now may teach
  int taughtTo_ = 0;                     // samples below this have taught, or are among the lessons owed
  std::vector<Lesson> lessons_;          // owed before the epoch ends
};

}  // namespace kinora::render
