// Proves that a list of instances gives back what was put into it, bit for bit, whatever the edits between; that copies
// stay as they were; that neighbours which are alike take few bytes. It does not say what is rendered of them.
#include "scene/instance_list.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "scene/identity.h"
#include "scene/scene.h"

namespace kinora::scene {
namespace {

bool areSame(const Transform& a, const Transform& b) {
  const auto sameBits = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
  };
  return sameBits(std::as_const(a.times), std::as_const(b.times)) &&
         sameBits(std::as_const(a.matrices), std::as_const(b.matrices));
}
bool areSame(const Instance& a, const Instance& b) {
  return a.id == b.id && a.prototype == b.prototype && areSame(a.toWorld, b.toWorld) &&
         a.attributes == b.attributes && a.solid == b.solid && a.pos.file == b.pos.file && a.pos.line == b.pos.line;
}

// By every road that leads to an instance.
void expectSame(const InstanceList& list, const std::vector<Instance>& wanted) {
  ASSERT_EQ(list.size(), wanted.size());
  size_t at = 0;
  for (const Instance& i : list) ASSERT_TRUE(areSame(i, wanted[at++]));
  for (size_t i = 0; i < wanted.size(); ++i) {
    const Instance& w = wanted[i];
    ASSERT_TRUE(areSame(list[i], w)) << i;
    ASSERT_EQ(list.prototypeOf(i), w.prototype);
    ASSERT_EQ(list.solidOf(i), w.solid);
    ASSERT_EQ(list.attributesOf(i), w.attributes);
    ASSERT_TRUE(areSame(list.toWorldOf(i), w.toWorld));
    Matrix m;
    ASSERT_EQ(list.stillToWorld(i, m), w.toWorld.isStatic());
    if (w.toWorld.isStatic()) {
      ASSERT_EQ(std::memcmp(&m, w.toWorld.matrices.data(), sizeof m), 0);
    }
  }
}

class Maker {
 public:
  explicit Maker(uint32_t seed) : rng_(seed) {
    for (int i = 0; i < 400; ++i) attributes_.push_back(std::make_shared<Attributes>());
    attributes_.push_back(nullptr);
  }
  uint32_t below(size_t n) { return uint32_t(rng_() % n); }
  // How unlike the ones that follow are, from none at all to everything.
  void turn() { mode_ = below(6); }
  Instance next() {
    static const auto kFile = FileName("a.rib"), kOther = FileName("b.rib");
    Instance i;
    i.id = mode_ == 4 ? uint32_t(rng_()) : ++id_;
    i.prototype = mode_ == 2 ? below(3) : 0;
    i.attributes = attributes_[mode_ == 3 ? below(attributes_.size()) : 0];
    i.solid = mode_ == 5 ? below(2) : 0;
    i.pos = {mode_ == 5 && below(2) ? kOther : kFile, mode_ == 4 ? uint32_t(rng_()) : line_ += 3};
    Matrix m;
    std::uniform_real_distribution<double> any(-100, 100);
    for (int k = 0; k < 3; ++k) m[3][k] = mode_ == 0 ? double(float(any(rng_))) : any(rng_);
    if (mode_ >= 2)
      for (int k = 0; k < 16; ++k)
        if (below(2)) m[k / 4][k % 4] = unusual();
    i.toWorld = Transform();
    if (below(8)) i.toWorld.matrices[0] = m;
    if (mode_ == 5 && below(200) == 0) {
      i.toWorld.times = {0.25, 0.5};
      i.toWorld.matrices = {m, Matrix()};
    } else if (mode_ == 5 && below(200) == 0) {
      i.toWorld.times = {-0.};
    }
    return i;
  }

