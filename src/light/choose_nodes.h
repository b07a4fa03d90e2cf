// What the nodes of the light tree bring to W points, and with which probabilities they are taken.
// Included per target.
#include "light/choose.h"

#include <kinora/simd/records.h>
#include <kinora/simd/wide.h>

#if defined(KINORA_LIGHT_CHOOSE_NODES_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LIGHT_CHOOSE_NODES_H_TARGET
#undef KINORA_LIGHT_CHOOSE_NODES_H_TARGET
#else
#define KINORA_LIGHT_CHOOSE_NODES_H_TARGET
#endif

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

// To one of two siblings: where the nodes below it end, and which is its first light.
template <int W>
KN_INLINE void goDown(const NodePair<W>& pair, Mask<W> takesFirst, Int<W>& end, Int<W>& start) {
  using I = Int<W>;
  const I firstEnd = select(isLeaf<W>(pair.second.child), end, pair.second.child);
  const I lights = (firstEnd - pair.first.child).template shr<1>() + I(1);
  start = select(takesFirst, start, start + select(isLeaf<W>(pair.first.child), I(1), lights));
  end = select(takesFirst, firstEnd, end);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
