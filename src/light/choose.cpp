// Kernels of choose.h.
#define KINORA_KERNEL_FILE "light/choose.cpp"
#include "light/choose.h"

#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include "light/choose_walks.h"

KINORA_KERNELS_BEGIN
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

KN_POINTERS(kChoose, choose)
KN_POINTERS(kProbability, probability)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::light {
ChooseKernel chooseKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kChoose); }
ChooseKernel probabilityKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kProbability); }
}  // namespace kinora::light
#endif
