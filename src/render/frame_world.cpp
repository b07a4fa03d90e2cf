#include "render/frame_world.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <utility>

#include "base/elapsed.h"
#include "base/memory.h"
#include "render/frame_warnings.h"

namespace kinora::render {

bool FrameWorld::build(const std::shared_ptr<const film::LightPaths>& paths) {
  paths_ = paths;
  isReady_ = buildWorld();
  if (isReady_) count();
  return isReady_;
}

bool FrameWorld::resume() {
  if (parts_.procedurals.resume(parts_.builder.contents()) && !buildNext()) return false;
  count();
  return true;
}

bool FrameWorld::readAll() {
  const Procedurals& procedurals = parts_.procedurals;
  while (!procedurals.delayed().unread.empty()) {
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < procedurals.delayed().unread.size(); ++i) all.push_back(procedurals.numberOfUnread(i));
    if (!change({}, all)) return false;
  }
  return true;
}

bool FrameWorld::buildWorld() {
  const FrameIntegrator& integrator = parts_.integrator;
  return parts_.builder.buildWorld(parts_.procedurals.scene(), parts_.procedurals.delayed(), paths_,
                                   integrator.setAskers(parts_.scene), integrator.aggregates(parts_.scene),
                                   parts_.statistics);
}

// In the place of the one before. Everything that does not follow from what is held is as it was.
bool FrameWorld::buildNext() {
  const auto start = std::chrono::steady_clock::now();
  isReady_ = false;
  const scene::Scene& whole = parts_.procedurals.scene();
  parts_.memory.setDescription(parts_.scene.bytes() + whole.bytes());
  parts_.builder.openShaders(whole);
  const std::vector<ShaderCost> before = std::move(parts_.statistics.shaders);
  parts_.diagnostics.setRepeating(true);
  isReady_ = buildWorld();
  parts_.diagnostics.setRepeating(false);
  addCosts(before);
  parts_.statistics.proceduralBuildSeconds += secondsSince(start);
  ++parts_.statistics.proceduralWorlds;
  return isReady_;
}

// Drops some procedurals, reads others, and makes a world of what is held then.
bool FrameWorld::change(const std::vector<uint32_t>& drop, const std::vector<uint32_t>& read) {
  Procedurals& procedurals = parts_.procedurals;
  // The world that goes holds what is dropped. Where that is too much beside what is read, another one takes its place
  // before.
  const uint64_t together = bytesWith(read);
  procedurals.drop(drop);
  if (!drop.empty() && together > budget()) {
    if (!buildNext()) return false;
    procedurals.countAsGone();
    malloc_trim(0);
  }
  const auto start = std::chrono::steady_clock::now();
  isReady_ = false;
  if (!readInOrder(read)) {
    isReady_ = true;  // of the world before, which is still there
    return false;
  }
  parts_.statistics.proceduralReadSeconds += secondsSince(start);
  if (!buildNext()) return false;
  if (!drop.empty()) malloc_trim(0);  // what was dropped is the system's again: the budget is for its sake
  measureRead();
  warnOfBounds(procedurals, parts_.builder, parts_.diagnostics);
  procedurals.settle();
  count();
  return true;
}

// Those inside of others once these are there. False when it was stopped.
bool FrameWorld::readInOrder(std::vector<uint32_t> which) {
  Procedurals& procedurals = parts_.procedurals;
  const std::atomic<bool>* stop = parts_.settings.stop;
  while (!which.empty()) {
    std::vector<uint32_t> now, later;
    for (const uint32_t k : which) {
      const uint32_t inside = procedurals.all()[k].inside;
      (inside == HeldProcedural::kNone || procedurals.all()[inside].isHeld ? now : later).push_back(k);
    }
    if (now.empty()) break;
    procedurals.read(now, parts_.builder.contents(), parts_.diagnostics, stop);
    if (stop && stop->load()) return false;
    which = std::move(later);
  }
  return true;
}

// How large what was read is, and where in its bounds it lies.
void FrameWorld::measureRead() {
  Procedurals& procedurals = parts_.procedurals;
  std::map<uint32_t, uint64_t> bytes;
  for (const Procedurals::Read& r : procedurals.lastRead()) bytes[r.instance];
  parts_.builder.findBytes(bytes);
  if (budget()) {
    std::map<uint32_t, std::vector<Imath::Box3d>> cells;
    for (const Procedurals::Read& r : procedurals.lastRead())
      if (!procedurals.hasCells(r.number)) cells[r.instance];
    parts_.builder.findCells(cells);
    for (const Procedurals::Read& r : procedurals.lastRead())
      if (const auto it = cells.find(r.instance); it != cells.end())
        procedurals.setCells(r.number, std::move(it->second));
  }
  for (const Procedurals::Read& r : procedurals.lastRead()) procedurals.setBytes(r.number, bytes[r.instance]);
}

