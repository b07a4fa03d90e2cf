// Kernels of choose.h.
#define KINORA_KERNEL_FILE "light/choose.cpp"
#include "light/choose.h"

#include <utility>

#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/simd/wide.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using light::ChooseArgs;
using light::TopNode;
using light::TreeNode;

// A surface lit from behind its normal's plane: bumps lean over it, and leaves let light through.
constexpr float kLeastFacing = 0.03f, kLeastFacingThrough = 0.3f;

template <int W>
struct Receiver {
  Vec3<W> P, N;  // N: unit, or zero where light from all sides counts alike
  Float<W> least;
  Mask<W> hasN;
  KN_INLINE Receiver(const ChooseArgs& a, const Slots<W>& s) {
    using F = Float<W>;
    P = Vec3<W>::get(a.P, s);
    N = Vec3<W>(F(0.f), F(0.f), F(0.f));
    least = F(1.f);
    hasN = Mask<W>(false);
    if (!a.N[0]) return;
    N = Vec3<W>::get(a.N, s);
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

// About the irradiance that the lights below a node bring: intensity, falloff and cosine over the squared distance. 0
// only where none of them reaches the point; of falloff and cosine the mean of what the box's centre has and of the
// most that any place in the box could have: the greatest height of the box over the plane, and the least distance.
template <int W>
KN_INLINE Float<W> nearImportance(const Receiver<W>& r, const WideNode<W>& n) {
  using F = Float<W>;
  const F zero(0.f), one(1.f), half(0.5f), tiny(1e-30f);
  const Vec3<W> v = n.center - r.P, distance = absolute(v);
  const Vec3<W> beyond = distance - n.half, farthest = distance + n.half;
  const Vec3<W> nearest(max(beyond.x, zero), max(beyond.y, zero), max(beyond.z, zero));
  const F d2 = dot(v, v), inverse = inverseRoot<W>(max(d2, tiny));
  const F least2 = dot(nearest, nearest), inverseLeast = inverseRoot<W>(max(least2, tiny));
  const Mask<W> inside = least2 <= tiny;
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
  const F emitted = zeroUnless(mostEmitted + F(kRootSlack) >= n.cosEmission,
                               max(half * (max(mostEmitted, zero) + max(past(mean), zero)), F(1e-3f)));
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
  byPower = isByPower<W>(r, n);
  return usable(nearImportance<W>(r, n));
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
template <int W>
KN_INLINE InnerNode<W> nodeOfLanes(const TreeNode* nodes, Int<W> node) {
  const Int<W> at = node.template shl<3>();
  return InnerNode<W>([&](int32_t k) HWY_ATTR { return gather(nodes->center, at + Int<W>(k)); });
}
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
  KN_INLINE Links(const ChooseArgs& a, const Slots<W>& s) : sets(*a.links), all(a.links->areAllWhole()), first(0) {
    if (!all && a.linkSet) first = s.get(a.linkSet) * Int<W>(sets.runsOfSet());
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
  Float<W> p[light::kMostTop];
  Mask<W> byPower[light::kMostTop];
  Float<W> plain[light::kMostTop], plainTotal;  // importances without factors
  KN_INLINE Top(const ChooseArgs& a, const Receiver<W>& r, const Links<W>& links, const Slots<W>& s) {
    using F = Float<W>;
    const light::LightTree& tree = *a.tree;
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

// A point on its way down.
template <int W>
struct Walk {
  Float<W> x, spare, spent, p;
  KN_INLINE Walk(const ChooseArgs& a, const Slots<W>& s)
      : x(s.get(a.scratch.x)),
        spare(s.get(a.scratch.spare)),
        spent(s.get(a.scratch.spent)),
        p(s.get(a.probability)) {}
  KN_INLINE void put(Mask<W> in, const ChooseArgs& a, const Slots<W>& s) const {
    s.put(in, x, a.scratch.x);
    s.put(in, spent, a.scratch.spent);
    s.put(in, p, a.probability);
  }
  // Which of two siblings of these importances it goes to; p 0: to none.
  KN_INLINE Mask<W> step(Float<W> w0, Float<W> w1) {
    using F = Float<W>;
    const F one(1.f), zero(0.f), total = w0 + w1, p0 = shareOfFirst(w0, w1, total);
    const Mask<W> takesFirst = x < p0;
    const F share = select(takesFirst, p0, one - p0);
    x = select(takesFirst, x, x - p0) / max(share, F(1e-37f));
    x = min(max(x, zero), F(0.99999994f));
    p = zeroUnless(total > zero, p * share);
    // a number's digits are used up: the other one's remain
    spent = spent * share;
    const Mask<W> change = spent < F(1.f / 4096);
    x = select(change, spare, x);
    spent = select(change, F(1e30f), spent);
    return takesFirst;
  }
};

// Points of the list that are below one node.
struct Part {
  uint32_t child, from, to;
};

// Down from the top nodes, whose points begin[k] says, all of a node's points together while they are many:
// neighbours go the same way, and a node is then read once for all of them. Level by level, so that nodes arrive from
// memory while others are weighed. Points that are left with few are added to scratch.few, those below a node that is
// far for them to scratch.far.
template <int W>
void walkTogether(const ChooseArgs& a, const TreeNode* nodes, const uint32_t* begin, uint32_t& few, uint32_t& far) {
  using F = Float<W>;
  using I = Int<W>;
  constexpr uint32_t kFew = 8;
  const light::ChooseScratch& c = a.scratch;
  Part* level = reinterpret_cast<Part*>(c.parts);
  Part* next = level + a.n;
  uint32_t count = 0, coming = 0;
  const auto add = [&](Part* parts, uint32_t& n, const Part& part) {
    const uint32_t size = part.to - part.from;
    if (!size) return;
    if (part.child & light::kLeaf) {
      for (uint32_t i = part.from; i < part.to; ++i) a.light[c.list[i]] = part.child;
      return;
    }
    __builtin_prefetch(nodes + part.child);
    if (size > kFew) {
      parts[n++] = part;
      return;
    }
    for (uint32_t i = part.from; i < part.to; ++i) {
      a.light[c.list[i]] = part.child;
      c.few[few++] = c.list[i];
    }
  };
  for (uint32_t k = 0; k < a.tree->topCount(); ++k)
    add(level, count, {nodes[a.tree->top()[k].node].child, begin[k], begin[k + 1]});
  for (uint32_t q = 0; q < count || coming; ++q) {
    if (q == count) {
      std::swap(level, next);
      count = coming;
      coming = q = 0;
    }
    const Part part = level[q];
    const InnerNode<W> first = nodeOfAll<W>(nodes, part.child), second = nodeOfAll<W>(nodes, part.child + 1);
    uint32_t m0 = 0, m1 = 0;
    for (uint32_t i = part.from; i < part.to; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(part.to - i < W ? part.to - i : W));
      const Slots<W> s = Slots<W>::loadUpTo(c.list + i, part.to - i);
      const Receiver<W> r(a, s);
      const Links<W> links(a, s);
      const F w0 = links.keep(I(part.child), first.importance(r));
      const F w1 = links.keep(I(part.child + 1), second.importance(r));
      Walk<W> walk(a, s);
      const Mask<W> takesFirst = walk.step(w0, w1);
      walk.put(in, a, s);
      Mask<W> on = in & (walk.p > F(0.f));
      if (links.all) {
        const Mask<W> byPower = on & ((takesFirst & first.isByPower(r)) | ((!takesFirst) & second.isByPower(r)));
        if (byPower.any()) {
          s.put(byPower, select(takesFirst, first.child, second.child), a.light);
          const Packer<W> away(byPower);
          away.put(s.s, c.far + far);
          far += uint32_t(away.count);
          on = on & !byPower;
        }
      }
      const Packer<W> left(on & takesFirst), right(on & (!takesFirst));
      left.put(s.s, c.first + m0);
      m0 += uint32_t(left.count);
      right.put(s.s, c.second + m1);
      m1 += uint32_t(right.count);
    }
    for (uint32_t i = 0; i < m0; ++i) c.list[part.from + i] = c.first[i];
    for (uint32_t i = 0; i < m1; ++i) c.list[part.from + m0 + i] = c.second[i];
    add(next, coming, {nodes[part.child].child, part.from, part.from + m0});
    add(next, coming, {nodes[part.child + 1].child, part.from + m0, part.from + m0 + m1});
  }
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
void walkAlone(const ChooseArgs& a, const TreeNode* nodes, uint32_t few, uint32_t& far) {
  using F = Float<W>;
  using I = Int<W>;
  const light::ChooseScratch& c = a.scratch;
  const uint32_t* list = c.few;
  uint32_t* next = c.first;
  uint32_t* other = c.second;
  while (few) {
    uint32_t m = 0;
    for (uint32_t i = 0; i < few; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(few - i < W ? few - i : W));
      const Slots<W> s = Slots<W>::loadUpTo(list + i, few - i);
      const Receiver<W> r(a, s);
      const Links<W> links(a, s);
      Walk<W> walk(a, s);
      const I at = s.get(a.light);
      const InnerNode<W> first = nodeOfLanes<W>(nodes, at), second = nodeOfLanes<W>(nodes, at + I(1));
      const Mask<W> takesFirst =
          walk.step(links.keep(at, first.importance(r)), links.keep(at + I(1), second.importance(r)));
      const I child = select(takesFirst, first.child, second.child);
      s.put(in, child, a.light);
      walk.put(in, a, s);
      Mask<W> left = in & (!isLeaf<W>(child)) & (walk.p > F(0.f));
      if (links.all) {
        const Mask<W> byPower = left & ((takesFirst & first.isByPower(r)) | ((!takesFirst) & second.isByPower(r)));
        const Packer<W> away(byPower);
        away.put(s.s, c.far + far);
        far += uint32_t(away.count);
        left = left & !byPower;
      }
      const Packer<W> on(left);
      on.put(s.s, next + m);
      m += uint32_t(on.count);
      fetch<W>(nodes, child);
    }
    list = next;
    few = m;
    std::swap(next, other);
  }
}

// Weights of two siblings.
template <int W>
struct Powers {
  Float<W> first, second;
  KN_INLINE Powers(const TreeNode* nodes, Int<W> at) {
    const Int<W> word = at.template shl<3>();
    first = gather(nodes->center, word + Int<W>(3));
    second = gather(nodes->center, word + Int<W>(11));
  }
};

// The rest of the way where only power tells lights apart.
template <int W>
void walkByPower(const ChooseArgs& a, const TreeNode* nodes, uint32_t far) {
  using I = Int<W>;
  const light::ChooseScratch& c = a.scratch;
  const uint32_t* list = c.far;
  uint32_t* next = c.first;
  uint32_t* other = c.second;
  while (far) {
    uint32_t m = 0;
    for (uint32_t i = 0; i < far; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(far - i < W ? far - i : W));
      const Slots<W> s = Slots<W>::loadUpTo(list + i, far - i);
      Walk<W> walk(a, s);
      const I at = s.get(a.light);
      const Powers<W> powers(nodes, at);
      const Mask<W> takesFirst = walk.step(powers.first, powers.second);
      const I child = gather(reinterpret_cast<const uint32_t*>(nodes),
                             select(takesFirst, at, at + I(1)).template shl<3>() + I(7));
      s.put(in, child, a.light);
      walk.put(in, a, s);
      const Packer<W> on(in & (!isLeaf<W>(child)));
      on.put(s.s, next + m);
      m += uint32_t(on.count);
      fetch<W>(nodes, child);
    }
    list = next;
    far = m;
    std::swap(next, other);
  }
}

template <int W>
void choose(const ChooseArgs& a) {
  using F = Float<W>;
  using I = Int<W>;
  const light::LightTree& tree = *a.tree;
  const TreeNode* nodes = tree.nodes();
  const bool isDeep = tree.isDeep();
  const light::ChooseScratch& c = a.scratch;
  uint32_t few = 0, far = 0;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> s(I::lanes(int32_t(i)));
    const Receiver<W> r(a, s);
    const Links<W> links(a, s);
    const Top<W> top(a, r, links, s);
    Mask<W> byPower(false);
    const F u = F::load(a.u[0] + i);
    F below(0.f), from(0.f), p(0.f), importance(1.f);
    I child(-1), which(0);
    // the last that begins at or below u
    for (uint32_t k = 0; k < tree.topCount(); ++k) {
      const Mask<W> is = (top.p[k] > F(0.f)) & (below <= u);
      child = select(is, I(nodes[tree.top()[k].node].child), child);
      which = select(is, I(k), which);
      byPower = (is & top.byPower[k]) | (byPower & !is);
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
    if (links.all) {
      byPower = byPower & (p > F(0.f)) & (!isLeaf<W>(child));
      const Packer<W> away(byPower);
      away.put(s.s, c.far + far);
      far += uint32_t(away.count);
      which = select(byPower, I(light::kMostTop), which);
    }
    which.store(c.second + i);
    F::load(a.u[1] + i).store(c.x + i);
    // for the last steps
    min(max((u - from) / max(p, F(1e-37f)), F(0.f)), F(0.99999994f)).store(c.spare + i);
    F(1.f).store(c.spent + i);
  }
  if (!isDeep) return;
  // by top node
  uint32_t begin[light::kMostTop + 1] = {}, at[light::kMostTop];
  for (uint32_t i = 0; i < a.n; ++i)
    if (a.probability[i] > 0 && c.second[i] < light::kMostTop) ++begin[c.second[i] + 1];
  for (uint32_t k = 0; k < light::kMostTop; ++k) begin[k + 1] += begin[k];
  for (uint32_t k = 0; k < light::kMostTop; ++k) at[k] = begin[k];
  for (uint32_t i = 0; i < a.n; ++i)
    if (a.probability[i] > 0 && c.second[i] < light::kMostTop) c.list[at[c.second[i]]++] = i;
  walkTogether<W>(a, nodes, begin, few, far);
  walkAlone<W>(a, nodes, few, far);
  walkByPower<W>(a, nodes, far);
  for (uint32_t i = 0; i < a.n; ++i) a.light[i] = a.probability[i] > 0 ? a.light[i] & ~light::kLeaf : light::kNone;
}

template <int W>
void probability(const ChooseArgs& a) {
  using F = Float<W>;
  using I = Int<W>;
  const light::LightTree& tree = *a.tree;
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
    const I which = gather(places, place + I(2));
    const Mask<W> lit = leaf != I(uint32_t(light::kNone));
    F p(0.f);
    I child(-1);
    Mask<W> byPower(false);
    for (uint32_t k = 0; k < tree.topCount(); ++k) {
      const Mask<W> is = lit & (which == I(k));
      p = select(is, top.p[k], p);
      if (links.all) byPower = byPower | (is & top.byPower[k]);
      child = select(is, I(nodes[tree.top()[k].node].child), child);
    }
    if (tree.isDeep()) {
      const F one(1.f), zero(0.f);
      Mask<W> open = (p > zero) & !isLeaf<W>(child);
      while (open.any()) {
        const I first = select(open, child, I(0));
        const InnerNode<W> left = nodeOfLanes<W>(nodes, first), right = nodeOfLanes<W>(nodes, first + I(1));
        F w0 = left.near.weight, w1 = right.near.weight;
        if (!(open & !byPower).none()) {
          w0 = select(byPower, w0, links.keep(first, left.importance(r)));
          w1 = select(byPower, w1, links.keep(first + I(1), right.importance(r)));
        }
        const F total = w0 + w1, p0 = shareOfFirst(w0, w1, total);
        const Mask<W> takesFirst = (path & I(1)) == I(0);
        p = select(open, zeroUnless(total > zero, p * select(takesFirst, p0, one - p0)), p);
        if (links.all)
          byPower = byPower | (open & ((takesFirst & left.isByPower(r)) | ((!takesFirst) & right.isByPower(r))));
        child = select(open, select(takesFirst, left.child, right.child), child);
        path = path.template shr<1>();
        open = open & !isLeaf<W>(child) & (p > zero);
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
