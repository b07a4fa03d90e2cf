#include "scene/instance_list.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "scene/scene.h"

namespace kinora::scene {

struct InstanceList::Block {
  // What neighbours mostly share.
  struct Kind {
    uint32_t prototype = 0, solid = 0;
    AttributesPtr attributes;
    FileName file;
    bool operator==(const Kind&) const = default;
  };
  // Numbers that are mostly one as far from the one before as the others.
  struct Numbers {
    uint32_t first = 0, step = 0;
    std::vector<uint32_t> each;  // empty: by steps
    uint32_t at(size_t i) const { return each.empty() ? first + uint32_t(i) * step : each[i]; }
  };
  // One of the sixteen of a matrix.
  struct Entry {
    enum class Form : uint8_t { Shared, Float, Double } form = Form::Shared;
    uint16_t word = 0;  // where it stands among an instance's words
    double shared = 0;
  };

  uint32_t count = 0;
  std::vector<Kind> kinds;
  std::vector<uint8_t> kindOf;  // empty: all are of the first
  Numbers ids, lines;
  std::vector<Transform> moving;  // all, where one moves or has a time of its own; else words
  std::array<Entry, 16> entries;
  uint32_t wordsEach = 0;
  std::vector<uint32_t> words;

  const Kind& kind(size_t i) const { return kinds[kindOf.empty() ? 0 : kindOf[i]]; }
  Matrix matrix(size_t i) const {
    const uint32_t* from = words.data() + i * wordsEach;
    Matrix m(Imath::UNINITIALIZED);
    for (size_t k = 0; k < 16; ++k) {
      const Entry& e = entries[k];
      double& x = m[int(k / 4)][k % 4];
      if (e.form == Entry::Form::Shared)
        x = e.shared;
      else if (e.form == Entry::Form::Float)
        x = double(std::bit_cast<float>(from[e.word]));
      else
        std::memcpy(&x, from + e.word, sizeof x);
    }
    return m;
  }
  Transform transform(size_t i) const {
    if (!moving.empty()) return moving[i];
    Transform t;
    // of a comparison -0 would be 0
    if (const Matrix m = matrix(i), usual; std::memcmp(&m, &usual, sizeof m) != 0) t.matrices[0] = m;
    return t;
  }
  Instance instance(size_t i) const {
    const Kind& k = kind(i);
    Instance out;
    out.id = ids.at(i);
    out.prototype = k.prototype;
    out.toWorld = transform(i);
    out.attributes = k.attributes;
    out.solid = k.solid;
    out.pos = {k.file, lines.at(i)};
    return out;
  }

