// Identifiers as numbers, and the memory of one compilation. Used by the lexer, the parser and the checker; both end
// with the compilation.
#pragma once
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <vector>

namespace kinora::language::front {

// Everything that lives as long as the compilation: nodes without destructors, spelled text.
class Pool {
 public:
  template <class T>
  T* make() {
    static_assert(std::is_trivially_destructible_v<T>);
    return new (take(sizeof(T), alignof(T))) T();
  }
  template <class T>
  std::span<T> copy(const std::vector<T>& from) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (from.empty()) return {};
    T* to = static_cast<T*>(take(from.size() * sizeof(T), alignof(T)));
    std::memcpy(static_cast<void*>(to), from.data(), from.size() * sizeof(T));
    return {to, from.size()};
  }
  std::string_view copy(std::string_view text) {
    if (text.empty()) return {};
    char* to = static_cast<char*>(take(text.size(), 1));
    std::memcpy(to, text.data(), text.size());
    return {to, text.size()};
  }

 private:
  void* take(size_t bytes, size_t align) {
    used_ = (used_ + align - 1) & ~(align - 1);
    if (blocks_.empty() || used_ + bytes > size_) {
      size_ = bytes > kBlock ? bytes : kBlock;
      blocks_.push_back(std::make_unique_for_overwrite<std::byte[]>(size_));
      used_ = 0;
    }
    void* p = blocks_.back().get() + used_;
    used_ += bytes;
    return p;
  }
  static constexpr size_t kBlock = size_t(1) << 16;
  std::vector<std::unique_ptr<std::byte[]>> blocks_;
  size_t used_ = 0, size_ = 0;
};

using Name = uint32_t;  // 0 is no name
class Names {
 public:
  explicit Names(Pool& pool) : pool_(pool), texts_{""} {}
  Name intern(std::string_view text) {
    const auto found = ids_.find(text);
    if (found != ids_.end()) return found->second;
    const std::string_view own = pool_.copy(text);
    const Name id = Name(texts_.size());
    texts_.push_back(own);
    ids_.emplace(own, id);
    return id;
  }
  Name find(std::string_view text) const {  // 0 when it never occurred
    const auto found = ids_.find(text);
    return found == ids_.end() ? 0 : found->second;
  }
  std::string_view text(Name name) const { return texts_[name]; }
  size_t size() const { return texts_.size(); }

 private:
  Pool& pool_;
  std::vector<std::string_view> texts_;
  std::unordered_map<std::string_view, Name> ids_;
};

}  // namespace kinora::language::front