 private:
  double unusual() {
    constexpr double kNumbers[] = {-0., 1e-320, 1e-42, 1e300, -1e39, 0.1, 3, INFINITY};
    switch (below(4)) {
      case 0:
        return std::bit_cast<double>(0x7ff0000000000000u | (uint64_t(rng_()) << 20 | 1));  // NaN of any kind
      case 1:
        return double(float(below(1000)));
      default:
        return kNumbers[below(std::size(kNumbers))];
    }
  }
  std::mt19937 rng_;
  std::vector<AttributesPtr> attributes_;
  uint32_t mode_ = 0, id_ = 0, line_ = 0;
};

TEST(InstanceList, IsTheListThatWasMade) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    Maker maker(seed);
    InstanceList list;
    std::vector<Instance> wanted;
    std::vector<std::pair<InstanceList, std::vector<Instance>>> copies;
    for (int step = 0; step < 60; ++step) {
      maker.turn();
      const uint32_t what = maker.below(8);
      if (what < 3 || wanted.empty()) {
        for (uint32_t n = 1 + maker.below(500); n-- > 0;) {
          wanted.push_back(maker.next());
          list.push_back(wanted.back());
        }
      } else if (what == 3) {
        for (int n = 0; n < 10; ++n) {
          const size_t at = maker.below(wanted.size());
          list.set(at, wanted[at] = maker.next());
        }
      } else if (what == 4) {
        const size_t at = maker.below(wanted.size());
        const Transform t = maker.next().toWorld;
        list.edit(at, [&](Instance& i) { i.toWorld = t; });
        wanted[at].toWorld = t;
      } else if (what == 5) {
        for (size_t n = std::min<size_t>(wanted.size(), 1 + maker.below(300)); n-- > 0;) {
          const size_t at = maker.below(wanted.size());
          list.erase(at);
          wanted.erase(wanted.begin() + ptrdiff_t(at));
        }
      } else if (what == 6) {
        const auto isOut = [](const Instance& i) { return i.pos.line % 7 == 1; };
        list.eraseIf(isOut);
        std::erase_if(wanted, isOut);
      } else {
        copies.emplace_back(list, wanted);
      }
      ASSERT_EQ(list.size(), wanted.size());
      if (step % 10 == 9) expectSame(list, wanted);
    }
    for (const auto& [copy, then] : copies) expectSame(copy, then);
    for (const Instance& i : wanted) {
      const size_t found = list.find(i.id);
      ASSERT_LT(found, list.size());
      ASSERT_EQ(list[found].id, i.id);
    }
  }
}

// The digest of a scene is that of its instances one by one, in whichever order they came to where they are.
TEST(InstanceList, SaysTheSameHoweverItWasMade) {
  Maker maker(3);
  Scene straight, mended;
  std::vector<Instance> wanted;
  for (int turn = 0; turn < 6; ++turn) {
    maker.turn();
    for (int i = 0; i < 300; ++i) wanted.push_back(maker.next());
  }
  for (const Instance& i : wanted) straight.instances.push_back(i);
  for (const Instance& i : wanted) {
    mended.instances.push_back(i);
    mended.instances.push_back(maker.next());
  }
  for (size_t i = wanted.size(); i-- > 0;) mended.instances.erase(2 * i + 1);
  expectSame(mended.instances, wanted);
  EXPECT_EQ(digestOf(straight), digestOf(mended));
  mended.instances.edit(700, [](Instance& i) { i.solid += 1; });
  EXPECT_NE(digestOf(straight), digestOf(mended));
}

TEST(InstanceList, WhatIsSharedIsNotCompared) {
  Maker maker(5);
  InstanceList list;
  for (int i = 0; i < 5000; ++i) list.push_back(maker.next());
  InstanceList copy = list;
  copy.edit(2000, [](Instance& i) { i.prototype = 9; });
  size_t asked = 0, unlike = 0;
  EXPECT_TRUE(copy.isLike(list, [&](const Instance& a, const Instance& b) {
    ++asked;
    unlike += a.prototype != b.prototype;
    return true;
  }));
  EXPECT_EQ(unlike, 1u);
  EXPECT_LT(asked, 600u);
  EXPECT_FALSE(copy.isLike(list, [](const Instance& a, const Instance& b) { return areSame(a, b); }));
  copy.erase(0);
  EXPECT_FALSE(copy.isLike(list, [](const Instance&, const Instance&) { return true; }));
}

TEST(InstanceList, TakesFewBytes) {
  const auto bytesEach = [](const std::function<Matrix(int)>& at) {
    InstanceList list;
    const auto attributes = std::make_shared<Attributes>();
    const auto file = FileName("a.rib");
    constexpr int kCount = 100000;
    for (int i = 0; i < kCount; ++i)
      list.push_back({uint32_t(i), 0, Transform::fixed(at(i)), attributes, 0, {file, uint32_t(2 * i)}});
    return double(list.heldBytes()) / kCount;
  };
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> any(-1, 1);
  EXPECT_LT(bytesEach([&](int) { return Matrix().setTranslation(Imath::V3d(float(any(rng)), float(any(rng)), 0)); }),
            12);
  EXPECT_LT(bytesEach([&](int) {
              Matrix m;
              for (int k = 0; k < 12; ++k) m[k / 3][k % 3] = float(any(rng));
              return m;
            }),
            52);
  EXPECT_LT(bytesEach([&](int) {
              Matrix m;
              for (int k = 0; k < 12; ++k) m[k / 3][k % 3] = any(rng);
              return m;
            }),
            100);
}

}  // namespace
}  // namespace kinora::scene
