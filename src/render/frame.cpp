#include "render/frame.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <exception>
#include <tuple>

#include "render/frame_parts.h"
#include "simd/dispatch.h"
#include "trace/geometry_cache.h"

namespace kinora::render {

namespace {

constexpr uint32_t kPathsOfBlock = kBlock * kBlock;

// What the integrator wants to learn, if it learns at all.
std::optional<Learning> learningOf(const Descriptor& integrator, const void* data) {
  const auto* traits = static_cast<const IntegratorTraits*>(integrator.traits);
  Learning wanted;
  if (!traits || !traits->learning || !traits->learning(data, &wanted)) return {};
  if (!wanted.recordBytes || !wanted.samples || !wanted.paths) return {};
  return wanted;
}

bool isOfCamera(const Stage& s) { return s.kind == StageKind::CameraPaths; }

}  // namespace

// The stock hider: groups of camera rays go through the integrator.
class Frame::RayLoop final : public Hider {
 public:
  explicit RayLoop(Frame& frame) : frame_(frame) {}
  void fill(Worker& w, const BucketSamples& b, const std::function<void(uint32_t)>& retire) const override {
    const auto& win = b.camera->window;
    const uint32_t size = frame_.in_.groupSize;
    // what is active, block by block
    std::vector<std::array<int, 2>> pixels;
    for (int y0 = b.y0; y0 < b.y1; y0 += kBlock)
      for (int x0 = b.x0; x0 < b.x1; x0 += kBlock) {
        // a block that touches the window is traced whole: its packet must not depend on the crop
        if (x0 + kBlock <= win[0] || x0 >= win[2] || y0 + kBlock <= win[1] || y0 >= win[3]) continue;
        ActivePixels::forEach(b.active ? b.active->activeIn(x0, y0) : ActivePixels::kAll, x0, y0, [&](int x, int y) {
          pixels.push_back({x, y});
        });
      }
    const uint64_t paths = uint64_t(b.lastSample - b.firstSample) * pixels.size();
    uint32_t n = 0;
    shade::GroupState& s = w.state();
    Groups groups(frame_, b.number, size / kPathsOfBlock);
    const auto run = [&] {
      w.beginTry();
      frame_.cameraGroup(w, n, b.stage);
      if (frame_.keep(w, b.number, groups.first(), groups.last())) retire(n);
      n = 0;
    };
    w.begin(size, StageKind::CameraPaths);
    for (uint64_t path = 0; path < paths && !frame_.isCutShort_;) {
      const uint64_t end = std::min(path + kPathsOfBlock, paths);
      if (!groups.next()) {
        path = end;
        continue;
      }
      size_t pixel = path % pixels.size();
      int sample = b.firstSample + int(path / pixels.size());
      for (; path < end; ++path) {
        frame_.addPath(s, pixels[pixel][0], pixels[pixel][1], sample, n);
        if (++pixel < pixels.size()) continue;
        pixel = 0;
        ++sample;
      }
      if (groups.isFull()) {
        run();
        w.begin(size, StageKind::CameraPaths);
      }
    }
    if (n && !frame_.isCutShort_) run();
  }

