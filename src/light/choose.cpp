// Kernels of choose.h.
#define KINORA_KERNEL_FILE "light/choose.cpp"
#include "light/choose.h"

#include <utility>

#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/simd/wide.h>
#include <kinora/simd/records.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using light::ChooseArgs;
using light::LightTree;
using light::TopNode;
using light::TreeNode;

// A surface lit from behind its normal's plane: bumps lean over it, and leaves let light through.
constexpr float kLeastFacing = 0.03f, kLeastFacingThrough = 0.3f;

template <int W>
struct Receiver {
  Vec3<W> P, N;  // N: unit, or zero where light from all sides counts alike
  Float<W> least;
  Mask<W> hasN;
  KN_INLINE Receiver(const ChooseArgs& a, const Slots<W>& s)
      : Receiver(a.N[0] ? Receiver(Vec3<W>::get(a.P, s), Vec3<W>::get(a.N, s)) : Receiver(Vec3<W>::get(a.P, s))) {}
  KN_INLINE explicit Receiver(Vec3<W> point)
      : P(point), N(Float<W>(0.f), Float<W>(0.f), Float<W>(0.f)), least(1.f), hasN(false) {}
  KN_INLINE Receiver(Vec3<W> point, Vec3<W> normal) : P(point), N(normal) {
    using F = Float<W>;
    const F l2 = dot(N, N);
    hasN = l2 > F(0.f);
    const Mask<W> through = l2 < F(0.5f);
    N = select(through, N + N, N);
    least = select(hasN, select(through, F(kLeastFacingThrough), F(kLeastFacing)), F(1.f));
  }
};

template <int W>
struct WideNode {
  Vec3<W> center, half, axis;
  Float<W> weight, cosNormals, sinNormals, cosEmission;
  Mask<W> isTwoSided, isUniform;
  bool isAround;  // all lanes' lights emit to all sides: cones need no look
  KN_INLINE WideNode() {}
};

// 1 / sqrt(x) within .18 %, of positive x: choice weighs lights by estimates that are coarser by far, and roots and
// divisions would be most of what it takes. One Newton step from the exponent's half, the same bits on every CPU.
constexpr float kRootSlack = 0.002f;
template <int W>
KN_INLINE Float<W> inverseRoot(Float<W> x) {
  using F = Float<W>;
  const F y = asFloat(Int<W>(0x5f375a86) - asInt(x).template shr<1>());
  return y * fnma(x * F(0.5f), y * y, F(1.5f));
}
// sqrt(x) as well, of x >= 0.
template <int W>
KN_INLINE Float<W> root(Float<W> x) {
  return x * inverseRoot<W>(max(x, Float<W>(1e-30f)));
}

template <int W>
KN_INLINE Vec3<W> absolute(Vec3<W> a) {
  return {abs(a.x), abs(a.y), abs(a.z)};
}

// Infinite lights: light from one direction by its cosine, light from all around by a quarter.
template <int W>
KN_INLINE Float<W> farImportance(const Receiver<W>& r, Vec3<W> mean, Float<W> concentration, Float<W> weight) {
  using F = Float<W>;
  const F facing = max(dot(r.N, mean), r.least * concentration);
  const F f = fma(F(1.f) - concentration, F(0.25f), facing);
  return weight * select(r.hasN, f, F(1.f));
}

// Falloff of what the lights below a node emit towards the point, which lies at -v from the box's centre; 0: none does.
template <int W>
KN_INLINE Float<W> emittedTo(const WideNode<W>& n, Vec3<W> v, Vec3<W> distance, Mask<W> inside, Float<W> inverse,
                             Float<W> inverseLeast) {
  using F = Float<W>;
  const F zero(0.f), one(1.f), half(0.5f), tiny(1e-30f);
  const Vec3<W> farthest = distance + n.half;
  // to the axis of emission, and past the cone of normals
  const F towards = -dot(n.axis, v);
  const F height = select(n.isTwoSided, abs(towards), towards), rise = dot(absolute(n.axis), n.half);
  const F inverseMost = inverseRoot<W>(max(dot(farthest, farthest), tiny));
  const F top = height + rise;
  const F most = min(fma(top, select(top > zero, inverseLeast, inverseMost), F(light::kAxisSlack)), one);
  const F mean = clamp(height * inverse, F(-1.f), one);
  const auto past = [&](F cosine) HWY_ATTR {
    const F sine = root<W>(max(fnma(cosine, cosine, one), zero));
    return select(cosine >= n.cosNormals, one, fma(cosine, n.cosNormals, sine * n.sinNormals));
  };
  const F mostEmitted = select(inside, one, past(max(most, F(-1.f))));
  return zeroUnless(mostEmitted + F(kRootSlack) >= n.cosEmission,
                    max(half * (max(mostEmitted, zero) + max(past(mean), zero)), F(1e-3f)));
}

