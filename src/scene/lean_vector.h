// A std::vector that takes one pointer where it is empty: for members that few of very many objects fill. What is in it
// costs a second allocation.
#pragma once
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace kinora::scene {

template <class T>
class LeanVector {
 public:
  using Vector = std::vector<T>;
  using value_type = T;
  using size_type = typename Vector::size_type;
  using iterator = typename Vector::iterator;
  using const_iterator = typename Vector::const_iterator;

  LeanVector() = default;
  LeanVector(Vector v) { *this = std::move(v); }
  LeanVector(std::initializer_list<T> list) : LeanVector(Vector(list)) {}
  LeanVector(const LeanVector& o) : held_(o.empty() ? nullptr : std::make_unique<Vector>(*o.held_)) {}
  LeanVector(LeanVector&&) noexcept = default;
  LeanVector& operator=(const LeanVector& o) {
    if (this != &o) *this = LeanVector(o);
    return *this;
  }
  LeanVector& operator=(LeanVector&&) noexcept = default;
  LeanVector& operator=(Vector v) {
    if (v.empty())
      held_.reset();
    else
      held_ = std::make_unique<Vector>(std::move(v));
    return *this;
  }
  LeanVector& operator=(std::initializer_list<T> list) { return *this = Vector(list); }

  operator const Vector&() const { return get(); }
  const Vector& get() const {
    static const Vector none;
    return held_ ? *held_ : none;
  }
  // To be filled; memory is taken from then on.
  Vector& edit() {
    if (!held_) held_ = std::make_unique<Vector>();
    return *held_;
  }

  bool empty() const { return !held_ || held_->empty(); }
  size_type size() const { return held_ ? held_->size() : 0; }
  const T* data() const { return held_ ? held_->data() : nullptr; }
  T* data() { return held_ ? held_->data() : nullptr; }
  const T& operator[](size_type i) const { return (*held_)[i]; }
  T& operator[](size_type i) { return (*held_)[i]; }
  const T& front() const { return held_->front(); }
  T& front() { return held_->front(); }
  const T& back() const { return held_->back(); }
  T& back() { return held_->back(); }
  const_iterator begin() const { return get().begin(); }
  const_iterator end() const { return get().end(); }
  iterator begin() { return held_ ? held_->begin() : iterator(); }
  iterator end() { return held_ ? held_->end() : iterator(); }

  void push_back(T value) { edit().push_back(std::move(value)); }
  void pop_back() { held_->pop_back(); }
  void resize(size_type n) {
    if (n)
      edit().resize(n);
    else
      held_.reset();
  }
  void assign(size_type n, const T& value) { *this = Vector(n, value); }
  template <class I>
  requires(!std::is_arithmetic_v<I>) void assign(I first, I last) { *this = Vector(first, last); }
  void clear() { held_.reset(); }

  // What it takes beside its own pointer.
  size_t bytes() const { return held_ ? sizeof(Vector) + held_->capacity() * sizeof(T) : 0; }

  friend bool operator==(const LeanVector& a, const LeanVector& b) { return a.get() == b.get(); }
  friend bool operator==(const LeanVector& a, const Vector& b) { return a.get() == b; }

 private:
  std::unique_ptr<Vector> held_;
};

}  // namespace kinora::scene