void FrameWorld::count() {
  const Procedurals::Counts& c = parts_.procedurals.counts();
  Statistics& s = parts_.statistics;
  s.procedurals = c.met;
  s.proceduralsRead = c.read;
  s.proceduralsAgain = c.again;
  s.proceduralsDropped = c.dropped;
  s.proceduralBytes = c.bytes;
  s.proceduralMostBytes = c.mostBytes;
  s.proceduralLargest = c.largest;
  s.proceduralBudget = budget();
}

// Bytes that procedurals may hold: as much as the geometry cache where somebody has said how much that is, and a half
// of the limit on memory. 0: all of them.
uint64_t FrameWorld::budget() const {
  uint64_t budget = geometryCacheSaid(parts_.scene, parts_.settings);
  if (const uint64_t half = Memory::limit() / 2) budget = budget ? std::min(budget, half) : half;
  return budget;
}

// Of what is held, and of these.
uint64_t FrameWorld::bytesWith(const std::vector<uint32_t>& read) const {
  const std::vector<HeldProcedural>& all = parts_.procedurals.all();
  uint64_t bytes = 0;
  for (const HeldProcedural& p : all)
    if (p.isHeld) bytes += p.bytes;
  for (const uint32_t k : read) bytes += all[k].bytes;
  return bytes;
}

bool FrameWorld::readFor(std::vector<WaitingGroup*>& groups, bool keepsRecords) {
  Procedurals& procedurals = parts_.procedurals;
  std::vector<uint32_t> needed;
  const auto sortOut = [](std::vector<uint32_t>& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  };
  for (WaitingGroup* g : groups) {
    for (const uint32_t bound : g->met)
      for (uint32_t k = procedurals.numberOfUnread(parts_.builder.placeOfUnread(bound)); k != HeldProcedural::kNone;
           k = procedurals.all()[k].inside)
        g->needs.push_back(k);
    g->met.clear();
    sortOut(g->needs);
    needed.insert(needed.end(), g->needs.begin(), g->needs.end());
  }
  sortOut(needed);
  const uint64_t budgetSaid = budget();
  if (budgetSaid) procedurals.expectSizes(needed);
  // Records between stages name the objects and triangles of their vertices by places in the world, which are others
  // once something was dropped, and camera paths shade those vertices again.
  const uint64_t most = budgetSaid && !keepsRecords ? budgetSaid : std::numeric_limits<uint64_t>::max();
  const ReadingPlan p = planReading(groups, procedurals.all(), most);
  ++plans_;
  for (const WaitingGroup* g : groups)
    if (g->turn == WaitingGroup::Turn::Now)
      for (const uint32_t k : g->needs) procedurals.setNeeded(k, plans_);
  if (p.needed > most)
    parts_.diagnostics.warning(
        "RENDER-PROCEDURAL-BUDGET", parts_.scene.pos,
        fmt::format("paths that are followed together meet procedurals of {}, more than the {} that those may hold",
                    asBinaryBytes(p.needed), asBinaryBytes(most)),
        "they are held together", "a larger --geometry-cache, or archives with less in each");
  if (p.read.empty() && p.drop.empty()) return true;
  if (!change(p.drop, p.read)) return false;
  if (keepsRecords && budgetSaid && parts_.statistics.proceduralBytes > budgetSaid &&
      !std::exchange(saidAllIsHeld_, true))
    parts_.diagnostics.warning(
        "RENDER-PROCEDURAL-BUDGET", parts_.scene.pos,
        fmt::format("procedurals hold more than the {} that they may, and the records of light "
                    "paths name what is in them",
                    asBinaryBytes(budgetSaid)),
        "nothing that was read is dropped", "PxrPathTracer keeps no such records");
  return true;
}

// What programs of the world before have cost goes on to those of their names.
void FrameWorld::addCosts(const std::vector<ShaderCost>& before) {
  std::vector<ShaderCost>& shaders = parts_.statistics.shaders;
  for (const ShaderCost& was : before) {
    const auto is =
        std::find_if(shaders.begin(), shaders.end(), [&](const ShaderCost& c) { return c.name == was.name; });
    if (is != shaders.end()) is->addCost(was);
  }
}

}  // namespace kinora::render