 private:
  Frame& frame_;
};

std::vector<std::pair<int, int>> Frame::passes(int first, int last, int most) {
  std::vector<std::pair<int, int>> r;
  int a = first;
  while (a < last) {
    // ends on powers of two while small, so that snapshots and adaptive decisions fall on the same counts however a
    // frame is split
    int size = a == 0 ? 1 : std::min(int(std::bit_floor(uint32_t(a))), kMostSamplesOfPass);
    while (most > 0 && size > most) size /= 2;
    const int b = std::min(last, (a / size + 1) * size);
    r.emplace_back(a, b);
    a = b;
  }
  return r;
}

int Frame::passSamplesOf(const Descriptor& integrator, const void* data) {
  const auto* traits = static_cast<const IntegratorTraits*>(integrator.traits);
  RecordList lists[16];
  if (!traits || !traits->lists || !traits->lists(data, lists, 16)) return 0;
  return int(std::bit_floor(std::min(traits->passSamples, uint32_t(kMostSamplesOfPass))));
}

Frame::Frame(const FrameInput& input) : in_(input), times_(std::make_unique<Times>()) {
  functions_ = static_cast<const IntegratorFunctions*>(functionsFor(*in_.integrator, in_.world->width()));
  Stage list[16];
  uint32_t count = 0;
  if (const auto* traits = static_cast<const IntegratorTraits*>(in_.integrator->traits); traits && traits->stages)
    count = std::min(traits->stages(in_.integratorData, list, 16), 16u);
  stages_.assign(list, list + count);
  if (stages_.empty()) stages_.push_back({StageKind::CameraPaths, 0});
  RecordList lists[16];
  count = 0;
  if (const auto* traits = static_cast<const IntegratorTraits*>(in_.integrator->traits); traits && traits->lists)
    count = std::min(traits->lists(in_.integratorData, lists, 16), 16u);
  if (count || (functions_->commit && stages_.size() > 1))
    store_ =
        std::make_unique<PassStore>(std::vector<RecordList>(lists, lists + count), size_t(std::max(1, in_.threads)));
  const CameraState& camera = in_.world->camera();
  for (const Stage& s : stages_)
    if (s.kind == StageKind::LightPaths) lightPathsPerSample_ += pathsOf(s);
  in_.groupSize = std::clamp<uint32_t>(in_.groupSize / 16 * 16, 16, 8192);

  // passes of one sample fill groups from four times the area
  if (passSamplesOf(*in_.integrator, in_.integratorData) == 1) bucketSide_ *= 2;
  const int side = bucketSide_;
  const auto& win = camera.window;
  const int x0 = win[0] / side, x1 = (win[2] + side - 1) / side, y0 = win[1] / side, y1 = (win[3] + side - 1) / side;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) buckets_.push_back({x * side, y * side});
  const std::string& order = in_.bucketOrder;
  const auto center = [&](const Bucket& b) {
    const double dx = b.x + side / 2 - 0.5 * (win[0] + win[2]), dy = b.y + side / 2 - 0.5 * (win[1] + win[3]);
    return dx * dx + dy * dy;
  };
  if (order == "vertical") {
    std::stable_sort(buckets_.begin(), buckets_.end(), [](const Bucket& a, const Bucket& b) { return a.x < b.x; });
  } else if (order == "spiral" || order == "circle") {
    std::stable_sort(buckets_.begin(), buckets_.end(),
                     [&](const Bucket& a, const Bucket& b) { return center(a) < center(b); });
  } else if (order == "zigzag-x") {
    std::stable_sort(buckets_.begin(), buckets_.end(), [side](const Bucket& a, const Bucket& b) {
      if (a.y != b.y) return a.y < b.y;
      return (a.y / side) & 1 ? a.x > b.x : a.x < b.x;
    });
  } else if (order == "zigzag-y") {
    std::stable_sort(buckets_.begin(), buckets_.end(), [side](const Bucket& a, const Bucket& b) {
      if (a.x != b.x) return a.x < b.x;
      return (a.x / side) & 1 ? a.y > b.y : a.y < b.y;
    });
  } else if (order == "random") {
    std::stable_sort(buckets_.begin(), buckets_.end(), [](const Bucket& a, const Bucket& b) {
      return hashWords(uint32_t(a.x), uint32_t(a.y)) < hashWords(uint32_t(b.x), uint32_t(b.y));
    });
  } else if (order == "spacefill") {
    const auto morton = [side](const Bucket& b) {
      uint64_t m = 0;
      for (int i = 0; i < 16; ++i)
        m |= uint64_t(b.x / side >> i & 1) << (2 * i) | uint64_t(b.y / side >> i & 1) << (2 * i + 1);
      return m;
    };
    std::stable_sort(buckets_.begin(), buckets_.end(),
                     [&](const Bucket& a, const Bucket& b) { return morton(a) < morton(b); });
  }
  splatFilter_ = in_.jitter ? film::SplatFilter(*in_.filter) : film::SplatFilter();
  makeWorkers();
  void_.resize(workers_.size());
  bucketTimes_.resize(buckets_.size(), 0);
  times_->byWorker.resize(workers_.size(), {0, 0, 0, 0});
  rayLoop_ = std::make_unique<RayLoop>(*this);
  hider_ = in_.hider ? in_.hider : rayLoop_.get();
  makeLearned();
}