// About the irradiance that the lights below a node bring: intensity, falloff and cosine over the squared distance. 0
// only where none of them reaches the point; of falloff and cosine the mean of what the box's centre has and of the
// most that any place in the box could have: the greatest height of the box over the plane, and the least distance.
template <int W>
KN_INLINE Float<W> nearImportance(const Receiver<W>& r, const WideNode<W>& n) {
  using F = Float<W>;
  const F zero(0.f), one(1.f), half(0.5f), tiny(1e-30f);
  const Vec3<W> v = n.center - r.P, distance = absolute(v);
  const Vec3<W> beyond = distance - n.half;
  const Vec3<W> nearest(max(beyond.x, zero), max(beyond.y, zero), max(beyond.z, zero));
  const F d2 = dot(v, v), inverse = inverseRoot<W>(max(d2, tiny));
  const F least2 = dot(nearest, nearest), inverseLeast = inverseRoot<W>(max(least2, tiny));
  const Mask<W> inside = least2 <= tiny;
  const F emitted = n.isAround ? one : emittedTo<W>(n, v, distance, inside, inverse, inverseLeast);
  // to the receiver's normal
  const F heightN = dot(r.N, v), topN = heightN + dot(absolute(r.N), n.half);
  const F mostN = select(inside, one, min(max(topN, zero) * inverseLeast, one));
  const F facing = select(r.hasN, max(half * (mostN + max(heightN * inverse, zero)), r.least), one);
  const F spread = inverseRoot<W>(max(max(d2, dot(n.half, n.half)), F(1e-20f)));
  return n.weight * emitted * facing * (spread * spread);
}

// So small from the point that below this node lights are chosen by power: what distance and normal still tell of
// them is less than what it takes to look.
constexpr float kFar = 4;
template <int W>
KN_INLINE Mask<W> isByPower(const Receiver<W>& r, const WideNode<W>& n) {
  const Vec3<W> v = n.center - r.P;
  return n.isUniform & (dot(v, v) > Float<W>(kFar) * dot(n.half, n.half));
}

template <int W>
KN_INLINE Float<W> usable(Float<W> x) {
  return zeroUnless((x > Float<W>(0.f)) & isFinite(x), x);
}

template <int W>
KN_INLINE Float<W> topImportance(const Receiver<W>& r, const TopNode& t, Mask<W>& byPower) {
  using F = Float<W>;
  const Vec3<W> center(F(t.center[0]), F(t.center[1]), F(t.center[2]));
  byPower = Mask<W>(false);
  if (t.isInfinite) return usable(farImportance<W>(r, center, F(t.concentration), F(t.weight)));
  WideNode<W> n;
  n.center = center;
  n.axis = Vec3<W>(F(t.axis[0]), F(t.axis[1]), F(t.axis[2]));
  n.half = Vec3<W>(F(t.half[0]), F(t.half[1]), F(t.half[2]));
  n.weight = F(t.weight);
  n.cosNormals = F(t.cosNormals);
  n.sinNormals = F(t.sinNormals);
  n.cosEmission = F(t.cosEmission);
  n.isTwoSided = Mask<W>(t.isTwoSided != 0);
  n.isUniform = Mask<W>(t.isUniform != 0);
  n.isAround = t.isAround != 0;
  byPower = isByPower<W>(r, n);
  return usable(nearImportance<W>(r, n));
}

template <int W>
KN_INLINE Int<W> smaller(Int<W> a, Int<W> b) {
  return select(a < b, a, b);
}
template <int W>
KN_INLINE Int<W> larger(Int<W> a, Int<W> b) {
  return select(a < b, b, a);
}

template <int W>
KN_INLINE Mask<W> isLeaf(Int<W> child) {
  return child < Int<W>(0);
}

// A node of the tree, by lane or the same for all: number(k) is its k-th word.
template <int W>
struct InnerNode {
  WideNode<W> near;
  Mask<W> isFar;
  Int<W> child;
  template <class Number>
  KN_INLINE explicit InnerNode(Number number) {
    using F = Float<W>;
    using I = Int<W>;
    const I extent = asInt(number(4)), extentZ = asInt(number(5)), axis = asInt(number(6));
    child = asInt(number(7));
    near.center = {number(0), number(1), number(2)};
    near.weight = number(3);
    constexpr int kDropped = 31 - int(light::kExtentBits), kBits = int(light::kExtentBits);
    const I mask(light::kExtentMask);
    near.half = {asFloat((extent & mask).template shl<kDropped>()),
                 asFloat((extent.template shr<kBits>() & mask).template shl<kDropped>()),
                 asFloat((extentZ & mask).template shl<kDropped>())};
    const F eighth(1 / 127.f), sixteenth(1 / 32767.f);
    near.axis = {toFloat(axis.template shl<24>().template sar<24>()) * eighth,
                 toFloat(axis.template shl<16>().template sar<24>()) * eighth,
                 toFloat(axis.template shl<8>().template sar<24>()) * eighth};
    near.cosNormals = toFloat(extentZ.template sar<16>()) * sixteenth;
    near.sinNormals = root<W>(max(fnma(near.cosNormals, near.cosNormals, F(1.f)), F(0.f)));
    near.cosEmission = toFloat(axis.template sar<24>()) * eighth;
    near.isTwoSided = extent < I(0);
    near.isUniform = (extentZ & I(light::kNodeUniform)) != I(0);
    near.isAround = ((extentZ & I(light::kNodeAround)) != I(0)).all();
    isFar = (extent & I(uint32_t(light::kNodeInfinite))) != I(0);
  }
  KN_INLINE Mask<W> isByPower(const Receiver<W>& r) const {
    return HWY_NAMESPACE::isByPower<W>(r, near) & !isFar & !isLeaf<W>(child);
  }
  KN_INLINE Float<W> importance(const Receiver<W>& r) const {
    Float<W> w = nearImportance<W>(r, near);
    if (isFar.any()) {
      const Float<W> concentration = root<W>(dot(near.center, near.center));
      w = select(isFar, farImportance<W>(r, near.center, concentration, near.weight), w);
    }
    return usable(w);
  }
};
// Two siblings by lane, from the first one's index.
template <int W>
struct PairWords {
  union {
    Float<W> words[16];  // all are set: not to zero first
  };
  KN_INLINE PairWords(const TreeNode* nodes, Int<W> at) {
    alignas(64) uint32_t node[W];
    at.store(node);
    const float* from[W];
    for (int k = 0; k < W; ++k) from[k] = nodes[node[k]].center;
    for (size_t k = 0; k < 16; k += 4) {
      loadFours<W>(from, words + k);
      for (const float*& f : from) f += 4;
    }
  }
};
template <int W>
struct NodePair {
  InnerNode<W> first, second;
  KN_INLINE NodePair(const TreeNode* nodes, Int<W> at) : NodePair(PairWords<W>(nodes, at)) {}
  KN_INLINE explicit NodePair(const PairWords<W>& w)
      : first([&](int32_t k) HWY_ATTR { return w.words[k]; }),
        second([&](int32_t k) HWY_ATTR { return w.words[8 + k]; }) {}
};
template <int W>
KN_INLINE InnerNode<W> nodeOfAll(const TreeNode* nodes, uint32_t node) {
  const float* words = nodes[node].center;
  return InnerNode<W>([&](int32_t k) HWY_ATTR { return Float<W>(words[k]); });
}

