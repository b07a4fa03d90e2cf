#include "shade/ramp_check.h"

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>

#include "base/text.h"

namespace kinora::shade {

void tellOfRamp(const scene::Node& node, Diagnostics& diagnostics) {
  if (!sameName(node.plugin, "PxrRamp")) return;
  const auto given = [&](std::string_view name) -> const scene::Parameter* {
    for (const scene::Parameter& p : node.params)
      if (sameName(p.name, name) && !p.isReference && !p.floats.empty()) return &p;
    return nullptr;
  };
  const scene::Parameter *knots = given("positions"), *colors = given("colors");
  if (!knots || !colors) knots = given("colorRamp_Knots"), colors = given("colorRamp_Colors");
  if (!knots && !colors) return;
  constexpr size_t kUsual = 4;  // of the ramp that is there where nothing is said
  const size_t places = knots ? knots->floats.size() : kUsual, shades = colors ? colors->floats.size() / 3 : kUsual;
  const std::string who = "the ramp of PxrRamp '" + node.handle + "' has ";
  if (places != shades)
    diagnostics.warning("PATTERN-RAMP", node.pos,
                        who + std::to_string(places) + " knots and " + std::to_string(shades) + " colours",
                        "the first " + std::to_string(std::min(places, shades)) + " of both are used");
  if (!knots) return;
  const auto& x = knots->floats;
  if (const auto at = std::adjacent_find(x.begin(), x.end(), std::greater<float>()); at != x.end())
    diagnostics.warning("PATTERN-RAMP", node.pos,
                        who + "knots that do not ascend: number " + std::to_string(at - x.begin() + 2) +
                            " lies before the one ahead of it",
                        "pieces of the ramp that go back are left out", "put knots, and their colours, in order");
}

}  // namespace kinora::shade