Frame::~Frame() = default;

void Frame::makeWorkers() {
  const shade::ShadingWorld& world = in_.world->world();
  workers_.clear();
  for (int t = 0; t < std::max(1, in_.threads); ++t)
    workers_.push_back(std::make_unique<Worker>(world, in_.world->camera(), *in_.plan, *in_.paths, *in_.film,
                                                splatFilter_, lightPathsPerSample_));
  for (size_t i = 0; i < workers_.size(); ++i) {
    workers_[i]->index = i;
    workers_[i]->store = store_.get();
    workers_[i]->state().listener = in_.rayListener;
    const auto* traits = static_cast<const IntegratorTraits*>(in_.integrator->traits);
    workers_[i]->scatterInMedia(traits && traits->scattersInMedia && traits->scattersInMedia(in_.integratorData));
    workers_[i]->learn(learned_.get());
  }
}

uint64_t Frame::pathsOf(const Stage& s) const {
  const CameraState& camera = in_.world->camera();
  return uint64_t(s.pathsPerSample) * uint64_t(camera.resolution[0]) * uint64_t(camera.resolution[1]);
}

void Frame::makeLearned() {
  learned_.reset();
  for (const auto& w : workers_) w->learn(nullptr);
  lessons_.clear();
  taughtTo_ = 0;
  const std::optional<Learning> wanted = learningOf(*in_.integrator, in_.integratorData);
  if (!wanted || hider_ != rayLoop_.get()) return;
  learnsAsWanted_ =
      functions_->learn && std::none_of(stages_.begin(), stages_.end() - 1, isOfCamera) && isOfCamera(stages_.back());
  if (!learnsAsWanted_) return;
  const CameraState& camera = in_.world->camera();
  const Services& services = workers_[0]->services();
  LearnedState::Input input;
  input.wanted = *wanted;
  input.learn = functions_->learn;
  input.integrator = in_.integratorData;
  for (int c = 0; c < 3; ++c) input.worldCenter[c] = services.worldCenter[c];
  input.worldRadius = services.worldRadius;
  for (int c = 0; c < 2; ++c) input.resolution[c] = camera.resolution[size_t(c)];
  input.seed = in_.seed;
  input.threads = int(workers_.size());
  learned_ = std::make_unique<LearnedState>(input);
  for (const auto& w : workers_) w->learn(learned_.get());
}

bool Frame::parallel(const std::function<bool(size_t worker)>& next) {
  std::atomic<bool> stopped{false};
  const auto body = [&](size_t t) {
    setThreadFloatMode();
    while (next(t)) {
      if (isCutShort_ || (in_.stop && in_.stop->load(std::memory_order_relaxed))) {
        stopped = true;
        break;
      }
      // endStage() and endEpoch() say so
      if ((store_ && store_->isRefused()) || (learned_ && learned_->isRefused())) break;
    }
  };
  if (workers_.size() == 1) {
    body(0);
  } else {
    tbb::task_arena arena(int(workers_.size()));
    arena.execute([&] { tbb::parallel_for(size_t(0), workers_.size(), body, tbb::simple_partitioner()); });
  }
  return !stopped;
}

Frame::Groups::Groups(const Frame& frame, uint64_t item, uint32_t blocks)
    : frame_(frame), item_(item), blocks_(blocks), again_(frame.again_.begin()) {
  if (frame.isAgain_) again_ = std::lower_bound(frame.again_.begin(), frame.again_.end(), Void{item, 0, 0, {}});
}