// Which lanes' sets hold something of the node.
template <int W>
struct Links {
  const light::LinkSets& sets;
  bool all;
  Int<W> first;  // run of the lane's set
  KN_INLINE Links(const ChooseArgs& a, const Slots<W>& s)
      : Links(a, !a.links->areAllWhole() && a.linkSet ? s.get(a.linkSet) : Int<W>(0)) {}
  KN_INLINE Links(const ChooseArgs& a, Int<W> set) : sets(*a.links), all(sets.areAllWhole()), first(0) {
    if (!all) first = set * Int<W>(sets.runsOfSet());
  }
  KN_INLINE Float<W> keep(Int<W> node, Float<W> importance) const {
    using I = Int<W>;
    if (all) return importance;
    alignas(64) static constexpr uint32_t kBit[32] = {
        1u << 0,  1u << 1,  1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,  1u << 8,  1u << 9,  1u << 10,
        1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15, 1u << 16, 1u << 17, 1u << 18, 1u << 19, 1u << 20, 1u << 21,
        1u << 22, 1u << 23, 1u << 24, 1u << 25, 1u << 26, 1u << 27, 1u << 28, 1u << 29, 1u << 30, 1u << 31};
    const I run = gather(sets.runs(), first + node.template shr<int(light::LinkSets::kRunBits)>());
    const I word = gather(sets.words(), run + (node & I((1u << light::LinkSets::kRunBits) - 1)).template shr<5>());
    return zeroUnless((word & gather(kBit, node & I(31))) != I(0), importance);
  }
};

// Probabilities of the top nodes.
template <int W>
struct Top {
  // of as many as the tree has: the arrays are not to be set to zero first
  union {
    Float<W> p[light::kMostTop];
  };
  union {
    Mask<W> byPower[light::kMostTop];
  };
  union {
    Float<W> plain[light::kMostTop];  // importances without factors
  };
  Float<W> plainTotal;
  KN_INLINE Top(const ChooseArgs& a, const Receiver<W>& r, const Links<W>& links, const Slots<W>& s) {
    using F = Float<W>;
    const LightTree& tree = *a.tree;
    const uint32_t count = tree.topCount();
    F total(0.f);
    plainTotal = F(0.f);
    for (uint32_t k = 0; k < count; ++k) {
      const TopNode& t = tree.top()[k];
      p[k] = links.keep(Int<W>(t.node), topImportance<W>(r, t, byPower[k]));
      if (a.weights) {
        plain[k] = p[k];
        plainTotal += p[k];
        p[k] = p[k] * gather(a.weights, s.get(a.row) * Int<W>(light::kMostTop) + Int<W>(k));
      }
      total += p[k];
    }
    F scale = F(1.f) / max(total, F(1e-37f));
    total = F(0.f);
    for (uint32_t k = 0; k < count; ++k) {
      const F share = p[k] * scale;
      p[k] = fma(root<W>(share), F(light::kRootShare), share);
      total += p[k];
    }
    scale = F(1.f) / max(total, F(1e-37f));
    for (uint32_t k = 0; k < count; ++k) p[k] = p[k] * scale;
  }
};

// Neither child that reaches the point is left without a chance by rounding.
template <int W>
KN_INLINE Float<W> shareOfFirst(Float<W> w0, Float<W> w1, Float<W> total) {
  using F = Float<W>;
  const F p = w0 / max(total, F(1e-37f)), least(1e-6f);
  return clamp(p, zeroUnless(w0 > F(0.f), least), F(1.f) - zeroUnless(w1 > F(0.f), least));
}

// Points on their way down, word by word in arrays of their own and side by side, so that a step loads and stores
// vectors. Which point stands where does not matter.
enum WalkWord : uint32_t {
  kX,
  kWidth,
  kSpare,
  kP,
  kSlot,
  kChild,
  kEnd,
  kStart,
  kPx,
  kPy,
  kPz,
  kNx,
  kNy,
  kNz,
  kSet,
  kWalkWords
};
static_assert(kWalkWords == light::ChooseScratch::kWords);
struct Walkers {
  float* words;
  uint32_t room;
  float* operator[](uint32_t word) const { return words + size_t(word) * room; }
  uint32_t* numbers(uint32_t word) const { return reinterpret_cast<uint32_t*>(words + size_t(word) * room); }
};

