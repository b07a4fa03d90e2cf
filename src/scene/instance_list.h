// The instances of a scene or an object: read as a list of Instance, held in a few bytes each where they stand still.
// Full blocks of them are packed: ids, lines, attributes and entries of matrices that neighbours share are kept once, the
// others in as few bytes as hold every bit. Blocks never change, so that copies of a list share them, and a list that
// was edited in one place is quickly told from the one before.
#pragma once
#include <ImathMatrix.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

namespace kinora {
struct SourcePos;
}
namespace kinora::scene {

struct Attributes;
struct Instance;
struct Transform;

class InstanceList {
 public:
  using value_type = Instance;
  class const_iterator;

  size_t size() const { return inBlocks_ + last_.size(); }
  bool empty() const { return size() == 0; }
  // Unpacked for the asker: const, since a change of it would change nothing here. See edit().
  const Instance operator[](size_t i) const;
  const_iterator begin() const;
  const_iterator end() const;

  // What of an instance is asked for by millions, without unpacking the rest.
  uint32_t prototypeOf(size_t i) const;
  uint32_t solidOf(size_t i) const;
  const std::shared_ptr<const Attributes>& attributesOf(size_t i) const;
  Transform toWorldOf(size_t i) const;
  bool stillToWorld(size_t i, Imath::M44d& toWorld) const;  // false: it moves

  void push_back(Instance instance);
  void pop_back() { erase(size() - 1); }
  void set(size_t i, Instance instance);
  // f(Instance&): what it leaves there is set.
  template <class F>
  void edit(size_t i, F&& f);
  void erase(size_t i);
  template <class F>
  void eraseIf(F&& isOut);
  void clear();
  // The place of the first with this id; size(): none.
  size_t find(uint32_t id) const;

  // Whether `same` holds for each with the one of the other list at its place. It is not asked about what both share.
  bool isLike(const InstanceList& other, const std::function<bool(const Instance&, const Instance&)>& same) const;
  size_t heldBytes() const;

 private:
  struct Block;
  struct Held {
    size_t first;  // of the list's
    std::shared_ptr<const Block> block;
  };
  static constexpr size_t kInBlock = 256;

  size_t blockAt(size_t i) const;  // in blocks_
  const Held& heldAt(size_t i) const { return blocks_[blockAt(i)]; }
  static std::shared_ptr<const Block> pack(const std::vector<Instance>& instances);
  static std::vector<Instance> unpack(const Block& block);
  void count(size_t fromBlock);

  std::vector<Held> blocks_;
  size_t inBlocks_ = 0;
  bool isEven_ = true;          // all blocks are full
  std::vector<Instance> last_;  // fewer than a block
};

class InstanceList::const_iterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = Instance;
  using difference_type = std::ptrdiff_t;
  using pointer = void;
  using reference = const Instance;

  const_iterator(const InstanceList& list, size_t i) : list_(&list), i_(i) {}
  reference operator*() const;
  const_iterator& operator++() {
    ++i_;
    return *this;
  }
  void operator++(int) { ++i_; }
  bool operator==(const const_iterator& o) const { return i_ == o.i_; }

 private:
  const InstanceList* list_;
  size_t i_;
};

inline InstanceList::const_iterator InstanceList::begin() const { return {*this, 0}; }
inline InstanceList::const_iterator InstanceList::end() const { return {*this, size()}; }

template <class F>
void InstanceList::edit(size_t i, F&& f) {
  auto instance = std::as_const(*this)[i];
  std::remove_const_t<decltype(instance)> edited = std::move(instance);
  std::forward<F>(f)(edited);
  set(i, std::move(edited));
}

template <class F>
void InstanceList::eraseIf(F&& isOut) {
  InstanceList left;
  for (size_t i = 0; i < size(); ++i) {
    auto instance = (*this)[i];
    if (!isOut(instance)) left.push_back(std::move(instance));
  }
  *this = std::move(left);
}

}  // namespace kinora::scene