bool Frame::Groups::next() {
  const uint32_t block = at_++;
  if (!frame_.isAgain_) {
    first_ = block / blocks_ * blocks_;
    last_ = first_ + blocks_;
    return true;
  }
  while (again_ != frame_.again_.end() && again_->item == item_ && again_->last <= block) ++again_;
  if (again_ == frame_.again_.end() || again_->item != item_ || again_->first > block) return false;
  first_ = again_->first;
  last_ = again_->last;
  return true;
}

bool Frame::keep(Worker& w, uint64_t item, uint32_t first, uint32_t last) {
  const bool isKept = w.keepTry();
  if (trace::GeometryCache::wasCutShort()) {
    isCutShort_ = true;
    return false;
  }
  if (isKept) return true;
  void_[w.index].push_back({item, first, last, {w.metUnread(), {}, last - first < 2}});
  return false;
}

bool Frame::readMet(std::vector<WaitingGroup*>& groups) {
  if (in_.statistics) addWorkers(*in_.statistics);
  for (auto& t : times_->byWorker) t = {0, 0, 0, 0};
  workers_.clear();  // they point into the world that goes
  if (!in_.readMet || !in_.readMet(groups)) return false;
  makeWorkers();
  return true;
}

// Of a group that is tried alone.
bool Frame::readMet(WaitingGroup& group, const Worker& w) {
  group.met = w.metUnread();
  std::vector<WaitingGroup*> alone{&group};
  return readMet(alone);
}

bool Frame::forEachItem(uint64_t items, const std::function<void(Worker& w, uint64_t item)>& run) {
  std::vector<uint64_t> list;
  std::vector<Void> waiting;  // in order; their turn has not come
  bool isDone = true;
  isAgain_ = false;
  again_.clear();
  for (;;) {
    std::atomic<uint64_t> next{0};
    const uint64_t count = isAgain_ ? list.size() : items;
    isDone = parallel([&](size_t t) {
      const uint64_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= count) return false;
      run(*workers_[t], isAgain_ ? list[i] : i);
      return true;
    });
    for (std::vector<Void>& all : void_) {
      for (Void& v : all) {
        // what a group met in earlier tries it still needs
        if (const auto it = std::lower_bound(again_.begin(), again_.end(), v); it != again_.end() && !(v < *it))
          v.waiting.needs = std::move(it->waiting.needs);
        waiting.push_back(std::move(v));
      }
      all.clear();
    }
    again_.clear();
    if (!isDone || waiting.empty()) break;
    std::sort(waiting.begin(), waiting.end());
    std::vector<WaitingGroup*> groups;
    for (Void& v : waiting) groups.push_back(&v.waiting);
    if (!(isDone = readMet(groups))) break;
    std::vector<Void> later;
    for (Void& v : waiting) {
      const uint32_t middle = v.first + (v.last - v.first) / 2;
      if (v.waiting.turn == WaitingGroup::Turn::Later) {
        v.waiting.met.clear();
        later.push_back(std::move(v));
      } else if (v.waiting.turn == WaitingGroup::Turn::Halves) {
        again_.push_back({v.item, v.first, middle, {}});
        again_.push_back({v.item, middle, v.last, {}});
      } else {
        again_.push_back(std::move(v));
      }
    }
    waiting = std::move(later);
    list.clear();
    for (const Void& v : again_)
      if (list.empty() || list.back() != v.item) list.push_back(v.item);
    isAgain_ = true;
  }
  isAgain_ = false;
  again_.clear();
  for (std::vector<Void>& all : void_) all.clear();
  return isDone;
}

// Ends all epochs before that of `sample`; lessons that passes left out are followed first.
bool Frame::learnUpTo(int sample) {
  const int wanted = std::min(LearnedState::endOfEpoch(sample) / 2, learned_->samples());
  while (learned_->epochLast() <= wanted) {
    const int last = learned_->epochLast();
    if (taughtTo_ < last) {
      lessons_.push_back({taughtTo_, last, {}});
      taughtTo_ = last;
    }
    for (const Lesson& l : lessons_)
      if (!teach(l)) return false;
    lessons_.clear();
    learned_->endEpoch();
  }
  return true;
}