// Where a walk is: the numbers that are left to it, and how likely it came there.
template <int W>
struct Walk {
  Float<W> x, width, spare, p;  // x below width; spare: another number below 1, or -1
  Int<W> slot;
  KN_INLINE Walk(const Walkers& w, uint32_t i)
      : x(Float<W>::load(w[kX] + i)),
        width(Float<W>::load(w[kWidth] + i)),
        spare(Float<W>::load(w[kSpare] + i)),
        p(Float<W>::load(w[kP] + i)),
        slot(Int<W>::load(w.numbers(kSlot) + i)) {}
  KN_INLINE void pack(const Packer<W>& k, const Walkers& w, uint32_t at) const {
    k.put(x, w[kX] + at);
    k.put(width, w[kWidth] + at);
    k.put(spare, w[kSpare] + at);
    k.put(p, w[kP] + at);
    k.put(slot, w.numbers(kSlot) + at);
  }
  // Which of two siblings of these importances it goes to; p 0: to none.
  KN_INLINE Mask<W> step(Float<W> w0, Float<W> w1) {
    using F = Float<W>;
    const F one(1.f), zero(0.f), total = w0 + w1, p0 = shareOfFirst(w0, w1, total);
    const F first = width * p0, second = width - first;
    const Mask<W> takesFirst = x < first;
    p = zeroUnless(total > zero, p * select(takesFirst, p0, one - p0));
    x = select(takesFirst, x, min(x - first, second * F(0.99999994f)));
    width = select(takesFirst, first, second);
    // a number's digits are used up: the other one's remain
    const Mask<W> change = (width < F(1.f / 4096)) & (spare >= zero);
    x = select(change, spare, x);
    width = select(change, one, width);
    spare = select(change, F(-1.f), spare);
    return takesFirst;
  }
  // The end of it.
  KN_INLINE void finish(Mask<W> m, Int<W> child, const ChooseArgs& a) const {
    alignas(64) uint32_t lights[W], slots[W];
    alignas(64) float ps[W];
    child.store(lights);
    slot.store(slots);
    p.store(ps);
    for (uint32_t b = m.bits(); b; b &= b - 1) {
      const int k = __builtin_ctz(b);
      put(a, slots[k], lights[k] & ~light::kLeaf, ps[k]);
    }
  }
  static KN_INLINE void put(const ChooseArgs& a, uint32_t slot, uint32_t light, float p) {
    a.probability[slot] = p;
    a.light[slot] = light;
    __builtin_prefetch(static_cast<const char*>(a.data) + size_t(light) * a.dataSize);
  }
};

// What a walk that looks at nodes needs beside.
template <int W>
struct Lit {
  Vec3<W> P, N;
  Int<W> set;
  const bool hasN, hasSet;
  KN_INLINE Lit(const ChooseArgs& a, const Walkers& w, uint32_t i)
      : P(Float<W>::load(w[kPx] + i), Float<W>::load(w[kPy] + i), Float<W>::load(w[kPz] + i)),
        N(Float<W>(0.f), Float<W>(0.f), Float<W>(0.f)),
        set(0),
        hasN(a.N[0] != nullptr),
        hasSet(!a.links->areAllWhole() && a.linkSet) {
    if (hasN) N = {Float<W>::load(w[kNx] + i), Float<W>::load(w[kNy] + i), Float<W>::load(w[kNz] + i)};
    if (hasSet) set = Int<W>::load(w.numbers(kSet) + i);
  }
  KN_INLINE void pack(const Packer<W>& k, const Walkers& w, uint32_t at) const {
    float* const p[3] = {w[kPx], w[kPy], w[kPz]};
    P.pack(k, p, at);
    float* const n[3] = {w[kNx], w[kNy], w[kNz]};
    if (hasN) N.pack(k, n, at);
    if (hasSet) k.put(set, w.numbers(kSet) + at);
  }
  // Of those that are somebody's: what stands behind a list names no set.
  KN_INLINE Links<W> links(const ChooseArgs& a, Mask<W> in) const { return Links<W>(a, select(in, set, Int<W>(0))); }
  KN_INLINE Receiver<W> receiver() const { return hasN ? Receiver<W>(P, N) : Receiver<W>(P); }
};

// Points side by side that are below one node: its first child, where the nodes below it end, its first light.
struct Part {
  uint32_t child, end, start, from, to;
};
// Of the nodes below one, from its first child on: each light but one has a pair of its own.
KN_INLINE uint32_t lightsBelow(uint32_t child, uint32_t end) {
  return child & light::kLeaf ? 1 : ((end - child) >> 1) + 1;
}

// A few points from one list to the end of another.
template <int W>
KN_INLINE void append(const Walkers& from, const Part& part, const Walkers& to, uint32_t& n) {
  const uint32_t count = part.to - part.from;
  for (uint32_t k = 0; k < kWalkWords; ++k)
    for (uint32_t i = 0; i < count; i += W) Float<W>::load(from[k] + part.from + i).store(to[k] + n + i);
  for (uint32_t i = 0; i < count; i += W) {
    Int<W>(part.child).store(to.numbers(kChild) + n + i);
    Int<W>(part.end).store(to.numbers(kEnd) + n + i);
    Int<W>(part.start).store(to.numbers(kStart) + n + i);
  }
  n += count;
}

