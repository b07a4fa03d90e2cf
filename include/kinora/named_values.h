// Parameter values by name for create() functions, and lists of parameters joined from shared parts. Used by
// light_setup.h, projection_setup.h and authors' own set-up code; plain, runs once a node. It checks numbers, it does
// not clamp ranges.
#pragma once
#include <kinora/plugin.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

namespace kinora {

// A help text that starts so marks a parameter which is read and kept, but changes nothing: "No effect yet. ..." and what
// it is for where it is to come, "No effect: ..." and why where it has no meaning here. Scenes that set it are told;
// "Accepted" is for what changes no picture anywhere (how much to say, the order of nodes), of which nobody is told.
inline constexpr std::string_view kNoEffect = "No effect";

// One list of parameters from several.
template <size_t... N>
constexpr auto joinParams(const std::array<Param, N>&... parts) {
  std::array<Param, (N + ...)> all{};
  size_t at = 0;
  const auto add = [&](const auto& part) {
    for (const Param& p : part) all[at++] = p;
  };
  (add(parts), ...);
  return all;
}

// Values by name: lists may grow without renumbering. Asking for a name that was not declared is our mistake.
class NamedValues {
 public:
  NamedValues(const CreateInfo& info, const Param* params, size_t count)
      : info_(info), params_(params), count_(count) {}
  uint32_t index(std::string_view name) const {
    for (size_t i = 0; i < count_ && i < info_.valueCount; ++i)
      if (name == params_[i].name) return uint32_t(i);
    throw "a parameter is read that was not declared";
  }
  // Numbers from a scene that are not finite would spread through every sample: the default is used instead.
  double number(std::string_view name, int component = 0) const {
    const uint32_t i = index(name);
    const ParamValue& v = info_.values[i];
    const double def = params_[i].value[component];
    if (!v.floats || v.count <= uint32_t(component)) return def;
    if (std::isfinite(v.floats[component])) return v.floats[component];
    warn("PARAM-NUMBER", "parameter '" + std::string(name) + "' is not a finite number", "its default is used");
    return def;
  }
  int integer(std::string_view name) const { return int(std::fmax(-1e9, std::fmin(1e9, number(name)))); }
  std::string string(std::string_view name) const {
    const char* s = info_.string(index(name));
    return s ? s : "";
  }
  bool given(std::string_view name) const { return info_.values[index(name)].given != 0; }
  void warn(const char* code, const std::string& what, const char* done) const {
    if (info_.host && info_.host->warn)
      info_.host->warn(info_.host->self, code, (std::string(info_.handle ? info_.handle : "") + ": " + what).c_str(),
                       done);
  }
  // One message that names every parameter which the scene sets to something other than its default in vain.
  void warnNoEffect() const {
    std::string names;
    for (size_t i = 0; i < count_ && i < info_.valueCount; ++i) {
      const Param& p = params_[i];
      const ParamValue& v = info_.values[i];
      if (!v.given || std::string_view(p.doc).substr(0, kNoEffect.size()) != kNoEffect) continue;
      bool differs = false;
      if (p.type == Type::String) {
        differs = v.count && v.strings && v.strings[0] && std::strcmp(v.strings[0], p.text) != 0;
      } else {
        const uint32_t known = p.flags & kParamArray ? p.listCount : 3;
        for (uint32_t c = 0; c < v.count && v.floats; ++c)
          differs = differs || c >= known || v.floats[c] != (p.flags & kParamArray ? p.list[c] : p.value[c]);
      }
      if (differs) names += (names.empty() ? "'" : ", '") + std::string(p.name) + "'";
    }
    if (!names.empty()) warn("PARAM-NO-EFFECT", "parameters without effect in this version: " + names, "ignored");
  }
  const CreateInfo& info() const { return info_; }

 private:
  const CreateInfo& info_;
  const Param* params_;
  size_t count_;
};

}  // namespace kinora