// Follows the paths of a lesson; they leave nothing in the picture, and find nothing of earlier stages: what they teach
// does not depend on it.
bool Frame::teach(const Lesson& lesson) {
  constexpr int kTile = 64;
  const auto& resolution = in_.world->camera().resolution;
  const int columns = (resolution[0] + kTile - 1) / kTile, rows = (resolution[1] + kTile - 1) / kTile;
  const auto stage = uint32_t(stages_.size() - 1);
  if (store_) {
    store_->beginPass();
    store_->beginStage(stage);
  }
  teaches_ = true;
  const bool isDone = forEachItem(uint64_t(columns) * uint64_t(rows), [&](Worker& w, uint64_t item) {
    const int left = int(item) % columns * kTile, top = int(item) / columns * kTile;
    shade::GroupState& s = w.state();
    uint32_t n = 0;
    Groups groups(*this, item, in_.groupSize / kPathsOfBlock);
    const auto run = [&] {
      w.beginTry();
      cameraGroup(w, n, stage);
      keep(w, item, groups.first(), groups.last());
      n = 0;
    };
    w.begin(in_.groupSize, StageKind::CameraPaths);
    for (int sample = lesson.first; sample < lesson.last; ++sample)
      for (int y0 = top; y0 < top + kTile; y0 += kBlock)
        for (int x0 = left; x0 < left + kTile; x0 += kBlock) {
          if (!learned_->teaches(x0, y0, sample)) continue;
          const ActivePixels::Mask done = lesson.done ? lesson.done->activeIn(x0, y0) : ActivePixels::Mask(0);
          if (done == ActivePixels::kAll) continue;
          if (isCutShort_ || !groups.next()) continue;
          ActivePixels::forEach(ActivePixels::Mask(~done), x0, y0,
                                [&](int x, int y) { addPath(s, x, y, sample, n); });
          if (groups.isFull()) {
            run();
            w.begin(in_.groupSize, StageKind::CameraPaths);
          }
        }
    if (n && !isCutShort_) run();
  });
  teaches_ = false;
  return isDone;
}

bool Frame::pass(int first, int last) {
  while (learned_ && first < last) {
    const int epoch = LearnedState::endOfEpoch(first);
    if (learned_->epochFirst() > epoch / 2) makeLearned();  // a frame that starts again
    if (!learnUpTo(first)) return false;
    if (first >= learned_->samples()) break;
    // one state for all samples of an epoch
    const int end = std::min(last, epoch);
    if (taughtTo_ < first) lessons_.push_back({taughtTo_, first, {}});
    const bool isNew = taughtTo_ <= first;
    teaches_ = isNew;
    const bool isDone = renderPass(first, end);
    teaches_ = false;
    if (!isDone) return false;
    if (isNew) {
      const auto& win = in_.world->camera().window;
      lessons_.push_back(
          {first, end, in_.active ? *in_.active : ActivePixels(image::Window{win[0], win[1], win[2], win[3]})});
      taughtTo_ = end;
    }
    first = end;
  }
  return first >= last || renderPass(first, last);
}