// All that the walks hold, from the beginning of one list to a place in another.
template <int W>
KN_INLINE void move(const ChooseArgs& a, const Walkers& from, uint32_t count, const Walkers& to, uint32_t at) {
  for (uint32_t i = 0; i < count; i += W) {
    const Packer<W> all(Mask<W>(true));
    Walk<W>(from, i).pack(all, to, at + i);
    Lit<W>(a, from, i).pack(all, to, at + i);
  }
}

// Down from the top nodes, whose points begin[k] says, all of a node's points together while they are many:
// neighbours go the same way, and a node is then read once for all of them. Level by level, so that nodes arrive from
// memory while others are weighed. Points that are left with few are added to `alone`, those below a node that is far
// for them to `byPower`.
template <int W>
void walkTogether(const ChooseArgs& a, const TreeNode* nodes, const uint32_t* begin, Walkers now, Walkers then,
                  const Walkers& behind, const Walkers& alone, uint32_t& few, const Walkers& byPower, uint32_t& far) {
  using F = Float<W>;
  using I = Int<W>;
  constexpr uint32_t kFew = 8;
  const light::ChooseScratch& c = a.scratch;
  Part* level = reinterpret_cast<Part*>(c.parts);
  Part* next = level + a.n;
  uint32_t count = 0, coming = 0;
  const auto add = [&](const Walkers& w, Part* parts, uint32_t& n, const Part& part) HWY_ATTR {
    const uint32_t size = part.to - part.from;
    if (!size) return;
    if (part.child & light::kLeaf) {
      for (uint32_t i = part.from; i < part.to; ++i) {
        const uint32_t slot = w.numbers(kSlot)[i];
        Walk<W>::put(a, slot, part.child & ~light::kLeaf, w[kP][i]);
      }
      return;
    }
    __builtin_prefetch(nodes + part.child);
    if (size > kFew)
      parts[n++] = part;
    else
      append<W>(w, part, alone, few);
  };
  for (uint32_t k = 0; k < a.tree->topCount(); ++k) {
    const TopNode& t = a.tree->top()[k];
    add(now, level, count, {nodes[t.node].child, t.end, t.start, begin[k], begin[k + 1]});
  }
  for (uint32_t q = 0; q < count || coming; ++q) {
    if (q == count) {
      std::swap(level, next);
      std::swap(now, then);
      count = coming;
      coming = q = 0;
    }
    const Part part = level[q];
    const InnerNode<W> first = nodeOfAll<W>(nodes, part.child), second = nodeOfAll<W>(nodes, part.child + 1);
    const uint32_t secondChild = nodes[part.child + 1].child;
    const uint32_t firstEnd = secondChild & light::kLeaf ? part.end : secondChild;
    const uint32_t secondStart = part.start + lightsBelow(nodes[part.child].child, firstEnd);
    // those that go to the second are kept behind until it is known where they begin
    uint32_t m0 = part.from, m1 = 0;
    for (uint32_t i = part.from; i < part.to; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(part.to - i < W ? part.to - i : W));
      const Lit<W> lit(a, now, i);
      const Receiver<W> r = lit.receiver();
      const Links<W> links = lit.links(a, in);
      const F w0 = links.keep(I(part.child), first.importance(r));
      const F w1 = links.keep(I(part.child + 1), second.importance(r));
      Walk<W> walk(now, i);
      const Mask<W> takesFirst = walk.step(w0, w1);
      Mask<W> on = in & (walk.p > F(0.f));
      walk.finish(in & !(walk.p > F(0.f)), I(part.child), a);
      if (links.all) {
        const Mask<W> away = on & ((takesFirst & first.isByPower(r)) | ((!takesFirst) & second.isByPower(r)));
        if (away.any()) {
          const Packer<W> k(away);
          walk.pack(k, byPower, far);
          k.put(select(takesFirst, first.child, second.child), byPower.numbers(kChild) + far);
          k.put(select(takesFirst, I(firstEnd), I(part.end)), byPower.numbers(kEnd) + far);
          k.put(select(takesFirst, I(part.start), I(secondStart)), byPower.numbers(kStart) + far);
          far += uint32_t(k.count);
          on = on & !away;
        }
      }
      const Packer<W> left(on & takesFirst), right(on & (!takesFirst));
      walk.pack(left, then, m0);
      lit.pack(left, then, m0);
      m0 += uint32_t(left.count);
      walk.pack(right, behind, m1);
      lit.pack(right, behind, m1);
      m1 += uint32_t(right.count);
    }
    move<W>(a, behind, m1, then, m0);
    add(then, next, coming, {nodes[part.child].child, firstEnd, part.start, part.from, m0});
    add(then, next, coming, {secondChild, part.end, secondStart, m0, m0 + m1});
  }
}

// To one of two siblings: where the nodes below it end, and which is its first light.
template <int W>
KN_INLINE void goDown(const NodePair<W>& pair, Mask<W> takesFirst, Int<W>& end, Int<W>& start) {
  using I = Int<W>;
  const I firstEnd = select(isLeaf<W>(pair.second.child), end, pair.second.child);
  const I lights = (firstEnd - pair.first.child).template shr<1>() + I(1);
  start = select(takesFirst, start, start + select(isLeaf<W>(pair.first.child), I(1), lights));
  end = select(takesFirst, firstEnd, end);
}

template <int W>
KN_INLINE void fetch(const TreeNode* nodes, Int<W> child) {
  alignas(64) uint32_t wanted[W];
  child.store(wanted);
  for (int k = 0; k < W; ++k) __builtin_prefetch(nodes + (wanted[k] & light::kLeaf ? 0 : wanted[k]));
}

