// The values of a transform at its key times: a list that copies share until one of them is edited, and whose usual
// content, one default value, takes no memory. A million particles under one transform hold it once; a static transform
// of its own costs one block. Reads as std::vector does; what edits it through a reference unshares it first, so that
// readers of what others share should hold it const.
#pragma once
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace kinora::scene {

template <class T>
class Keys {
  static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= 8);

 public:
  using value_type = T;
  using size_type = size_t;
  using reference = T&;
  using const_reference = const T&;
  using iterator = T*;
  using const_iterator = const T*;

  Keys() = default;  // one default value
  Keys(std::initializer_list<T> list) { assign(list.begin(), list.end()); }
  Keys(const std::vector<T>& list) { assign(list.data(), list.data() + list.size()); }
  Keys(const Keys& o) : block_(o.block_) {
    if (block_) block_->uses.fetch_add(1, std::memory_order_relaxed);
  }
  Keys(Keys&& o) noexcept : block_(std::exchange(o.block_, nullptr)) {}
  Keys& operator=(Keys o) noexcept {
    std::swap(block_, o.block_);
    return *this;
  }
  ~Keys() { drop(block_); }

  size_t size() const { return block_ ? block_->count : 1; }
  bool empty() const { return size() == 0; }
  const T* data() const { return block_ ? block_->values() : &kUsual; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size(); }
  const T& operator[](size_t i) const { return data()[i]; }
  const T& front() const { return data()[0]; }
  const T& back() const { return data()[size() - 1]; }
  T* data() { return own(size())->values(); }
  T* begin() { return data(); }
  T* end() { return data() + size(); }
  T& operator[](size_t i) { return data()[i]; }
  T& front() { return data()[0]; }
  T& back() { return data()[size() - 1]; }

  void clear() { resize(0); }
  void resize(size_t n) {
    Block* b = own(n);
    for (size_t i = b->count; i < n; ++i) new (b->values() + i) T();
    b->count = uint32_t(n);
  }
  void push_back(const T& value) {
    const T copy = value;  // it may be one of these
    Block* b = own(size() + 1);
    new (b->values() + b->count) T(copy);
    ++b->count;
  }
  void pop_back() { resize(size() - 1); }
  void erase(const T* at) {
    const size_t i = size_t(at - std::as_const(*this).begin());
    T* d = data();
    std::copy(d + i + 1, d + size(), d + i);
    pop_back();
  }
  void assign(size_t n, const T& value) {
    const T copy = value;
    resize(n);
    std::fill(begin(), end(), copy);
  }
  template <class It>
  requires(!std::is_arithmetic_v<It>) void assign(It first, It last) {
    Keys made;
    made.resize(size_t(last - first));
    std::copy(first, last, made.data());
    *this = std::move(made);
  }
  friend bool operator==(const Keys& a, const Keys& b) {
    return a.block_ == b.block_ || std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
  size_t heldBytes() const { return block_ ? sizeof(Block) + room(block_->count) * sizeof(T) : 0; }

 private:
  struct Block {
    std::atomic<uint32_t> uses{1};
    uint32_t count = 0;
    T* values() { return reinterpret_cast<T*>(this + 1); }
  };
  static_assert(sizeof(Block) == 8);
  // There is always room for the next power of two.
  static size_t room(size_t count) { return std::bit_ceil(std::max<size_t>(count, 1)); }
  static void drop(Block* b) {
    if (b && b->uses.fetch_sub(1, std::memory_order_acq_rel) == 1) ::operator delete(b);
  }
  // A block that is this list's alone, with its values, and room for `n`.
  Block* own(size_t n) {
    const size_t have = size();
    const bool isAlone = block_ && block_->uses.load(std::memory_order_acquire) == 1;
    if (isAlone && n <= room(have)) return block_;
    Block* made = new (::operator new(sizeof(Block) + room(std::max(n, have)) * sizeof(T))) Block();
    const T* from = std::as_const(*this).data();
    for (size_t i = 0; i < have; ++i) new (made->values() + i) T(from[i]);
    made->count = uint32_t(have);
    drop(std::exchange(block_, made));
    return block_;
  }

  inline static const T kUsual{};
  Block* block_ = nullptr;  // null: one default value
};

}  // namespace kinora::scene