bool Frame::renderPass(int first, int last) {
  bool stopped = false;
  if (store_) store_->beginPass();
  for (uint32_t s = 0; s < stages_.size() && !stopped; ++s) {
    if (store_) store_->beginStage(s);
    if (stages_[s].kind == StageKind::CameraPaths) {
      stopped = !forEachItem(buckets_.size(), [&](Worker& w, uint64_t i) {
        const Bucket& b = buckets_[i];
        const int x1 = b.x + bucketSide_, y1 = b.y + bucketSide_;
        if (in_.active && !in_.active->anyIn(b.x, b.y, x1, y1)) return;
        const uint64_t begin = now();
        hider_->fill(w, {b.x, b.y, x1, y1, first, last, s, in_.seed, &in_.world->camera(), in_.active, i},
                     [this, &w](uint32_t count) { retire(w, count); });
        bucketTimes_[i] += now() - begin;
      });
    } else if (stages_[s].kind == StageKind::LightPaths) {
      const uint64_t paths = pathsOf(stages_[s]);
      const uint64_t perItem = in_.groupSize;
      const uint64_t items = (paths + perItem - 1) / perItem;
      stopped = !forEachItem(items * uint64_t(last - first), [&](Worker& w, uint64_t i) {
        const uint64_t from = (i % items) * perItem, to = std::min(from + perItem, paths);
        Groups groups(*this, i, in_.groupSize / kPathsOfBlock);
        for (uint64_t block = from; block < to && !isCutShort_; block += kPathsOfBlock) {
          if (!groups.next() || !(groups.isFull() || block + kPathsOfBlock >= to)) continue;
          const uint64_t begin = from + groups.first() * kPathsOfBlock;
          w.beginTry();
          lightPaths(w, begin, uint32_t(std::min(block + kPathsOfBlock, to) - begin), first + int(i / items), s);
          keep(w, i, groups.first(), groups.last());
        }
      });
    }
    if (store_ && !stopped) endStage(s, first, last);
  }
  if (lightPathsPerSample_ && !stopped) in_.film->addSplatPasses(last - first);
  return !stopped;
}

void Frame::endStage(uint32_t stage, int first, int last) {
  store_->endStage(in_.threads);
  if (!functions_->commit) return;
  struct Host {
    PassStore& store;
    int threads;
    std::exception_ptr failed;  // must not cross the plug-in
    static Host& of(const CommitServices* s) { return *static_cast<Host*>(s->host); }
  } host{*store_, in_.threads, nullptr};
  CommitServices c{};
  c.host = &host;
  c.firstSample = uint32_t(first);
  c.lastSample = uint32_t(last);
  c.stored = [](const CommitServices* s, uint32_t list) { return Host::of(s).store.stored(list); };
  c.allocate = [](const CommitServices* s, uint64_t bytes) -> void* {
    try {
      return Host::of(s).store.allocate(bytes);
    } catch (...) {
      Host::of(s).failed = std::current_exception();
      return nullptr;
    }
  };
  c.parallelFor = [](const CommitServices* s, uint64_t n, void* context, void (*body)(void*, uint64_t)) {
    tbb::task_arena arena(std::max(1, Host::of(s).threads));
    arena.execute([&] { tbb::parallel_for(uint64_t(0), n, [&](uint64_t i) { body(context, i); }); });
  };
  c.setIndex = [](const CommitServices* s, const void* index) { Host::of(s).store.setIndex(index); };
  functions_->commit(in_.integratorData, stage, &c);
  if (host.failed) std::rethrow_exception(host.failed);
}

uint64_t Frame::foreseenRecords(int sample) {
  if (!store_) return 0;
  constexpr uint64_t kTogether = 64, kLeast = 4096;  // paths in a row; in all
  Worker& w = *workers_[0];
  const struct Forgetting {
    PassStore& store;
    uint64_t most;
    ~Forgetting() { store.forget(most); }
  } forgetting{*store_, store_->mostBytes()};
  store_->beginPass();
  uint64_t all = 0;
  for (uint32_t s = 0; s < stages_.size() && stages_[s].kind == StageKind::LightPaths; ++s) {
    store_->beginStage(s);
    const uint64_t paths = pathsOf(stages_[s]), step = std::clamp<uint64_t>(paths / kLeast, 1, 16);
    for (uint64_t from = 0; from < paths; from += kTogether * step) {
      w.beginLook();
      lightPaths(w, from, uint32_t(std::min(kTogether, paths - from)), sample, s);
      w.endLook();
    }
    endStage(s, sample, sample + 1);
    all += store_->foreseenBytes() * step + paths * sizeof(uint64_t);
  }
  return all;
}