// The same for points that are each at a place of their own: step by step for all of them, so that nodes arrive from
// memory while others are weighed.
template <int W>
void walkAlone(const ChooseArgs& a, const TreeNode* nodes, Walkers now, Walkers then, uint32_t few,
               const Walkers& byPower, uint32_t& far) {
  using F = Float<W>;
  using I = Int<W>;
  while (few) {
    uint32_t m = 0;
    for (uint32_t i = 0; i < few; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(few - i < W ? few - i : W));
      const Lit<W> lit(a, now, i);
      const Receiver<W> r = lit.receiver();
      const Links<W> links = lit.links(a, in);
      Walk<W> walk(now, i);
      // what lies behind the list is no node
      const I at = select(in, I::load(now.numbers(kChild) + i), I(0));
      const NodePair<W> pair(nodes, at);
      const Mask<W> takesFirst =
          walk.step(links.keep(at, pair.first.importance(r)), links.keep(at + I(1), pair.second.importance(r)));
      const I child = select(takesFirst, pair.first.child, pair.second.child);
      I end = I::load(now.numbers(kEnd) + i), start = I::load(now.numbers(kStart) + i);
      goDown<W>(pair, takesFirst, end, start);
      Mask<W> on = in & (!isLeaf<W>(child)) & (walk.p > F(0.f));
      walk.finish(in & !on, child, a);
      if (links.all) {
        const Mask<W> away =
            on & ((takesFirst & pair.first.isByPower(r)) | ((!takesFirst) & pair.second.isByPower(r)));
        const Packer<W> k(away);
        walk.pack(k, byPower, far);
        k.put(child, byPower.numbers(kChild) + far);
        k.put(end, byPower.numbers(kEnd) + far);
        k.put(start, byPower.numbers(kStart) + far);
        far += uint32_t(k.count);
        on = on & !away;
      }
      const Packer<W> k(on);
      walk.pack(k, then, m);
      lit.pack(k, then, m);
      k.put(child, then.numbers(kChild) + m);
      k.put(end, then.numbers(kEnd) + m);
      k.put(start, then.numbers(kStart) + m);
      m += uint32_t(k.count);
      fetch<W>(nodes, child);
    }
    std::swap(now, then);
    few = m;
  }
}

// Lights below a node for which only power tells, by the sums of what they have.
template <int W>
struct PowerRange {
  Int<W> first, last, from, units;  // from, units: of the sums
  KN_INLINE PowerRange(const LightTree& tree, Int<W> child, Int<W> end, Int<W> start)
      : first(start),
        last(start + (end - child).template shr<1>() + Int<W>(1)),
        from(sum(tree, first)),
        units(sum(tree, last) - from) {}
  static KN_INLINE Int<W> sum(const LightTree& tree, Int<W> at) {
    return gather(&tree.powers()->sum, at.template shl<1>());
  }
  static KN_INLINE Int<W> unitsOf(const LightTree& tree, Int<W> at) {
    return sum(tree, at + Int<W>(1)) - sum(tree, at);
  }
};

// floor(a b / 2^31) of numbers in [0, 2^31).
template <int W>
KN_INLINE Int<W> scaled(Int<W> a, Int<W> b) {
  if constexpr (W == 1) {
    return Int<W>(uint32_t(uint64_t(uint32_t(a.lane0())) * uint32_t(b.lane0()) >> 31));
  } else {
    const typename Int<W>::DU du;
    const hn::RepartitionToWide<decltype(du)> wide;
    const auto x = hn::BitCast(du, a.template shl<1>().v), y = hn::BitCast(du, b.v);
    const auto even = hn::ShiftRight<32>(hn::MulEven(x, y));
    const auto odd = hn::MulEven(hn::BitCast(du, hn::ShiftRight<32>(hn::BitCast(wide, x))),
                                 hn::BitCast(du, hn::ShiftRight<32>(hn::BitCast(wide, y))));
    return Int<W>(hn::BitCast(typename Int<W>::D(), hn::OddEven(hn::BitCast(du, odd), hn::BitCast(du, even))));
  }
}

template <int W, class T>
KN_INLINE void fetchEach(const T* base, Int<W> at) {
  alignas(64) uint32_t wanted[W];
  at.store(wanted);
  for (int k = 0; k < W; ++k) __builtin_prefetch(base + wanted[k]);
}

