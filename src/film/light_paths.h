// Which outputs a contribution belongs to: the automaton over light paths that integrators step (kinora/integrator.h,
// PathStates) and the outputs of each state. Built from a film's channels; read by the loop. This set of states tells
// apart the first event (reflected or transmitted, diffuse or specular) and whether more followed.
#pragma once
#include <kinora/integrator.h>

#include <string>
#include <string_view>
#include <vector>

namespace kinora::film {

class LightPaths {
 public:
  // `sources` are the record entries to fill: names of the standard set (see lightPathSources()), others are ignored.
  // needSplit: diffuse and specular must be told apart for other reasons (lights with different factors).
  LightPaths(const std::vector<std::string>& sources, bool needSplit);

  PathStates states() const { return {next_.data(), kEvents, 0}; }
  // Event of a lobe; bit 0 says specular.
  uint16_t event(uint32_t lobeFlags) const;
  // Indices into `sources` that a contribution in this state adds to. surfaceEmission: glow, else light.
  const std::vector<uint16_t>& outputs(uint16_t state) const { return outputs_[state]; }
  uint32_t stateCount() const { return kStates; }
  static const char* eventName(uint16_t event);   // "RD", "RS", "TD", "TS"

  // Names that this automaton knows: "Ci", "emissive", "directDiffuse" ...
  static bool knows(std::string_view source);

 private:
  static constexpr uint32_t kEvents = 4, kStates = 1 + 4 * 2;
  bool split_ = false;
  std::vector<uint32_t> next_;
  std::vector<std::vector<uint16_t>> outputs_;
};

}  // namespace kinora::film
