#include "render/pass_store.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>

namespace kinora::render {

PassStore::PassStore(std::vector<RecordList> lists, size_t workers)
    : lists_(std::move(lists)), parts_(lists_.size()), sorted_(lists_.size()) {
  for (std::vector<Part>& p : parts_) p.resize(workers);
}

void PassStore::beginPass() {
  // the memory stays for the records of this pass, which will be about as many
  for (std::vector<Part>& parts : parts_)
    for (Part& p : parts) p.clear();
  for (Sorted& s : sorted_) s.count = 0;
  blocks_.clear();
  made_ = 0;
  index_ = nullptr;
  refused_ = false;
  held_.set(bytes());
}

void PassStore::forget(uint64_t most) {
  for (std::vector<Part>& parts : parts_)
    for (Part& p : parts) p = Part();
  for (Sorted& s : sorted_) s = Sorted();
  mostBytes_ = most;
  beginPass();
}

uint64_t PassStore::bytes() const {
  uint64_t all = 0;
  for (size_t l = 0; l < lists_.size(); ++l) {
    all += sorted_[l].records.capacity() + sorted_[l].ends.capacity() * sizeof(uint64_t);
    for (const Part& p : parts_[l]) all += p.addresses.capacity() * (sizeof(Address) + lists_[l].bytes);
  }
  return all;
}

bool PassStore::grow(Part& part, size_t n, size_t bytes) {
  const size_t records = part.addresses.size() + n;
  if (records <= part.addresses.capacity()) return true;
  const size_t room = std::max(records, 2 * part.addresses.capacity());
  const size_t more = (room - part.addresses.capacity()) * (sizeof(Address) + bytes);
  try {
    held_.add(more);
    part.addresses.reserve(room);
    part.records.reserve(room * bytes);
  } catch (const std::bad_alloc&) {
    refused_ = true;
    return false;
  }
  return true;
}

void PassStore::append(size_t worker, uint32_t list, uint32_t n, const uint32_t* slots, const uint64_t* path,
                       const uint32_t* sample, const void* records) {
  if (list >= lists_.size() || lists_[list].stage != stage_) {
    dropped_ += n;
    return;
  }
  const size_t bytes = lists_[list].bytes;
  Part& part = parts_[list][worker];
  if (refused_ || !grow(part, n, bytes)) return;
  for (uint32_t i = 0; i < n; ++i) part.addresses.push_back({path[slots[i]], sample[slots[i]]});
  const auto* from = static_cast<const std::byte*>(records);
  part.records.insert(part.records.end(), from, from + size_t(n) * bytes);
}

void PassStore::mark(size_t worker, std::vector<size_t>& counts) const {
  counts.resize(lists_.size());
  for (size_t l = 0; l < lists_.size(); ++l) counts[l] = parts_[l][worker].addresses.size();
}

void PassStore::cut(size_t worker, const std::vector<size_t>& counts) {
  for (size_t l = 0; l < lists_.size(); ++l) {
    Part& part = parts_[l][worker];
    part.addresses.resize(counts[l]);
    part.records.resize(counts[l] * lists_[l].bytes);
  }
}

void PassStore::endStage(int threads) {
  if (refused_) {
    forget(mostBytes_);
    throw MemoryExceeded("the records that the integrator keeps between stages do not fit; " + Memory::largest());
  }
  tbb::task_arena arena(std::max(1, threads));
  for (size_t l = 0; l < lists_.size(); ++l) {
    if (lists_[l].stage != stage_) continue;
    std::vector<Part>& parts = parts_[l];
    const size_t bytes = lists_[l].bytes;
    Sorted& s = sorted_[l];
    uint32_t lastSample = 0;
    s.count = 0;
    s.firstSample = ~0u;
    s.paths = 0;
    for (const Part& p : parts) {
      s.count += p.addresses.size();
      for (const Address& a : p.addresses) {
        s.firstSample = std::min(s.firstSample, a.sample);
        lastSample = std::max(lastSample, a.sample);
        s.paths = std::max(s.paths, a.path + 1);
      }
    }
    s.samples = s.count ? lastSample - s.firstSample + 1 : 0;
    const size_t places = size_t(s.samples * s.paths);
    held_.add(std::max(s.count * bytes, s.records.capacity()) - s.records.capacity() +
              (std::max(places, s.ends.capacity()) - s.ends.capacity()) * sizeof(uint64_t));
    s.records.resize(std::max(s.count * bytes, s.records.size()));
    s.ends.assign(places, 0);
    // no two workers have records of the same path
    const auto forEachPart = [&](const auto& body) {
      arena.execute([&] { tbb::parallel_for(size_t(0), parts.size(), [&](size_t i) { body(parts[i]); }); });
    };
    forEachPart([&](const Part& p) {
      for (const Address& a : p.addresses) ++s.ends[s.placeOf(a)];
    });
    uint64_t sum = 0;
    for (uint64_t& end : s.ends) {
      const uint64_t n = end;
      end = sum;  // where the first goes, until all are there
      sum += n;
    }
    forEachPart([&](const Part& p) {
      for (size_t i = 0; i < p.addresses.size(); ++i)
        std::memcpy(s.records.data() + s.ends[s.placeOf(p.addresses[i])]++ * bytes, p.records.data() + i * bytes,
                    bytes);
    });
    for (Part& p : parts_[l]) p.clear();
  }
  held_.set(bytes());
  noteMost();
}

uint64_t PassStore::foreseenBytes() const {
  uint64_t all = made_;
  // parts grow by doubling, until the records are sorted
  for (size_t l = 0; l < lists_.size(); ++l)
    all += sorted_[l].count * (2 * (sizeof(Address) + lists_[l].bytes) + lists_[l].bytes);
  return all;
}

void PassStore::noteMost() { mostBytes_ = std::max(mostBytes_, bytes() + made_); }

StoredRecords PassStore::stored(uint32_t list) const {
  if (list >= sorted_.size()) return {};
  return {sorted_[list].count, sorted_[list].count ? sorted_[list].records.data() : nullptr};
}

void PassStore::find(uint32_t list, uint32_t n, const uint64_t* paths, const uint32_t* samples, uint64_t* first,
                     uint32_t* count) const {
  for (uint32_t i = 0; i < n; ++i) {
    first[i] = 0;
    count[i] = 0;
    if (list >= sorted_.size()) continue;
    const Sorted& s = sorted_[list];
    if (!s.count || samples[i] < s.firstSample || samples[i] - s.firstSample >= s.samples || paths[i] >= s.paths)
      continue;
    const size_t place = s.placeOf({paths[i], samples[i]});
    first[i] = place ? s.ends[place - 1] : 0;
    count[i] = uint32_t(s.ends[place] - first[i]);
  }
}

void* PassStore::allocate(uint64_t bytes) {
  constexpr uint64_t kAlign = 64;
  if (bytes > UINT64_MAX / 2) throw MemoryExceeded("the index that the integrator makes of its records does not fit");
  held_.add(bytes + kAlign);
  blocks_.push_back(std::make_unique<std::byte[]>(bytes + kAlign));
  made_ += bytes + kAlign;
  noteMost();
  const uintptr_t at = reinterpret_cast<uintptr_t>(blocks_.back().get());
  return reinterpret_cast<void*>((at + kAlign - 1) / kAlign * kAlign);
}

}  // namespace kinora::render
