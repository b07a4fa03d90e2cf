#include "render/reading_plan.h"

#include <algorithm>
#include <tuple>

namespace kinora::render {

namespace {

constexpr size_t kNever = std::numeric_limits<size_t>::max();

}  // namespace

ReadingPlan planReading(std::vector<WaitingGroup*>& groups, const std::vector<HeldProcedural>& procedurals,
                        uint64_t budget) {
  using Turn = WaitingGroup::Turn;
  ReadingPlan plan;
  const auto bytesOf = [&](const WaitingGroup& g) {
    uint64_t sum = 0;
    for (const uint32_t p : g.needs) sum += procedurals[p].bytes;
    return sum;
  };
  // The group that lacks least begins; of equals the first.
  size_t first = kNever;
  uint64_t least = 0;
  bool isHalved = false;
  for (size_t i = 0; i < groups.size(); ++i) {
    WaitingGroup& g = *groups[i];
    g.turn = Turn::Later;
    if (!g.isWhole && bytesOf(g) > budget) {
      g.turn = Turn::Halves;
      isHalved = true;
      continue;
    }
    uint64_t lacking = 0;
    for (const uint32_t p : g.needs)
      if (!procedurals[p].isHeld) lacking += procedurals[p].bytes;
    if (first == kNever || lacking < least) {
      first = i;
      least = lacking;
    }
  }
  std::vector<uint8_t> isNeeded(procedurals.size(), 0);
  const auto join = [&](WaitingGroup& g, uint64_t most) {
    uint64_t more = 0;
    for (const uint32_t p : g.needs)
      if (!isNeeded[p]) more += procedurals[p].bytes;
    if (plan.groups && more > 0 && plan.needed + more > most) return;
    for (const uint32_t p : g.needs) isNeeded[p] = 1;
    plan.needed += more;
    ++plan.groups;
    g.turn = Turn::Now;
  };
  if (first != kNever) {
    const uint64_t most = std::max(budget, bytesOf(*groups[first]));
    // neighbours in the list are neighbours in the picture
    for (size_t k = 0; k < groups.size(); ++k) {
      WaitingGroup& g = *groups[(first + k) % groups.size()];
      if (g.turn == Turn::Later) join(g, most);
    }
  }
  // What is needed again last goes first (L. A. Belady, "A study of replacement algorithms for a virtual-storage
  // computer", 1966), as far as it is known; of the others what was not needed for longest.
  std::vector<size_t> next(procedurals.size(), kNever);
  for (size_t i = groups.size(); i-- > 0;)
    if (groups[i]->turn == Turn::Later)
      for (const uint32_t p : groups[i]->needs) next[p] = i;
  uint64_t held = plan.needed;
  std::vector<uint32_t> spare;
  const auto depth = [&](uint32_t p) {
    uint32_t d = 0;
    for (; procedurals[p].inside != HeldProcedural::kNone; p = procedurals[p].inside) ++d;
    return d;
  };
  for (uint32_t p = 0; p < procedurals.size(); ++p) {
    if (isNeeded[p] && !procedurals[p].isHeld) plan.read.push_back(p);
    if (!procedurals[p].isHeld || isNeeded[p]) continue;
    held += procedurals[p].bytes;
    spare.push_back(p);
  }
  // halves find out first what they need; nothing has to go for that
  if (held <= budget || (plan.groups == 0 && isHalved)) return plan;
  // one that holds others is needed when they are: it comes behind them
  std::vector<std::tuple<size_t, uint64_t, uint32_t, uint32_t>> order;
  for (const uint32_t p : spare) order.emplace_back(~next[p], procedurals[p].lastNeeded, ~depth(p), p);
  std::sort(order.begin(), order.end());
  for (const auto& entry : order) {
    if (held <= budget) break;
    const uint32_t p = std::get<3>(entry);
    held -= procedurals[p].bytes;
    plan.drop.push_back(p);
  }
  return plan;
}

}  // namespace kinora::render
