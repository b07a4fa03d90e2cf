// Parameter settings of a plug-in: read from text ("name=v v v; name=v", as in BxdfTraits::lossless), or derived from
// the declared parameters so that no list has to be kept. Called by the checks and by tests; runs no plug-in code.
#pragma once
#include <kinora/plugin.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::testing {

// A value for each declared parameter of one plug-in.
struct Setting {
  std::string text;                         // what differs from the defaults; "defaults" when nothing does
  std::vector<std::vector<float>> numbers;  // by parameter; empty for strings and structs
  std::vector<std::vector<std::string>> strings;
  std::vector<bool> given;
};

Setting defaultSetting(const Descriptor& d);
// False with a message for a malformed pair, an unknown name or the wrong number of values. Names match exactly.
bool parseSetting(const Descriptor& d, std::string_view text, Setting& out, std::string& error);

// Settings that cover the declared ranges: the defaults; each parameter alone at both ends of its range (all values
// of choices); rows in which each pair of parameters takes each pair of (low, default, high); `randomCount` random
// points.
std::vector<Setting> coveringSettings(const Descriptor& d, uint32_t randomCount, uint64_t seed);

// The setting as create() and programKey() see it; points into the setting, which must live as long.
class ResolvedValues {
 public:
  ResolvedValues(const Descriptor& d, const Setting& s);
  const ParamValue* data() const { return values_.data(); }
  uint32_t count() const { return uint32_t(values_.size()); }

 private:
  std::vector<std::vector<const char*>> pointers_;
  std::vector<ParamValue> values_;
};

}  // namespace kinora::testing
