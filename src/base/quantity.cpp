#include "base/quantity.h"

#include <charconv>
#include <cmath>
#include <string>

#include "base/text.h"

namespace kinora {

namespace {

// The number at the start of the text and what follows it, in lower case; false when there is none, or it is negative or
// not finite.
bool splitUnit(std::string_view text, double& value, std::string& unit) {
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || next == text.data() || !std::isfinite(value) || value < 0) return false;
  unit = lowerCase({next, end});
  return true;
}

}  // namespace

uint64_t parseSize(std::string_view text) {
  double value = 0;
  std::string unit;
  if (!splitUnit(text, value, unit)) return 0;
  if (unit.ends_with("ib"))
    unit.resize(unit.size() - 2);
  else if (unit.ends_with("b"))
    unit.resize(unit.size() - 1);
  static constexpr std::string_view kUnits = "kmgt";
  if (unit.size() > 1 || (unit.size() == 1 && kUnits.find(unit) == std::string::npos)) return 0;
  const double bytes = unit.empty() ? value : std::ldexp(value, 10 * (int(kUnits.find(unit)) + 1));
  return bytes >= 1 && bytes < 9e18 ? uint64_t(bytes) : 0;
}

std::optional<double> parseTime(std::string_view text) {
  double value = 0;
  std::string unit;
  if (!splitUnit(text, value, unit)) return std::nullopt;
  const double scale = unit.empty() || unit == "s"    ? 1
                       : unit == "m" || unit == "min" ? 60
                       : unit == "h"                  ? 3600
                       : unit == "d"                  ? 86400
                                                      : 0;
  if (scale == 0 || value * scale > 1e9) return std::nullopt;
  return value * scale;
}

}  // namespace kinora