// The rest of the way where only power tells lights apart, in one leap: to where a number falls among the sums. In
// three passes, so that what one needs comes from memory while others do theirs.
template <int W>
void leapByPower(const ChooseArgs& a, const Walkers& walkers, uint32_t far) {
  using F = Float<W>;
  using I = Int<W>;
  const LightTree& tree = *a.tree;
  const auto bucketOf = [&](I at) HWY_ATTR { return I(hn::ShiftRightSame(at.v, int(tree.guideShift()))); };
  uint32_t *const wanted = walkers.numbers(kX), *const lows = walkers.numbers(kSpare);
  uint32_t *const firsts = walkers.numbers(kStart), *const lasts = walkers.numbers(kEnd);
  // what stands behind the list is no place
  const auto orZero = [&](uint32_t i, auto x) HWY_ATTR {
    return select(Mask<W>::firstN(int(far - i < W ? far - i : W)), x, decltype(x)(0));
  };
  for (uint32_t i = 0; i < far; i += W) {
    const Walk<W> walk(walkers, i);
    const auto word = [&](WalkWord k) HWY_ATTR { return orZero(i, I::load(walkers.numbers(k) + i)); };
    const PowerRange<W> range(tree, word(kChild), word(kEnd), word(kStart));
    // 31 bits: those that the number has left, and behind them the other one's
    const F inverse = F(1.f) / max(walk.width, F(1e-37f));
    const F x = min(max(orZero(i, walk.x * inverse), F(0.f)), F(0.99999994f));
    const F rest = max(orZero(i, walk.spare), F(0.f)) * min(F(128.f) * inverse, F(524288.f));
    const I number = toInt(x * F(16777216.f)).template shl<7>() + toInt(rest);
    const I at = range.from + scaled<W>(select(number < I(0), I(0x7fffffff), number), range.units);
    fetchEach<W>(tree.guide(), bucketOf(at));
    at.store(wanted + i);
    range.first.store(firsts + i);
    range.last.store(lasts + i);
    toFloat(range.units).store(walkers[kWidth] + i);
  }
  for (uint32_t i = 0; i < far; i += W) {
    const I bucket = bucketOf(I::load(wanted + i));
    const I low = larger(I::load(firsts + i), gather(tree.guide(), bucket));
    smaller(I::load(lasts + i), gather(tree.guide(), bucket + I(1)) + I(1)).store(lasts + i);
    fetchEach<W>(tree.powers(), low);
    low.store(lows + i);
  }
  for (uint32_t i = 0; i < far; i += W) {
    const I at = I::load(wanted + i);
    // the last whose sum begins at or below it
    I low = I::load(lows + i), high = I::load(lasts + i);
    while ((high > low + I(1)).any()) {
      const I middle = (low + high).template shr<1>();
      const Mask<W> isAbove = PowerRange<W>::sum(tree, middle) > at;
      low = select(isAbove, low, middle);
      high = select(isAbove, middle, high);
    }
    Walk<W> walk(walkers, i);
    walk.p = walk.p * (toFloat(PowerRange<W>::unitsOf(tree, low)) / walk.width);
    walk.finish(Mask<W>::firstN(int(far - i < W ? far - i : W)), gather(&tree.powers()->light, low.template shl<1>()),
                a);
  }
}

template <int W>
void choose(const ChooseArgs& a) {
  using F = Float<W>;
  using I = Int<W>;
  const LightTree& tree = *a.tree;
  const TreeNode* nodes = tree.nodes();
  const bool isDeep = tree.isDeep();
  const light::ChooseScratch& c = a.scratch;
  const auto walkers = [&](uint32_t k) { return Walkers{c.words + size_t(k) * kWalkWords * c.room, c.room}; };
  const Walkers now = walkers(0), then = walkers(1), behind = walkers(2), alone = walkers(3), byPower = walkers(4);
  uint32_t few = 0, far = 0;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> s(I::lanes(int32_t(i)));
    const Receiver<W> r(a, s);
    const Links<W> links(a, s);
    const Top<W> top(a, r, links, s);
    Mask<W> isFar(false);
    const F u = F::load(a.u[0] + i);
    F below(0.f), from(0.f), p(0.f), importance(1.f);
    I child(-1), which(0), end(0), start(0);
    // the last that begins at or below u
    for (uint32_t k = 0; k < tree.topCount(); ++k) {
      const Mask<W> is = (top.p[k] > F(0.f)) & (below <= u);
      child = select(is, I(nodes[tree.top()[k].node].child), child);
      which = select(is, I(k), which);
      end = select(is, I(tree.top()[k].end), end);
      start = select(is, I(tree.top()[k].start), start);
      isFar = (is & top.byPower[k]) | (isFar & !is);
      from = select(is, below, from);
      p = select(is, top.p[k], p);
      if (a.weights) importance = select(is, top.plain[k], importance);
      below += top.p[k];
    }
    if (a.top) {
      which.store(a.top + i);
      (p * top.plainTotal / max(importance, F(1e-30f))).store(a.chance + i);
    }
    p.store(a.probability + i);
    if (!isDeep) {
      select(p > F(0.f), child & I(uint32_t(~light::kLeaf)), I(uint32_t(light::kNone))).store(a.light + i);
      continue;
    }
    child.store(a.light + i);
    // for the last steps
    const F spare = min(max((u - from) / max(p, F(1e-37f)), F(0.f)), F(0.99999994f));
    if (links.all) {
      isFar = isFar & (p > F(0.f)) & (!isLeaf<W>(child));
      const Packer<W> away(isFar);
      away.put(F::load(a.u[1] + i), byPower[kX] + far);
      away.put(spare, byPower[kSpare] + far);
      away.put(F(1.f), byPower[kWidth] + far);
      away.put(p, byPower[kP] + far);
      away.put(s.s, byPower.numbers(kSlot) + far);
      away.put(child, byPower.numbers(kChild) + far);
      away.put(end, byPower.numbers(kEnd) + far);
      away.put(start, byPower.numbers(kStart) + far);
      far += uint32_t(away.count);
      which = select(isFar, I(light::kMostTop), which);
    }
    select(p > F(0.f), which, I(light::kMostTop)).store(then.numbers(kChild) + i);
    spare.store(then[kSpare] + i);
  }
  if (!isDeep) return;
  // by top node
  const uint32_t* which = then.numbers(kChild);
  uint32_t begin[light::kMostTop + 2] = {}, at[light::kMostTop + 1];
  for (uint32_t i = 0; i < a.n; ++i) ++begin[which[i] + 1];
  for (uint32_t k = 0; k <= light::kMostTop; ++k) begin[k + 1] += begin[k];
  for (uint32_t k = 0; k <= light::kMostTop; ++k) at[k] = begin[k];
  for (uint32_t i = 0; i < a.n; ++i) now.numbers(kSlot)[at[which[i]]++] = i;
  const uint32_t walking = begin[light::kMostTop];
  for (uint32_t i = 0; i < walking; i += W) {
    const Slots<W> s = Slots<W>::loadUpTo(now.numbers(kSlot) + i, a.n - i);
    s.get(a.u[1]).store(now[kX] + i);
    s.get(then[kSpare]).store(now[kSpare] + i);
    F(1.f).store(now[kWidth] + i);
    s.get(a.probability).store(now[kP] + i);
    for (uint32_t k = 0; k < 3; ++k) {
      s.get(a.P[k]).store(now[kPx + k] + i);
      if (a.N[0]) s.get(a.N[k]).store(now[kNx + k] + i);
    }
    if (!a.links->areAllWhole() && a.linkSet) s.get(a.linkSet).store(now.numbers(kSet) + i);
  }
  walkTogether<W>(a, nodes, begin, now, then, behind, alone, few, byPower, far);
  walkAlone<W>(a, nodes, alone, now, few, byPower, far);
  leapByPower<W>(a, byPower, far);
  for (uint32_t i = 0; i < a.n; ++i) a.light[i] = a.probability[i] > 0 ? a.light[i] : light::kNone;
}

