// One deterministic automaton for all light path expressions of a frame. A path steps a state number at each event;
// where it meets light, (state, kind of light) says which expressions take it. Built once a frame by light_paths.h;
// equal input gives equal numbers. It tells events apart only as far as some expression does.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "film/path_expression.h"

namespace kinora::film {

class PathAutomaton {
 public:
  static constexpr size_t kMostStates = 4096, kMostNodes = 1 << 14, kMostLabels = 30;
  // False when the expressions are too large: together they must stay in the bounds above, repetitions written out.
  // `splitSpecular`: diffuse and specular events are told apart for other reasons.
  bool build(const std::vector<PathExpression>& expressions, bool splitSpecular);

  uint32_t start() const { return 0; }
  uint32_t states() const { return states_; }
  uint32_t events() const { return events_; }
  uint32_t next(uint32_t state, uint32_t event) const { return next_[state * events_ + event]; }
  const std::vector<uint32_t>& table() const { return next_; }

  // The event of a lobe. Bit 0 says specular wherever the expressions (or splitSpecular) tell it from diffuse.
  // `types`: one bit of PathTypes; `lobe`: 0..11; labels of the surface and of the lobe, -1 when none of labels().
  uint32_t event(uint8_t types, int lobe, int surface, int name) const;
  const std::vector<std::string>& labels() const { return labels_; }
  const std::vector<std::string>& lightGroups() const { return lightGroups_; }

  // Where paths end: 0 at a glowing surface, 1 + i at a light of lightGroups()[i - 1] (1: of none of them).
  uint32_t ends() const { return 2 + uint32_t(lightGroups_.size()); }
  const std::vector<uint16_t>& accepted(uint32_t state, uint32_t end) const {
    return accepted_[state * ends() + end];
  }
  // Bit n: expression takes "C U(n+1) L", the signal of a user lobe of the first surface.
  uint32_t userLobes(size_t expression) const { return userLobes_[expression]; }
  // True when the expression takes some path.
  bool matches(size_t expression) const { return matches_[expression] != 0; }

 private:
  uint32_t rawEvent(uint8_t types, int lobe, int surface, int name) const;
  std::vector<std::string> labels_, lightGroups_;
  std::vector<uint16_t> eventOfRaw_;
  std::vector<uint32_t> next_;
  std::vector<std::vector<uint16_t>> accepted_;
  std::vector<uint32_t> userLobes_;
  std::vector<uint8_t> matches_;
  uint32_t states_ = 0, events_ = 0;
};

}  // namespace kinora::film
