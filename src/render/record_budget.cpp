#include "render/record_budget.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <string_view>

#include "base/memory.h"

namespace kinora::render {

namespace {
constexpr const char* kKept = "keptPaths";
}  // namespace

void RecordBudget::fit(const Of& of, int first, int last) {
  const Descriptor& plugin = *of.integrator.plugin();
  if (!Memory::limit() || !of.frame.store()) return;
  const Param* given = std::find_if(plugin.params, plugin.params + plugin.paramCount,
                                    [&](const Param& p) { return std::string_view(p.name) == kKept; });
  if (given == plugin.params + plugin.paramCount) return;
  const int block = first ? int(std::bit_floor(uint32_t(first))) : 0;
  if (block_ == block) return;
  if (block_ < 0) {
    // Textures and arenas take some of what is left yet. Halves of the limit: what threads have of their own hardly ever
    // decides which.
    budget_ = Memory::limit();
    while (budget_ > Memory::left() / 8 * 3) budget_ /= 2;
  }
  block_ = block;
  float share = 1;
  uint64_t needed = 0;
  constexpr float kLeast = 1.f / (1 << 18);
  for (;;) {
    keep(of, given->value[0], share);
    try {
      needed = of.frame.foreseenRecords(std::max(2 * block - 1, 0)) * uint64_t(last - first);
    } catch (const MemoryExceeded&) {
      if (!(share > kLeast)) throw;
      share /= 16;
      continue;
    }
    if (needed <= budget_ || !(share > kLeast)) break;
    while (needed > budget_ && share > kLeast) {
      share /= 2;
      needed /= 2;
    }
  }
  if (share < told_) {
    told_ = share;
    char text[64];
    std::snprintf(text, sizeof text, "one light path in %.0f is kept", double(1 / share));
    of.diagnostics.warning("MEMORY-RECORDS", of.scene.integrator ? of.scene.integrator->pos : SourcePos{},
                           "what " + std::string(plugin.name) + " keeps of its light paths does not fit into the " +
                               asBinaryBytes(budget_) + " that --memory-limit leaves for it",
                           std::string(text) + " for camera paths to find: more noise, the same mean",
                           "raise --memory-limit");
  }
}

// The integrator's node with that share of what it says.
void RecordBudget::keep(const Of& of, float byDefault, float share) {
  if (share == share_) return;
  share_ = share;
  scene::Node node;
  node.kind = "Integrator";
  node.plugin = of.integrator.plugin()->name;
  if (of.scene.integrator && of.scene.integrator->plugin == node.plugin) node = *of.scene.integrator;
  scene::Parameter p;
  p.name = kKept;
  p.floats = {share * node.params.getFloat(kKept, byDefault)};
  node.params.set(std::move(p));
  Diagnostics quiet([](const std::string&, Severity) {});  // it was told of all there is
  if (integrator_.create(*of.integrator.plugin(), &node, nullptr, nullptr, of.host, quiet))
    of.frame.setIntegratorData(integrator_.data());
}

}  // namespace kinora::render
