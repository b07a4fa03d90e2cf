#include "render/learned_state.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <exception>

#include "light/light_tree.h"
#include "render/adaptive.h"

namespace kinora::render {

namespace {

constexpr uint64_t kAlign = 64;
constexpr uintptr_t kLargePage = 2 << 20;

}  // namespace

void* LearnedState::Block::data() const {
  return reinterpret_cast<void*>((reinterpret_cast<uintptr_t>(memory.get()) + kAlign - 1) / kAlign * kAlign);
}

LearnedState::Block LearnedState::makeBlock(uint64_t bytes) {
  if (bytes > UINT64_MAX / 2) throw MemoryExceeded("what the integrator learns does not fit");
  held_.add(bytes + kAlign);
  Block b{std::make_unique_for_overwrite<std::byte[]>(bytes + kAlign), bytes};
  // lanes look up places all over it
  const auto begin = reinterpret_cast<uintptr_t>(b.memory.get()), end = begin + bytes;
  if (const uintptr_t page = (begin + kLargePage - 1) / kLargePage * kLargePage; page < end)
    light::useLargePages(reinterpret_cast<void*>(page), end - page);
  std::memset(b.memory.get(), 0, bytes + kAlign);
  mostBytes_ = std::max(mostBytes_, held_.bytes());
  return b;
}

LearnedState::LearnedState(const Input& input)
    : in_(input), samples_(int(std::bit_floor(std::min(input.wanted.samples, 1u << 16)))) {
  parts_.resize(size_t(std::max(1, in_.threads)));
  // one rate for an epoch: of more samples each teaches less
  epochLast_ = 0;
  forget();
}

// Readies the next epoch.
void LearnedState::forget() {
  epochLast_ = epochLast_ ? 2 * epochLast_ : 1;
  const uint64_t pixels = uint64_t(std::max(1, in_.resolution[0])) * uint64_t(std::max(1, in_.resolution[1]));
  const uint64_t paths = pixels * uint64_t(std::max(1, epochLast_ / 2));
  rate_ = std::min<uint64_t>(uint64_t(1) << 32, (uint64_t(in_.wanted.paths) << 32) / paths);
  for (Part& p : parts_) {
    p.addresses.clear();
    p.records.clear();
  }
}

int LearnedState::endOfEpoch(int sample) { return sample < 1 ? 1 : int(2 * std::bit_floor(unsigned(sample))); }

bool LearnedState::teaches(int x, int y, int sample) const {
  if (x < 0 || y < 0 || x >= in_.resolution[0] || y >= in_.resolution[1] || sample >= samples_) return false;
  const uint32_t block = pixelSeed(x / ActivePixels::kSide, y / ActivePixels::kSide, in_.seed);
  return hashWords(block ^ 0x6b43a9b5u, uint32_t(sample)) < rate_;
}

void LearnedState::add(size_t worker, uint32_t n, const uint32_t* slots, const uint64_t* path, const uint32_t* sample,
                       const void* records) {
  Part& part = parts_[worker];
  if (refused_.load(std::memory_order_relaxed)) return;
  const size_t bytes = in_.wanted.recordBytes, count = part.addresses.size() + n;
  if (count > part.addresses.capacity()) {
    const size_t room = std::max(count, 2 * part.addresses.capacity());
    try {
      held_.add((room - part.addresses.capacity()) * (sizeof(Address) + bytes));
      part.addresses.reserve(room);
      part.records.reserve(room * bytes);
    } catch (const std::bad_alloc&) {
      refused_ = true;
      return;
    }
  }
  for (uint32_t i = 0; i < n; ++i) part.addresses.push_back({path[slots[i]], sample[slots[i]]});
  const auto* from = static_cast<const std::byte*>(records);
  part.records.insert(part.records.end(), from, from + size_t(n) * bytes);
}

struct LearnedState::Host {
  LearnedState& of;
  std::vector<Block> scratch;
  std::optional<Block> next;
  std::exception_ptr failed;  // must not cross the plug-in
  static Host& from(const LearnServices* s) { return *static_cast<Host*>(s->host); }
  template <class F>
  void* guarded(F&& make) {
    try {
      return make();
    } catch (...) {
      failed = std::current_exception();
      return nullptr;
    }
  }
};

void LearnedState::endEpoch() {
  const auto kept = [this] {
    uint64_t n = stateBytes() + (state_ ? kAlign : 0);
    for (const Part& p : parts_) n += p.addresses.capacity() * (sizeof(Address) + in_.wanted.recordBytes);
    return n;
  };
  if (refused_) {
    parts_.assign(parts_.size(), Part());
    held_.set(kept());
    throw MemoryExceeded("what paths leave to be learned from does not fit; " + Memory::largest());
  }
  tbb::task_arena arena(std::max(1, in_.threads));
  const size_t bytes = in_.wanted.recordBytes;
  size_t count = 0;
  for (const Part& p : parts_) count += p.addresses.size();
  struct Place {
    uint64_t path;
    uint32_t sample, part;
    size_t index;
  };
  Host host{*this, {}, {}, nullptr};
  host.scratch.push_back(makeBlock(count * sizeof(Place)));
  host.scratch.push_back(makeBlock(count * bytes));
  Place* places = static_cast<Place*>(host.scratch[0].data());
  std::byte* sorted = static_cast<std::byte*>(host.scratch[1].data());
  size_t n = 0;
  for (uint32_t k = 0; k < parts_.size(); ++k)
    for (size_t i = 0; i < parts_[k].addresses.size(); ++i)
      places[n++] = {parts_[k].addresses[i].path, parts_[k].addresses[i].sample, k, i};
  arena.execute([&] {
    // no two workers have records of one path
    tbb::parallel_sort(places, places + count, [](const Place& a, const Place& b) {
      if (a.sample != b.sample) return a.sample < b.sample;
      return a.path != b.path ? a.path < b.path : a.index < b.index;
    });
    tbb::parallel_for(size_t(0), (count + 4095) / 4096, [&](size_t chunk) {
      for (size_t i = chunk * 4096; i < std::min(count, (chunk + 1) * 4096); ++i)
        std::memcpy(sorted + i * bytes, parts_[places[i].part].records.data() + places[i].index * bytes, bytes);
    });
  });
  LearnServices s{};
  s.host = &host;
  s.firstSample = uint32_t(epochFirst());
  s.lastSample = uint32_t(epochLast());
  for (int c = 0; c < 3; ++c) s.worldCenter[c] = in_.worldCenter[c];
  s.worldRadius = in_.worldRadius;
  s.records = {count, count ? sorted : nullptr};
  s.state = state();
  s.stateBytes = stateBytes();
  s.makeState = [](const LearnServices* l, uint64_t size) -> void* {
    Host& h = Host::from(l);
    return h.guarded([&] {
      h.next.reset();
      h.next = h.of.makeBlock(size);
      return h.next->data();
    });
  };
  s.allocate = [](const LearnServices* l, uint64_t size) -> void* {
    Host& h = Host::from(l);
    return h.guarded([&] {
      h.scratch.push_back(h.of.makeBlock(size));
      return h.scratch.back().data();
    });
  };
  s.parallelFor = [](const LearnServices* l, uint64_t k, void* context, void (*body)(void*, uint64_t)) {
    tbb::task_arena threads(std::max(1, Host::from(l).of.in_.threads));
    threads.execute([&] { tbb::parallel_for(uint64_t(0), k, [&](uint64_t i) { body(context, i); }); });
  };
  in_.learn(in_.integrator, &s);
  if (host.next) state_ = std::move(host.next);
  recordCount_ += count;
  host.scratch.clear();
  forget();
  if (epochFirst() >= samples_) parts_.assign(parts_.size(), Part());  // nothing more is learned
  held_.set(kept());
  if (host.failed) std::rethrow_exception(host.failed);
}

}  // namespace kinora::render
