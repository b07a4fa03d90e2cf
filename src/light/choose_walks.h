// Ways of many points down the light tree, from its top nodes to one light each.
// Included per target.
#include "light/choose_nodes.h"

#include <utility>

#if defined(KINORA_LIGHT_CHOOSE_WALKS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LIGHT_CHOOSE_WALKS_H_TARGET
#undef KINORA_LIGHT_CHOOSE_WALKS_H_TARGET
#else
#define KINORA_LIGHT_CHOOSE_WALKS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
