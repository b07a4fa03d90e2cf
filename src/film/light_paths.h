// Which outputs a contribution belongs to: the light path expressions of a frame's channels as one automaton that
// integrators step (kinora/integrator.h, PathStates), and the outputs of each state and kind of light. Built from a
// film's channels; materials ask it for the events of their lobes, render/ for the outputs.
#pragma once
#include <kinora/integrator.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "film/path_automaton.h"
#include "film/path_tails.h"
#include "scene/parameters.h"

namespace kinora::film {

// Source of a channel whose expression is malformed: render/ fills it with magenta, so that nobody misses it.
inline constexpr const char* kVisibleFallback = "(magenta)";

// Lobe numbers by the names that bxdfs declare: Option "lpe" "string specular4" "Clearcoat". Lobes of no list are
// number 1.
class LobeNumbers {
 public:
  LobeNumbers() : LobeNumbers(scene::ParameterList()) {}
  explicit LobeNumbers(const scene::ParameterList& options);
  int of(bool isSpecular, std::string_view lobe) const;  // 0..11, as in PathPattern::lobes

 private:
  std::map<std::string, int, std::less<>> diffuse_, specular_;
};

// Outputs of unshadowed light need integrators to tell it; see Contributions::kind.
enum class PathLight : uint8_t { AsItArrives, Unoccluded, Blocked };

class LightPaths {
 public:
  // `sources` are the record entries to fill: expressions ("lpe:C<RD>L") or names of the standard set; others are
  // ignored. needSplit: diffuse and specular must be told apart for other reasons (lights with different factors);
  // hasLightStage: there are paths from lights, which want tails.
  LightPaths(const std::vector<std::string>& sources, bool needSplit, LobeNumbers lobes = {},
             bool hasLightStage = false);

  PathStates states() const {
    return {automaton_.table().data(), automaton_.events(), automaton_.start(),
            tails_.next().data(),      tails_.end().data(), automaton_.states()};
  }
  const PathTails& tails() const { return tails_; }
  // Event of a lobe; bit 0 says specular. `surface`: the object's lpegroup.
  uint16_t event(uint32_t lobeFlags, std::string_view lobe = {}, std::string_view surface = {}) const;
  // True when objects' lpegroups are told apart: then they are part of what makes a shading program.
  bool usesSurface(std::string_view group) const;

  // Ends of paths: kGlow, or what end() says of a light's group.
  static constexpr uint16_t kGlow = 0;
  uint16_t end(std::string_view lightGroup) const;
  uint32_t ends() const { return automaton_.ends(); }
  uint32_t stateCount() const { return automaton_.states(); }
  // Indices into `sources` that a contribution in this state with this end adds to.
  const std::vector<uint16_t>& outputs(uint32_t state, uint32_t end) const;
  PathLight light(size_t source) const { return lights_[source]; }
  bool wantsUnshadowed() const;
  // Bit n: the source wants the signal of user lobe U(n+1) at the first surface.
  uint32_t userLobes(size_t source) const { return userLobes_[source]; }
  // What could not be had: sources whose expressions match no path, or are too large for one automaton.
  const std::vector<uint16_t>& unmatched() const { return unmatched_; }
  bool isTooLarge() const { return isTooLarge_; }

  // True for names of the standard set ("emissive", "directDiffuse" ...) and for all that begins with "lpe:".
  static bool knows(std::string_view source);
  // The expression of such a source; nothing with the error when it is malformed. Columns count from the source's
  // first character.
  static std::optional<PathExpression> parse(std::string_view source, PathSyntaxError& error);

 private:
  int labelOf(std::string_view text) const;
  LobeNumbers lobes_;
  PathAutomaton automaton_;
  PathTails tails_;
  std::vector<std::vector<uint16_t>> outputs_;  // by state and end
  std::vector<PathLight> lights_;
  std::vector<uint32_t> userLobes_;
  std::vector<uint16_t> unmatched_;
  bool isTooLarge_ = false;
};

}  // namespace kinora::film