uint64_t Frame::arenaBytes() const {
  uint64_t n = 0;
  for (const auto& w : workers_) n += w->state().arena().bytes();
  return n;
}

void Frame::addTo(Statistics& st) const {
  if (st.firstGroupSeconds < 0) st.firstGroupSeconds = firstGroupAge_;
  st.buckets.clear();
  for (size_t i = 0; i < buckets_.size(); ++i)
    st.buckets.push_back({buckets_[i].x, buckets_[i].y, bucketSide_, bucketTimes_[i]});
  addWorkers(st);
}

void Frame::addWorkers(Statistics& st) const {
  for (size_t i = 0; i < workers_.size(); ++i) {
    const shade::GroupCounters& c = workers_[i]->state().counters;
    st.cameraRays += c.cameraRays;
    st.indirectRays += c.indirectRays;
    st.shadowRays += c.shadowRays;
    st.cameraHits += c.cameraHits;
    st.indirectHits += c.indirectHits;
    st.endlessRays += c.endlessRays;
    st.mediaRays += c.mediaRays;
    st.mediaLookups += c.mediaLookups;
    st.endlessTracks += c.endlessTracks;
    st.mediaOverflows += c.mediaOverflows;
    if (c.excess > st.mediaExcess) {
      st.mediaExcess = c.excess;
      st.excessMedium = workers_[i]->state().world().space->media[c.excessMedium].name;
    }
    for (size_t k = 0; k < st.lostBelow.size(); ++k) {
      st.lostBelow[k] += c.lostBelow[k];
      if (c.lostPlacement[k] != ~0u && (!st.lostPlacement[k] || *st.lostPlacement[k] > c.lostPlacement[k])) {
        st.lostPlacement[k] = c.lostPlacement[k];
        st.lostObject[k] = workers_[i]->state().world().placementName(c.lostPlacement[k]);
      }
    }
    const auto addLanes = [](LaneUse& to, const shade::LaneCounts& from) {
      to.active += from.active;
      to.possible += from.possible;
      to.groups += from.contexts;
    };
    static_assert(std::tuple_size_v<decltype(st.lanesAt)> == shade::GroupCounters::kLaneDepths);
    for (size_t k = 0; k < st.lanesAt.size(); ++k) {
      addLanes(st.lanesAt[k], c.lanes[k]);
      st.shadingPoints += c.lanes[k].active;
      st.shadingGroups += c.lanes[k].contexts;
    }
    addLanes(st.lanesQueries, c.queries);
    addLanes(st.lanesWalks, c.walks);
    st.walksBegun += c.walksBegun;
    st.walksFound += c.walksFound;
    st.walkTrials += c.walkTrials;
    const std::vector<shade::ShaderCounts>& shaders = workers_[i]->state().shaderCounts;
    for (size_t k = 0; k < shaders.size() && k < st.shaders.size(); ++k) {
      const language::RunCounts& n = shaders[k].machine;
      ShaderCost& cost = st.shaders[k];
      cost.runs += n.runs;
      cost.points += n.points;
      cost.nanoseconds += shaders[k].nanoseconds;
      cost.countedRuns += n.counted;
      cost.instructions += n.instructions;
      cost.uniformInstructions += n.uniform;
      cost.lanes.active += n.lanesUsed;
      cost.lanes.possible += n.lanesRun;
    }
    st.lightRays += workers_[i]->lightRays;
    for (size_t k = 0; k < size_t(StageTime::Count); ++k) st.stageNanoseconds[k] += c.nanoseconds[k];
    const auto& t = times_->byWorker[i];
    uint64_t inside = 0;
    for (size_t k = 0; k < size_t(StageTime::Count); ++k) inside += c.nanoseconds[k];
    st.stageNanoseconds[size_t(StageTime::CameraRays)] += t[0];
    st.stageNanoseconds[size_t(StageTime::Integrator)] += t[1] > inside ? t[1] - inside : 0;
    st.stageNanoseconds[size_t(StageTime::Film)] += t[2];
    st.groups += t[3];
  }
}

}  // namespace kinora::render
