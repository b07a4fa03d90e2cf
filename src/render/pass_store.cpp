#include "render/pass_store.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
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
  index_ = nullptr;
  refused_ = false;
  held_.set(bytes());
}

uint64_t PassStore::bytes() const {
  uint64_t all = 0;
  for (size_t l = 0; l < lists_.size(); ++l) {
    const uint64_t one = sizeof(Address) + lists_[l].bytes;
    all += sorted_[l].addresses.capacity() * one;
    for (const Part& p : parts_[l]) all += p.addresses.capacity() * one;
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
  for (uint32_t i = 0; i < n; ++i)
    part.addresses.push_back({path[slots[i]], sample[slots[i]], uint32_t(part.addresses.size())});
  const auto* from = static_cast<const std::byte*>(records);
  part.records.insert(part.records.end(), from, from + size_t(n) * bytes);
}

void PassStore::endStage(int threads) {
  if (refused_) {
    for (std::vector<Part>& parts : parts_)
      for (Part& p : parts) p = Part();
    for (Sorted& s : sorted_) s = Sorted();
    held_.set(0);
    throw MemoryExceeded("the records that the integrator keeps between stages do not fit; " + Memory::largest());
  }
  tbb::task_arena arena(std::max(1, threads));
  for (size_t l = 0; l < lists_.size(); ++l) {
    if (lists_[l].stage != stage_) continue;
    size_t count = 0;
    for (const Part& p : parts_[l]) count += p.addresses.size();
    const size_t bytes = lists_[l].bytes;
    struct Entry {
      Address address;
      const std::byte* record;
    };
    Sorted& s = sorted_[l];
    const size_t more = std::max(count, s.addresses.capacity()) - s.addresses.capacity();
    held_.add(count * sizeof(Entry) + more * (sizeof(Address) + bytes));
    std::vector<Entry> entries;
    entries.reserve(count);
    for (const Part& p : parts_[l])
      for (size_t i = 0; i < p.addresses.size(); ++i)
        entries.push_back({p.addresses[i], p.records.data() + i * bytes});
    s.count = count;
    if (more) {
      s.addresses.resize(count);
      s.records.resize(count * bytes);
    }
    arena.execute([&] {
      // a path is one worker's, so no two entries are equal and the order is the same however many threads there were
      tbb::parallel_sort(entries.begin(), entries.end(),
                         [](const Entry& a, const Entry& b) { return a.address < b.address; });
      tbb::parallel_for(size_t(0), count, [&](size_t i) {
        s.addresses[i] = entries[i].address;
        std::memcpy(s.records.data() + i * bytes, entries[i].record, bytes);
      });
    });
    for (Part& p : parts_[l]) p.clear();
  }
  held_.set(bytes());
}

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
    const std::vector<Address>& all = sorted_[list].addresses;
    const auto end = all.begin() + ptrdiff_t(sorted_[list].count);
    const auto from = std::lower_bound(all.begin(), end, Address{paths[i], samples[i], 0});
    auto to = from;
    while (to != end && to->path == paths[i] && to->sample == samples[i]) ++to;
    first[i] = uint64_t(from - all.begin());
    count[i] = uint32_t(to - from);
  }
}

void* PassStore::allocate(uint64_t bytes) {
  constexpr uint64_t kAlign = 64;
  if (bytes > UINT64_MAX / 2) throw MemoryExceeded("the index that the integrator makes of its records does not fit");
  held_.add(bytes + kAlign);
  blocks_.push_back(std::make_unique<std::byte[]>(bytes + kAlign));
  const uintptr_t at = reinterpret_cast<uintptr_t>(blocks_.back().get());
  return reinterpret_cast<void*>((at + kAlign - 1) / kAlign * kAlign);
}

}  // namespace kinora::render