  static Numbers numbersOf(const std::vector<uint32_t>& each) {
    Numbers n;
    n.first = each[0];
    n.step = each.size() > 1 ? each[1] - each[0] : 0;
    for (size_t i = 0; i < each.size(); ++i)
      if (each[i] != n.first + uint32_t(i) * n.step) {
        n.each = each;
        break;
      }
    return n;
  }
  void packKinds(const std::vector<Instance>& instances) {
    constexpr size_t kLookedBack = 16;
    for (size_t i = 0; i < instances.size(); ++i) {
      const Instance& one = instances[i];
      Kind k{one.prototype, one.solid, one.attributes, one.pos.file};
      const auto newest = kinds.rbegin(), oldest = newest + ptrdiff_t(std::min(kinds.size(), kLookedBack)),
                 at = std::find(newest, oldest, k);
      size_t place = kinds.size() - 1 - size_t(at - newest);
      if (at == oldest) {
        place = kinds.size();
        kinds.push_back(std::move(k));
      }
      kindOf.push_back(uint8_t(place));
    }
    if (kinds.size() == 1) kindOf = {};
    kinds.shrink_to_fit();
    kindOf.shrink_to_fit();
  }
  void packTransforms(const std::vector<Instance>& instances) {
    const double usualTime = 0;
    const auto isStill = [&](const Instance& i) {
      return i.toWorld.matrices.size() == 1 && i.toWorld.times.size() == 1 &&
             std::memcmp(i.toWorld.times.data(), &usualTime, sizeof usualTime) == 0;
    };
    if (!std::all_of(instances.begin(), instances.end(), isStill)) {
      for (const Instance& i : instances) moving.push_back(i.toWorld);
      return;
    }
    const auto bits = [](double x) { return std::bit_cast<uint64_t>(x); };
    const auto entryOf = [](const Instance& i, size_t k) { return i.toWorld.matrices[0][int(k / 4)][k % 4]; };
    for (size_t k = 0; k < 16; ++k) {
      Entry& e = entries[k];
      e.shared = entryOf(instances[0], k);
      bool isShared = true, isFloat = true;
      for (const Instance& i : instances) {
        const double x = entryOf(i, k);
        isShared &= bits(x) == bits(e.shared);
        isFloat &= bits(double(float(x))) == bits(x);
      }
      if (isShared) continue;
      e.form = isFloat ? Entry::Form::Float : Entry::Form::Double;
      e.word = uint16_t(wordsEach);
      wordsEach += isFloat ? 1 : 2;
    }
    words.resize(instances.size() * wordsEach);
    for (size_t i = 0; i < instances.size(); ++i)
      for (size_t k = 0; k < 16; ++k) {
        const Entry& e = entries[k];
        const double x = entryOf(instances[i], k);
        uint32_t* to = words.data() + i * wordsEach + e.word;
        if (e.form == Entry::Form::Float)
          *to = std::bit_cast<uint32_t>(float(x));
        else if (e.form == Entry::Form::Double)
          std::memcpy(to, &x, sizeof x);
      }
  }
};

std::shared_ptr<const InstanceList::Block> InstanceList::pack(const std::vector<Instance>& instances) {
  auto block = std::make_shared<Block>();
  block->count = uint32_t(instances.size());
  std::vector<uint32_t> ids, lines;
  for (const Instance& i : instances) {
    ids.push_back(i.id);
    lines.push_back(i.pos.line);
  }
  block->ids = Block::numbersOf(ids);
  block->lines = Block::numbersOf(lines);
  block->packKinds(instances);
  block->packTransforms(instances);
  return block;
}

std::vector<Instance> InstanceList::unpack(const Block& block) {
  std::vector<Instance> out;
  out.reserve(block.count);
  for (size_t i = 0; i < block.count; ++i) out.push_back(block.instance(i));
  return out;
}

// Blocks hold at most kInBlock, so that one with the i-th is no earlier than that.
size_t InstanceList::blockAt(size_t i) const {
  if (isEven_) return i / kInBlock;
  const auto after = std::upper_bound(blocks_.begin() + ptrdiff_t(i / kInBlock), blocks_.end(), i,
                                      [](size_t place, const Held& h) { return place < h.first; });
  return size_t(after - blocks_.begin()) - 1;
}

const Instance InstanceList::operator[](size_t i) const {
  if (i >= inBlocks_) return last_[i - inBlocks_];
  const Held& h = heldAt(i);
  return h.block->instance(i - h.first);
}
const Instance InstanceList::const_iterator::operator*() const { return (*list_)[i_]; }

uint32_t InstanceList::prototypeOf(size_t i) const {
  if (i >= inBlocks_) return last_[i - inBlocks_].prototype;
  const Held& h = heldAt(i);
  return h.block->kind(i - h.first).prototype;
}
uint32_t InstanceList::solidOf(size_t i) const {
  if (i >= inBlocks_) return last_[i - inBlocks_].solid;
  const Held& h = heldAt(i);
  return h.block->kind(i - h.first).solid;
}
const AttributesPtr& InstanceList::attributesOf(size_t i) const {
  if (i >= inBlocks_) return last_[i - inBlocks_].attributes;
  const Held& h = heldAt(i);
  return h.block->kind(i - h.first).attributes;
}
Transform InstanceList::toWorldOf(size_t i) const {
  if (i >= inBlocks_) return last_[i - inBlocks_].toWorld;
  const Held& h = heldAt(i);
  return h.block->transform(i - h.first);
}
bool InstanceList::stillToWorld(size_t i, Imath::M44d& toWorld) const {
  const auto ofOne = [&](const Transform& t) {
    if (t.isStatic()) toWorld = t.matrices[0];
    return t.isStatic();
  };
  if (i >= inBlocks_) return ofOne(last_[i - inBlocks_].toWorld);
  const Held& h = heldAt(i);
  if (!h.block->moving.empty()) return ofOne(h.block->moving[i - h.first]);
  toWorld = h.block->matrix(i - h.first);
  return true;
}

void InstanceList::push_back(Instance instance) {
  if (last_.empty()) last_.reserve(blocks_.empty() ? 1 : kInBlock);
  last_.push_back(std::move(instance));
  if (last_.size() < kInBlock) return;
  blocks_.push_back({inBlocks_, pack(last_)});
  inBlocks_ += last_.size();
  last_.clear();
}

void InstanceList::set(size_t i, Instance instance) {
  if (i >= inBlocks_) {
    last_[i - inBlocks_] = std::move(instance);
    return;
  }
  Held& h = blocks_[blockAt(i)];
  std::vector<Instance> all = unpack(*h.block);
  all[i - h.first] = std::move(instance);
  h.block = pack(all);
}

void InstanceList::erase(size_t i) {
  if (i >= inBlocks_) {
    last_.erase(last_.begin() + ptrdiff_t(i - inBlocks_));
    return;
  }
  const size_t at = blockAt(i);
  std::vector<Instance> all = unpack(*blocks_[at].block);
  all.erase(all.begin() + ptrdiff_t(i - blocks_[at].first));
  if (all.empty())
    blocks_.erase(blocks_.begin() + ptrdiff_t(at));
  else
    blocks_[at].block = pack(all);
  count(at);
}

void InstanceList::count(size_t fromBlock) {
  for (size_t b = fromBlock; b < blocks_.size(); ++b)
    blocks_[b].first = b == 0 ? 0 : blocks_[b - 1].first + blocks_[b - 1].block->count;
  inBlocks_ = blocks_.empty() ? 0 : blocks_.back().first + blocks_.back().block->count;
  isEven_ = inBlocks_ == blocks_.size() * kInBlock;
}

void InstanceList::clear() { *this = InstanceList(); }

size_t InstanceList::find(uint32_t id) const {
  for (const Held& h : blocks_)
    for (size_t i = 0; i < h.block->count; ++i)
      if (h.block->ids.at(i) == id) return h.first + i;
  const auto at = std::find_if(last_.begin(), last_.end(), [id](const Instance& i) { return i.id == id; });
  return inBlocks_ + size_t(at - last_.begin());
}

bool InstanceList::isLike(const InstanceList& other,
                          const std::function<bool(const Instance&, const Instance&)>& same) const {
  if (size() != other.size()) return false;
  const auto hold = [](const InstanceList& list, size_t i) { return i < list.inBlocks_ ? &list.heldAt(i) : nullptr; };
  for (size_t i = 0; i < size();) {
    const Held *a = hold(*this, i), *b = hold(other, i);
    if (a && b && a->block == b->block && a->first == b->first) {
      i = a->first + a->block->count;
      continue;
    }
    if (!same((*this)[i], other[i])) return false;
    ++i;
  }
  return true;
}

size_t InstanceList::heldBytes() const {
  size_t n = blocks_.capacity() * sizeof(Held) + last_.capacity() * sizeof(Instance);
  const auto ofTransform = [](const Transform& t) { return t.times.heldBytes() + t.matrices.heldBytes(); };
  for (const Held& h : blocks_) {
    const Block& b = *h.block;
    n += sizeof b + b.kinds.capacity() * sizeof(Block::Kind) + b.kindOf.capacity() +
         (b.ids.each.capacity() + b.lines.each.capacity() + b.words.capacity()) * sizeof(uint32_t) +
         b.moving.capacity() * sizeof(Transform);
    for (const Transform& t : b.moving) n += ofTransform(t);
  }
  for (const Instance& i : last_) n += ofTransform(i.toWorld);
  return n;
}

}  // namespace kinora::scene