template <int W>
void probability(const ChooseArgs& a) {
  using F = Float<W>;
  using I = Int<W>;
  const LightTree& tree = *a.tree;
  const TreeNode* nodes = tree.nodes();
  const uint32_t* places = &tree.places().data()->leaf;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> s(I::lanes(int32_t(i)));
    const Receiver<W> r(a, s);
    const Links<W> links(a, s);
    const Top<W> top(a, r, links, s);
    const I place = I::load(a.light + i) * I(3);
    const I leaf = gather(places, place);
    I path = gather(places, place + I(1));
    const I position = gather(places, place + I(2));
    const Mask<W> lit = leaf != I(uint32_t(light::kNone));
    F p(0.f);
    I child(-1), end(0), start(0);
    Mask<W> byPower(false);
    // the last that begins at or before the light
    for (uint32_t k = 0; k < tree.topCount(); ++k) {
      const Mask<W> is = lit & (position >= I(tree.top()[k].start));
      p = select(is, top.p[k], p);
      if (links.all) byPower = (is & top.byPower[k]) | (byPower & !is);
      start = select(is, I(tree.top()[k].start), start);
      child = select(is, I(nodes[tree.top()[k].node].child), child);
      end = select(is, I(tree.top()[k].end), end);
    }
    if (tree.isDeep()) {
      const F one(1.f), zero(0.f);
      const Mask<W> inner = (p > zero) & !isLeaf<W>(child);
      byPower = byPower & inner;
      Mask<W> open = inner & !byPower;
      while (open.any()) {
        const I first = select(open, child, I(0));
        const NodePair<W> pair(nodes, first);
        const F w0 = links.keep(first, pair.first.importance(r)),
                w1 = links.keep(first + I(1), pair.second.importance(r));
        const F total = w0 + w1, p0 = shareOfFirst(w0, w1, total);
        const Mask<W> takesFirst = (path & I(1)) == I(0);
        p = select(open, zeroUnless(total > zero, p * select(takesFirst, p0, one - p0)), p);
        child = select(open, select(takesFirst, pair.first.child, pair.second.child), child);
        I newEnd = end, newStart = start;
        goDown<W>(pair, takesFirst, newEnd, newStart);
        end = select(open, newEnd, end);
        start = select(open, newStart, start);
        path = path.template shr<1>();
        open = open & !isLeaf<W>(child) & (p > zero);
        if (links.all) {
          const Mask<W> away =
              open & ((takesFirst & pair.first.isByPower(r)) | ((!takesFirst) & pair.second.isByPower(r)));
          byPower = byPower | away;
          open = open & !away;
        }
      }
      if (byPower.any()) {
        const I none(0);
        const PowerRange<W> range(tree, select(byPower, child, none), select(byPower, end, none),
                                  select(byPower, start, none));
        const Float<W> share = toFloat(range.unitsOf(tree, select(byPower, position, none))) / toFloat(range.units);
        p = select(byPower, p * share, p);
      }
    }
    p.store(a.probability + i);
  }
}

#if HWY_TARGET == HWY_AVX2
#define KN_CHOOSE(W)                                                     \
  [[maybe_unused]] void choose##W(const ChooseArgs& a) { choose<W>(a); } \
  [[maybe_unused]] void probability##W(const ChooseArgs& a) { probability<W>(a); }
KN_CHOOSE(1)
KN_CHOOSE(4)
KN_CHOOSE(8)
#else
[[maybe_unused]] void choose16(const ChooseArgs& a) { choose<16>(a); }
[[maybe_unused]] void probability16(const ChooseArgs& a) { probability<16>(a); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::light {
ChooseKernel chooseKernel(uint32_t width) {
  return kernelFor(width, &N_AVX2::choose1, &N_AVX2::choose4, &N_AVX2::choose8, &N_AVX3::choose16);
}
ChooseKernel probabilityKernel(uint32_t width) {
  return kernelFor(width, &N_AVX2::probability1, &N_AVX2::probability4, &N_AVX2::probability8,
                   &N_AVX3::probability16);
}
}  // namespace kinora::light
#endif
