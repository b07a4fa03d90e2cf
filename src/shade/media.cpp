#include "shade/media.h"

#include <cstring>

namespace kinora::shade {
namespace {

uint64_t hashOf(const Medium& m) {
  uint32_t words[sizeof(Medium) / 4];
  static_assert(sizeof words == sizeof(Medium));
  std::memcpy(words, &m, sizeof m);
  uint64_t h = 0x9E3779B97F4A7C15u;
  for (const uint32_t w : words) h = (h ^ w) * 0xff51afd7ed558ccdu ^ (h >> 29);
  return h ^ (h >> 32);
}

}  // namespace

uint32_t MediaArchive::keep(const MediaPool& pool, uint32_t stack) {
  if (!stack) return MediaPool::kEmpty;
  Medium m = pool[stack];
  m.outer = keep(pool, m.outer);
  if (media_.size() * 2 >= table_.size()) {
    table_.assign(table_.size() < 64 ? 64 : table_.size() * 2, 0);
    for (uint32_t i = 1; i < media_.size(); ++i) {
      size_t at = hashOf(media_[i]) & (table_.size() - 1);
      while (table_[at]) at = (at + 1) & (table_.size() - 1);
      table_[at] = i;
    }
  }
  size_t at = hashOf(m) & (table_.size() - 1);
  while (table_[at] && std::memcmp(&media_[table_[at]], &m, sizeof m)) at = (at + 1) & (table_.size() - 1);
  if (!table_[at]) {
    table_[at] = uint32_t(media_.size());
    media_.push_back(m);
  }
  return table_[at];
}

void MediaArchive::keep(const MediaPool& pool, uint32_t n, const uint32_t* stacks, uint32_t* kept) {
  const std::lock_guard lock(mutex_);
  for (uint32_t i = 0; i < n; ++i) kept[i] = keep(pool, stacks[i]);
}

void MediaArchive::take(MediaPool& pool, uint32_t n, const uint32_t* kept, uint32_t* stacks) const {
  const std::lock_guard lock(mutex_);
  std::vector<uint32_t> inward;
  for (uint32_t i = 0; i < n; ++i) {
    inward.clear();
    for (uint32_t k = kept[i]; k; k = media_[k].outer) inward.push_back(k);
    stacks[i] = MediaPool::kEmpty;
    for (size_t k = inward.size(); k-- > 0;) stacks[i] = pool.push(stacks[i], media_[inward[k]]);
  }
}

}  // namespace kinora::shade
